// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/recordings.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/law_likelihood.hpp"
#include "law/law_search.hpp"
#include "numerics/distributions.hpp"
#include "numerics/linalg.hpp"
#include "numerics/maximise.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kFewestOfRecording = 3;
constexpr std::size_t kFewestBetweenDrops = 10;  // degrees of freedom; below, F would have next to no power
constexpr std::size_t kManyRecordings = 100;     // recordings: rows in a third of the time from there on
constexpr double kSearch = 0.02;                 // of the whitened gradient: the likelihood ratio is good to 1e-3

/// Samples in groups. The curve is that of the reference group; every other one has a constant offset in eps from it.
struct Groups {
  std::vector<std::size_t> of_sample;  ///< 0 ... n_groups - 1, none empty
  std::size_t n_groups = 0;
  std::size_t reference = 0;
};

/// Samples of the recordings that can be compared, in order of speed.
struct Compared {
  LawData data;
  Groups one, recordings, drops;
};

std::vector<RestitutionSamples> by_recording(const RestitutionSamples& samples) {
  std::map<std::string, std::size_t> numbers;
  std::vector<RestitutionSamples> groups;
  for (const RestitutionSample& s : samples) {
    const std::size_t number = numbers.try_emplace(s.recording, groups.size()).first->second;
    if (number == groups.size()) groups.emplace_back();
    groups[number].push_back(s);
  }
  return groups;
}

/// The largest of those that `may_be`.
template <class MayBe>
std::size_t largest(const Groups& groups, const MayBe& may_be) {
  std::vector<std::size_t> n(groups.n_groups, 0);
  for (std::size_t k = 0; k < groups.of_sample.size(); ++k)
    if (may_be(k)) ++n[groups.of_sample[k]];
  return static_cast<std::size_t>(std::max_element(n.begin(), n.end()) - n.begin());
}

Compared compared(const std::vector<RestitutionSamples>& recordings) {
  constexpr double kEpsResolution = 1e-8;  // of eps, as in fit_law
  std::vector<std::pair<const RestitutionSample*, std::size_t>> places;
  Compared result;
  for (const RestitutionSamples& samples : recordings) {
    if (samples.size() < kFewestOfRecording) continue;
    for (const RestitutionSample& s : samples) places.emplace_back(&s, result.recordings.n_groups);
    ++result.recordings.n_groups;
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const auto& a, const auto& b) { return a.first->v_mps < b.first->v_mps; });
  std::map<std::pair<std::size_t, std::int64_t>, std::size_t> drops;
  for (const auto& [sample, recording] : places) {
    result.data.v_mps.push_back(sample->v_mps);
    result.data.eps.push_back(sample->eps);
    result.data.tau.push_back(hypot(sample->sigma_eps.value_or(0.0), kEpsResolution));
    result.recordings.of_sample.push_back(recording);
    result.drops.of_sample.push_back(drops.try_emplace({recording, sample->drop}, drops.size()).first->second);
  }
  result.data.drop = result.drops.of_sample;
  result.drops.n_groups = drops.size();
  result.one = {std::vector<std::size_t>(places.size(), 0), 1, 0};
  if (places.empty()) return result;
  const std::size_t reference = largest(result.recordings, [](std::size_t) { return true; });
  result.recordings.reference = reference;
  // so that offsets by recording are among those by drop
  result.drops.reference =
      largest(result.drops, [&](std::size_t k) { return result.recordings.of_sample[k] == reference; });
  return result;
}

/// Likelihood of curve and scatter with these offsets at their best for every theta (profile likelihood).
class OffsetLikelihood {
 public:
  OffsetLikelihood(const LawData& data, const Groups& groups, const LawModel& model, const ScatterFamily& scatter);
  OffsetLikelihood(const OffsetLikelihood&) = delete;
  OffsetLikelihood& operator=(const OffsetLikelihood&) = delete;

  /// The gradient is that at fixed offsets: where they are at their best, they do not add to it.
  double operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient);

  /// At the theta of the last call.
  struct Offset {
    double value = 0.0;
    double se = 0.0;  ///< curve and scatter known; from the squares of the scores. Of the reference likewise
  };
  const std::vector<Offset>& offsets() const { return offsets_; }
  const LawLikelihood& likelihood() const { return likelihood_; }

 private:
  Offset best_offset(const Eigen::VectorXd& theta, std::size_t group);

  const LawData& data_;
  LawData shifted_;  ///< less the offsets
  LawLikelihood likelihood_;
  std::size_t reference_;
  std::vector<std::vector<std::size_t>> members_;
  std::vector<Offset> offsets_;
};

constexpr double kCloseEnough = 1e-3;  // of a standard error: costs 1e-6 of the log-likelihood
constexpr int kMostSteps = 60;

struct Point {
  double x = 0.0;
  LawLikelihood::LocationScore score;
};

/// Where the score is 0. It falls but for samples so far off that they count as lost: from `start`, which is amidst
/// the samples, steps of at most twice their scatter find a change of sign, regula falsi (Illinois) the place.
template <class Function>
Point root_of(const Function& score_at, double start, double n) {
  Point a{start, score_at(start)}, b = a;
  const auto is_close = [](const Point& p) {
    return std::abs(p.score.sum) <= kCloseEnough * std::sqrt(p.score.squares);
  };
  for (int k = 0; k < kMostSteps && a.score.sum * b.score.sum >= 0.0; ++k) {
    if (is_close(b) || !(b.score.squares > 0.0)) return b;
    a = b;
    const double most = 2.0 * std::sqrt(n / a.score.squares);
    b.x = a.x + std::clamp(a.score.sum / a.score.squares, -most, most);
    b.score = score_at(b.x);
  }
  double at_a = a.score.sum, at_b = b.score.sum;
  for (int k = 0; k < kMostSteps && !is_close(b); ++k) {
    if (std::abs(b.x - a.x) * std::sqrt(b.score.squares) < kCloseEnough) break;
    Point c;
    c.x = b.x - at_b * (b.x - a.x) / (at_b - at_a);
    c.score = score_at(c.x);
    if (c.score.sum * at_b < 0.0) {
      a = b;
      at_a = at_b;
    } else {
      at_a *= 0.5;
    }
    b = c;
    at_b = c.score.sum;
  }
  return b;
}

OffsetLikelihood::OffsetLikelihood(const LawData& data, const Groups& groups, const LawModel& model,
                                   const ScatterFamily& scatter)
    : data_(data),
      shifted_(data),
      likelihood_(shifted_, model, scatter),
      reference_(groups.reference),
      members_(groups.n_groups),
      offsets_(groups.n_groups) {
  for (std::size_t k = 0; k < groups.of_sample.size(); ++k) members_[groups.of_sample[k]].push_back(k);
}

OffsetLikelihood::Offset OffsetLikelihood::best_offset(const Eigen::VectorXd& theta, std::size_t group) {
  const std::vector<std::size_t>& members = members_[group];
  std::vector<double> residuals;
  for (const std::size_t k : members) {
    shifted_.eps[k] = data_.eps[k];
    residuals.push_back(data_.eps[k] - likelihood_.eps_of(theta, k));
  }
  const std::vector<SampleBlock> samples = likelihood_.gathered(theta, members);
  const auto score_at = [&](double offset) { return likelihood_.location_score(samples, offset); };
  if (group == reference_) return {0.0, 1.0 / std::sqrt(score_at(0.0).squares)};
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  const Point best = root_of(score_at, *middle, static_cast<double>(members.size()));
  return {best.x, 1.0 / std::sqrt(best.score.squares)};
}

double OffsetLikelihood::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) {
  if (!theta.allFinite()) return -HUGE_VAL;
  parallel_for(members_.size(), 0, [&](std::size_t g) {
    offsets_[g] = best_offset(theta, g);
    for (const std::size_t k : members_[g]) shifted_.eps[k] = data_.eps[k] - offsets_[g].value;
  });
  return likelihood_(theta, gradient);
}

/// Degrees of freedom that the curve and the offsets take together: the rank of the derivatives by q and of a constant
/// for each group but the reference.
std::size_t rank_with_offsets(const LawData& data, const LawModel& model, const Eigen::VectorXd& q,
                              const Groups& groups) {
  constexpr double kIndependent = 1e-9;  // of the unit diagonal
  const Eigen::MatrixXd x = model.jacobian(data.v_mps, q);
  Eigen::MatrixXd products = transposed_product(x, x);
  const Eigen::VectorXd scale = products.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(x.cols(), static_cast<Eigen::Index>(groups.n_groups));
  Eigen::VectorXd n = Eigen::VectorXd::Zero(sums.cols());
  for (std::size_t k = 0; k < groups.of_sample.size(); ++k) {
    if (groups.of_sample[k] == groups.reference) continue;
    const auto g = static_cast<Eigen::Index>(groups.of_sample[k]);
    sums.col(g) += x.row(static_cast<Eigen::Index>(k)).transpose();
    n[g] += 1.0;
  }
  n[static_cast<Eigen::Index>(groups.reference)] = 1.0;
  products -= gram(sums * n.cwiseInverse().cwiseSqrt().asDiagonal());
  const Eigen::VectorXd spectrum = eigenvalues(scale.asDiagonal() * products * scale.asDiagonal());
  return groups.n_groups - 1 + static_cast<std::size_t>((spectrum.array() > kIndependent).count());
}

ScatterFamily family_of(const LawFit& pooled) {
  return {ScatterKind::normal_laplace, pooled.scatter->log_below.size(), pooled.scatter->v_ref_mps};
}

/// Of one curve and one scatter, and of offsets by recording or drop beside them.
struct Likelihoods {
  double one = 0.0, by_recording = 0.0, by_drop = 0.0;
  std::vector<OffsetLikelihood::Offset> offsets;  ///< by recording
  Eigen::VectorXd q;
};

/// Curve and size of the scatter at their best beside the offsets. The shape of the scatter stays that of one curve:
/// for few samples its parameters would follow what the offsets make of the residuals, and F would be too large.
double with_offsets(OffsetLikelihood& offsets, const Eigen::VectorXd& one) {
  const LawLikelihood& likelihood = offsets.likelihood();
  const ScatterFamily& scatter = likelihood.scatter();
  const Eigen::Index n_law = likelihood.model().n_parameters();
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(one.size(), n_law + 1);
  directions.topLeftCorner(n_law, n_law).setIdentity();
  directions(n_law, n_law) = 1.0;
  if (scatter.is_two_sided()) directions(n_law + static_cast<Eigen::Index>(scatter.n_terms), n_law) = 1.0;
  const LogLikelihood function = [&](const Eigen::VectorXd& y, Eigen::VectorXd* gradient) {
    const double value = offsets(one + product(directions, y), gradient);
    if (gradient) *gradient = transposed_product(directions, *gradient);
    return value;
  };
  const Maximum maximum = maximise(function, Eigen::VectorXd::Zero(n_law + 1),
                                   congruence(directions, likelihood.information(one)), kSearch);
  function(maximum.x, nullptr);
  return maximum.loglik;
}

std::optional<Likelihoods> likelihoods(const Compared& samples, const LawModel& model, const ScatterFamily& family) {
  LawData data = samples.data;
  const Eigen::VectorXd start = start_values(data, model, family);
  if (start.size() == 0) return std::nullopt;
  widen(data, scatter_model_of(start, model.n_parameters(), family),
        std::sqrt(static_cast<double>(model.n_parameters()) / static_cast<double>(data.size())));
  const LawLikelihood likelihood(data, model, family);
  const Maximum one = maximise([&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); }, start,
                               likelihood.information(start), kSearch);
  OffsetLikelihood recordings(data, samples.recordings, model, family);
  const double by_recording = with_offsets(recordings, one.x);
  Likelihoods result{one.loglik, by_recording, by_recording, recordings.offsets(), one.x.head(model.n_parameters())};
  if (samples.drops.n_groups >= samples.recordings.n_groups + kFewestBetweenDrops) {
    OffsetLikelihood drops(data, samples.drops, model, family);
    result.by_drop = with_offsets(drops, one.x);
  }
  return result;
}

struct Agreement {
  RecordingsTest test;
  std::vector<OffsetLikelihood::Offset> offsets;
};

std::optional<Agreement> agreement(const std::vector<RestitutionSamples>& recordings, const LawFitConfig& config,
                                   const LawFit& pooled) {
  const Compared samples = compared(recordings);
  if (samples.recordings.n_groups < 2 || !pooled.scatter) return std::nullopt;
  const std::vector<int> orders(
      config.orders.begin(),
      config.orders.begin() + static_cast<std::ptrdiff_t>(std::min(config.orders.size(), pooled.parameters.size())));
  const LawModel model = make_law_model(pooled.kind, orders, samples.data.v_mps);
  const auto found = likelihoods(samples, model, family_of(pooled));
  if (!found) return std::nullopt;
  const auto rank_of = [&](const Groups& groups) { return rank_with_offsets(samples.data, model, found->q, groups); };
  const std::size_t rank = rank_of(samples.one), rank_1 = rank_of(samples.recordings), rank_2 = rank_of(samples.drops);
  const std::size_t n = samples.data.size();
  if (rank_1 <= rank || rank_1 >= n) return std::nullopt;
  Agreement result;
  RecordingsTest& test = result.test;
  test.n_recordings = samples.recordings.n_groups;
  test.likelihood_ratio = std::max(0.0, 2.0 * (found->by_recording - found->one));
  test.ndf = static_cast<double>(rank_1 - rank);
  const double between = expm1(test.likelihood_ratio / static_cast<double>(n)) / test.ndf;
  if (rank_2 >= rank_1 + kFewestBetweenDrops && rank_2 < n) {
    test.within = WithinUnit::drops;
    test.ndf_within = static_cast<double>(rank_2 - rank_1);
    const double ratio = std::max(0.0, 2.0 * (found->by_drop - found->by_recording));
    test.f = between * test.ndf_within / -expm1(-ratio / static_cast<double>(n));
  } else {
    test.ndf_within = static_cast<double>(n - rank_1);
    test.f = between * test.ndf_within;
  }
  test.p_value = f_survival(test.f, test.ndf, test.ndf_within);
  result.offsets = found->offsets;
  return result;
}

RecordingFit row_of(const RestitutionSamples& samples, LawFitConfig config, const LawFit& pooled, bool is_one_of_many) {
  RecordingFit row;
  row.recording = samples.front().recording;
  std::set<std::int64_t> drops;
  std::vector<double> v;
  for (const RestitutionSample& s : samples) {
    drops.insert(s.drop);
    v.push_back(s.v_mps);
  }
  std::sort(v.begin(), v.end());
  row.n_drops = drops.size();
  row.v_lo_mps = v.front();
  row.v_hi_mps = v.back();
  config.node_speeds_mps.clear();
  for (const NodeEstimate& node : pooled.nodes)
    if (node.v_mps >= row.v_lo_mps && node.v_mps <= row.v_hi_mps) config.node_speeds_mps.push_back(node.v_mps);
  if (config.node_speeds_mps.empty()) config.node_speeds_mps = {v[v.size() / 2]};
  config.n_goodness = config.n_bootstrap = 0;
  config.compare_laws = false;
  if (is_one_of_many) {
    constexpr std::size_t kWidthKnown = 30;  // below, fit_law takes one term without a choice
    config.intervals = IntervalMethod::covariance;
    if (config.n_scatter_terms == 0 && samples.size() >= kWidthKnown) config.n_scatter_terms = 2;
  }
  LawFit fit = fit_law(samples, config);
  row.n = fit.n;
  row.n_outliers = fit.outliers.size();
  row.status = fit.status;
  row.why = fit.why;
  row.kind = fit.kind;
  row.nodes = std::move(fit.nodes);
  row.parameters = std::move(fit.parameters);
  return row;
}

/// Offsets about their mean over all samples.
void add_offsets(const std::vector<OffsetLikelihood::Offset>& offsets,
                 const std::vector<RestitutionSamples>& recordings, std::vector<RecordingFit>& rows) {
  double mean = 0.0, n = 0.0;
  auto next = offsets.begin();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (recordings[k].size() < kFewestOfRecording) continue;
    const auto size = static_cast<double>(recordings[k].size());
    rows[k].offset = normal_estimate(next->value, next->se);
    mean += size * next->value;
    n += size;
    ++next;
  }
  for (RecordingFit& row : rows)
    if (row.offset) row.offset = normal_estimate(row.offset->value - mean / n, *row.offset->se);
}

}  // namespace

bool disagree(const Recordings& recordings) {
  constexpr double kDoubt = 0.01;
  return recordings.test && recordings.test->p_value < kDoubt;
}

const char* to_string(WithinUnit unit) { return unit == WithinUnit::drops ? "drops" : "samples"; }

Recordings compare_recordings(const RestitutionSamples& samples, const LawFitConfig& config, const LawFit& pooled) {
  const std::vector<RestitutionSamples> recordings = by_recording(samples);
  if (recordings.size() < 2) return {};
  Recordings result;
  result.rows.resize(recordings.size());
  with_threads(0, [&] {
    parallel_for(recordings.size(), 0, [&](std::size_t k) {
      result.rows[k] = row_of(recordings[k], config, pooled, recordings.size() > kManyRecordings);
    });
    if (const auto found = agreement(recordings, config, pooled)) {
      result.test = found->test;
      add_offsets(found->offsets, recordings, result.rows);
    }
  });
  return result;
}

}  // namespace bouncelab::fit
