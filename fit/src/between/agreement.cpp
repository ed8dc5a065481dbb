// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/recordings.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "law/law_model.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {

namespace {

/// Samples by unit, which is a drop or a recording: columns of equal length.
struct UnitSamples {
  std::vector<double> residual;          ///< of eps from a curve of all
  std::vector<double> weight;            ///< 1 / variance of the scatter and of the timing, but for a factor
  Eigen::MatrixXd curve;                 ///< a row a sample: what may be wrong about the curve, as d eps
  std::vector<std::size_t> group, unit;  ///< each sample's, from 0, none left out; a unit is of one group
  std::size_t n_groups = 0, n_units = 0;
  bool are_recordings = false;  ///< the units
};

/// Means of the units, a constant of eps for each beside one curve by weighted least squares, and what they leave.
struct UnitMeans {
  std::vector<double> mean, weight;  ///< of each unit: its offset from the curve; the sum of its samples' weights
  double squares = 0.0;              ///< weighted sum of squares about curve and means
  std::size_t n_free = 0;            ///< its degrees of freedom
};

/// @param unit  of each sample: samples.group, samples.unit
UnitMeans unit_means(const UnitSamples& samples, const std::vector<std::size_t>& unit, std::size_t n_units) {
  constexpr double kIndependent = 1e-9;  // of the curve's own squares: less of it is left beside the means
  const Eigen::Index n_curve = samples.curve.cols();
  UnitMeans result{std::vector<double>(n_units, 0.0), std::vector<double>(n_units, 0.0)};
  Eigen::MatrixXd of_curve = Eigen::MatrixXd::Zero(n_curve, static_cast<Eigen::Index>(n_units));  // means of its rows
  for (std::size_t k = 0; k < unit.size(); ++k) {
    result.weight[unit[k]] += samples.weight[k];
    result.mean[unit[k]] += samples.weight[k] * samples.residual[k];
    of_curve.col(static_cast<Eigen::Index>(unit[k])) +=
        samples.weight[k] * samples.curve.row(static_cast<Eigen::Index>(k)).transpose();
  }
  for (std::size_t u = 0; u < n_units; ++u) {
    result.mean[u] /= result.weight[u];
    of_curve.col(static_cast<Eigen::Index>(u)) /= result.weight[u];
  }
  // the curve by what samples are off the means of their units
  Eigen::MatrixXd rows(samples.curve.rows(), n_curve);
  Eigen::VectorXd off(samples.curve.rows());
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(n_curve);
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double root = std::sqrt(samples.weight[i]);
    scale += (root * samples.curve.row(k).transpose()).cwiseAbs2();
    rows.row(k) = root * (samples.curve.row(k) - of_curve.col(static_cast<Eigen::Index>(unit[i])).transpose());
    off[k] = root * (samples.residual[i] - result.mean[unit[i]]);
  }
  const Eigen::MatrixXd scaled = rows * scale.cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd products = transposed_product(scaled, scaled);
  const auto rank = static_cast<std::size_t>((eigenvalues(products).array() > kIndependent).count());
  // directions that the units leave nothing of stay where they are
  const Eigen::MatrixXd ridge = 1e-12 * Eigen::MatrixXd::Identity(n_curve, n_curve);
  const Eigen::VectorXd q = cholesky(products + ridge)->solve(transposed_product(scaled, off));
  result.squares = (off - product(scaled, q)).squaredNorm();
  const Eigen::VectorXd moved =
      transposed_product(scale.cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal() * of_curve, q);
  for (std::size_t u = 0; u < n_units; ++u) result.mean[u] -= moved[static_cast<Eigen::Index>(u)];
  const std::size_t taken = n_units + rank;
  result.n_free = unit.size() > taken ? unit.size() - taken : 0;
  return result;
}

struct Agreement {
  RecordingsTest test;
  std::vector<Estimate> offsets;  ///< of each group, their mean over all samples 0
};

/// Do the groups differ by more than what is within them? See RecordingsTest.
/// @return absent where fewer than two groups can be told from the curve
std::optional<Agreement> agreement(const UnitSamples& samples) {
  constexpr std::size_t kFewestBetweenDrops = 10;  // degrees of freedom; below, F would have next to no power
  const std::size_t n = samples.residual.size();
  if (samples.n_groups < 2 || n == 0) return std::nullopt;
  const UnitMeans one = unit_means(samples, std::vector<std::size_t>(n, 0), 1);
  const UnitMeans groups = unit_means(samples, samples.group, samples.n_groups);
  const UnitMeans drops = unit_means(samples, samples.unit, samples.n_units);
  if (groups.n_free >= one.n_free || groups.n_free == 0) return std::nullopt;
  Agreement result;
  RecordingsTest& test = result.test;
  test.n_recordings = samples.n_groups;
  test.ndf = static_cast<double>(one.n_free - groups.n_free);
  double squares_within = groups.squares;
  test.ndf_within = static_cast<double>(groups.n_free);
  const std::size_t fewest = samples.are_recordings ? 1 : kFewestBetweenDrops;
  if (groups.n_free >= drops.n_free + fewest && drops.n_free > 0) {
    test.within = samples.are_recordings ? WithinUnit::recordings : WithinUnit::drops;
    squares_within = std::max(0.0, groups.squares - drops.squares);
    test.ndf_within = static_cast<double>(groups.n_free - drops.n_free);
  }
  const double between = std::max(0.0, one.squares - groups.squares);
  test.f = between / test.ndf / (squares_within / test.ndf_within);
  test.p_value = f_survival(test.f, test.ndf, test.ndf_within);
  test.likelihood_ratio = static_cast<double>(n) * log(one.squares / groups.squares);
  double mean = 0.0;
  for (const std::size_t g : samples.group) mean += groups.mean[g] / static_cast<double>(n);
  const double variance = groups.squares / static_cast<double>(groups.n_free);
  for (std::size_t g = 0; g < samples.n_groups; ++g)
    result.offsets.push_back(normal_estimate(groups.mean[g] - mean, std::sqrt(variance / groups.weight[g])));
  return result;
}

constexpr std::size_t kFewestOfRecording = 3;
constexpr std::size_t kManyRecordings = 100;  // recordings: rows in a third of the time from there on

using Row = std::pair<std::string, RestitutionSamples>;

/// The samples that recordings keep, about the curve of all.
UnitSamples units_of(const std::vector<Row>& recordings, const std::vector<RecordingFit>& rows,
                     const LawFitConfig& config, const LawFit& pooled) {
  UnitSamples units;
  units.are_recordings = std::any_of(rows.begin(), rows.end(), disagree_within);
  RestitutionSamples kept;
  std::map<std::tuple<std::size_t, std::string, std::int64_t>, std::size_t> numbers;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const RestitutionSamples& samples = recordings[r].second;
    if (samples.size() < kFewestOfRecording) continue;
    const PartOfSamples part(samples, rows[r].law.outliers);
    for (const RestitutionSample& s : *part) {
      kept.push_back(s);
      units.weight.push_back(1.0 / (pooled.scatter->variance(s.v_mps) + square(s.sigma_eps.value_or(0.0))));
      units.group.push_back(units.n_groups);
      const auto name = std::tuple(units.n_groups, s.recording, units.are_recordings ? 0 : s.drop);
      units.unit.push_back(numbers.try_emplace(name, numbers.size()).first->second);
    }
    ++units.n_groups;
  }
  units.n_units = numbers.size();
  if (kept.empty()) return units;
  units.residual = residuals_from(*pooled.law, kept);
  std::vector<int> orders = config.orders;
  orders.resize(std::min(orders.size(), pooled.parameters.size()));
  const std::vector<double> v_mps = speeds_of(kept);
  const LawModel model = make_law_model(pooled.kind, orders, v_mps);
  const double gamma = pooled.kind == LawKind::viscoelastic ? pooled.parameters.front().estimate.value : 1.0;
  units.curve = model.jacobian(v_mps, Eigen::VectorXd::Constant(model.n_parameters(), log(gamma)));
  return units;
}

/// @param plate   samples of all its recordings
/// @param pooled  their fit
std::optional<WithinPlate> within_plate(const RestitutionSamples& plate, const LawFitConfig& config,
                                        const LawFit& pooled) {
  if (!pooled.law || !pooled.scatter) return std::nullopt;
  // of a recording that is off as a whole all are outliers of the plate, and count
  std::map<std::string, std::size_t> n_of, n_out;
  std::vector<bool> is_out(plate.size(), false);
  for (const RestitutionSample& s : plate) ++n_of[s.recording];
  for (const std::size_t k : pooled.outliers) is_out[k] = true, ++n_out[plate[k].recording];
  RestitutionSamples kept;
  for (std::size_t k = 0; k < plate.size(); ++k)
    if (const std::string& name = plate[k].recording; !is_out[k] || 2 * n_out[name] > n_of[name])
      kept.push_back(plate[k]);
  std::vector<Row> recordings = by_row(kept, {});
  std::erase_if(recordings, [](const Row& recording) { return recording.second.size() < kFewestOfRecording; });
  const auto found = agreement(units_of(recordings, std::vector<RecordingFit>(recordings.size()), config, pooled));
  if (!found) return std::nullopt;
  WithinPlate within{found->test, {}};
  for (std::size_t r = 0; r < recordings.size(); ++r)
    within.offsets.push_back({recordings[r].first, found->offsets[r]});
  return within;
}

/// @param windows  of its histograms; nullptr: none
RecordingFit row_of(const Row& recording, LawFitConfig config, const HistogramConfig* windows, bool is_one_of_many) {
  const RestitutionSamples& samples = recording.second;
  RecordingFit row;
  row.recording = recording.first;
  std::set<std::pair<std::string, std::int64_t>> drops;
  std::vector<double> v;
  for (const RestitutionSample& s : samples) {
    drops.emplace(s.recording, s.drop);
    v.push_back(s.v_mps);
  }
  std::sort(v.begin(), v.end());
  row.n_drops = drops.size();
  row.v_lo_mps = v.front();
  row.v_hi_mps = v.back();
  config.node_speeds_mps = {v[v.size() / 2]};
  if (is_one_of_many) {
    constexpr std::size_t kWidthKnown = 30;  // below, fit_law takes one term without a choice
    config.intervals = IntervalMethod::covariance;
    if (config.n_scatter_terms == 0 && samples.size() >= kWidthKnown) config.n_scatter_terms = 2;
  }
  row.law = fit_law(samples, config);
  row.parameters = row.law.parameters;
  if (windows) row.histograms = fit_histograms(*PartOfSamples(samples, row.law.outliers), *windows, row.law);
  return row;
}

}  // namespace

std::vector<Row> by_row(const RestitutionSamples& samples, const Plates& plates) {
  std::map<std::string, std::size_t> numbers;
  std::vector<Row> rows;
  for (const RestitutionSample& s : samples) {
    const auto plate = plates.find(s.recording);
    const std::string& name = plate == plates.end() ? s.recording : plate->second;
    const std::size_t number = numbers.try_emplace(name, rows.size()).first->second;
    if (number == rows.size()) rows.push_back({name, {}});
    rows[number].second.push_back(s);
  }
  return rows;
}

bool disagree(const Recordings& recordings) { return recordings.test && recordings.test->p_value < kDoubt; }

bool disagree_within(const RecordingFit& plate) { return plate.within && plate.within->test.p_value < kDoubt; }

const char* to_string(WithinUnit unit) {
  constexpr const char* kWords[]{"samples", "drops", "recordings"};
  return kWords[static_cast<std::size_t>(unit)];
}

Recordings compare_recordings(const RestitutionSamples& samples, const LawFitConfig& config, const LawFit& pooled,
                              const HistogramConfig& windows, const Plates& plates) {
  const bool is_one_recording = std::all_of(samples.begin(), samples.end(),
                                            [&](const auto& s) { return s.recording == samples.front().recording; });
  if (is_one_recording) return {};  // not copied: it may be most of the memory
  const std::vector<Row> recordings = by_row(samples, plates);
  if (recordings.size() < 2) return {};
  Recordings result;
  result.rows.resize(recordings.size());
  const bool are_many = recordings.size() > kManyRecordings, has_windows = !are_many && plates.empty();
  with_threads(0, [&] {
    parallel_for(recordings.size(), 0, [&](std::size_t k) {
      result.rows[k] = row_of(recordings[k], config, has_windows ? &windows : nullptr, are_many);
    });
    if (!pooled.law || !pooled.scatter) return;
    if (!plates.empty())
      for (std::size_t k = 0; k < recordings.size(); ++k)
        result.rows[k].within = within_plate(recordings[k].second, config, result.rows[k].law);
    if (const auto found = agreement(units_of(recordings, result.rows, config, pooled))) {
      result.test = found->test;
      auto next = found->offsets.begin();
      for (std::size_t k = 0; k < recordings.size(); ++k)
        if (recordings[k].second.size() >= kFewestOfRecording) result.rows[k].offset = *next++;
    }
  });
  return result;
}

Table slope_table(const std::vector<HistogramFit>& all, const Recordings& recordings) {
  Table table;
  const auto add = [&](const std::string& name, const auto& of) {  // of a recording and a window of it
    std::vector<std::decay_t<decltype(of(name, all.front()))>> cells;
    const auto take = [&](const std::string& recording, const std::vector<HistogramFit>& windows) {
      for (const HistogramFit& window : windows)
        if (window.peak_eps) cells.push_back(of(recording, window));
    };
    take("", all);
    for (const RecordingFit& row : recordings.rows) take(row.recording, row.histograms);
    table.columns.push_back({name, std::move(cells)});
  };
  using H = HistogramFit;
  add("recording", [](const std::string& recording, const H&) { return recording; });
  for (const auto& [name, speed] :
       {std::pair{"v_mps", &H::v_mps}, {"v_lo_mps", &H::v_lo_mps}, {"v_hi_mps", &H::v_hi_mps}})
    add(name, [speed = speed](const std::string&, const H& window) { return window.*speed; });
  add("n", [](const std::string&, const H& window) { return static_cast<std::int64_t>(window.n); });
  for (const auto& [quantity, member] : {std::pair{std::string("peak_eps"), &H::peak_eps},
                                         {"slope_rising", &H::slope_rising},
                                         {"slope_falling", &H::slope_falling},
                                         {"slope_ratio", &H::slope_ratio}}) {
    const auto add_part = [&, member = member](const std::string& name, double (*part)(const Estimate&)) {
      add(name, [&](const std::string&, const H& window) { return part(*(window.*member)); });
    };
    add_part(quantity, [](const Estimate& e) { return e.value; });
    add_part("sigma_" + quantity, [](const Estimate& e) { return *e.se; });
    add_part(quantity + "_lo95", [](const Estimate& e) { return e.ci95->lo; });
    add_part(quantity + "_hi95", [](const Estimate& e) { return e.ci95->hi; });
  }
  return table;
}

namespace {

constexpr std::size_t kFewestSamples = 3;    // of a drop whose median says something
constexpr std::ptrdiff_t kFewestOfKind = 2;  // of each kind, but of two drops: one alone may have met something
constexpr double kFarApart = 3.0;            // gap over width of a group, and over scatter
// gap over 1 - eps: over a factor 10 of speed between the kinds the curvature of v^(1/5) in ln v leaves a fourth of it
constexpr double kBeyondCurvature = 0.1;

struct Drop {
  std::vector<double> ln_v, eps;
  double ln_v_median = 0.0;
  double at_one_speed = 0.0;  ///< median of eps - slope ln v
};

/// What bounces of a drop scatter, and what is known of the change with speed.
struct Scatter {
  double sd = 0.0;                     ///< of eps, about the median of its drop; or what the timing makes of it
  double slope = 0.0, slope_se = 0.0;  ///< d eps / d ln v within drops
};

std::vector<Drop> drops_of(const RestitutionSamples& samples) {
  std::map<std::pair<std::string, std::int64_t>, Drop> by_name;
  for (const RestitutionSample& s : samples) {
    Drop& drop = by_name[{s.recording, s.drop}];
    drop.ln_v.push_back(log(s.v_mps));
    drop.eps.push_back(s.eps);
  }
  std::vector<Drop> drops;
  for (auto& [name, drop] : by_name)
    if (drop.eps.size() >= kFewestSamples) drops.push_back(std::move(drop));
  return drops;
}

/// d eps / d ln v within drops: the median of what their faster and slower halves say. Of all samples together it would
/// hold the difference between balls that were dropped from different heights.
double slope_within(const std::vector<Drop>& drops) {
  std::vector<double> slopes;
  for (const Drop& drop : drops) {
    std::vector<std::size_t> order(drop.eps.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return drop.ln_v[a] < drop.ln_v[b]; });
    std::array<std::vector<double>, 2> ln_v, eps;  // of the slower half, of the faster one
    for (std::size_t k = 0; k < order.size(); ++k) {
      const bool is_faster = k >= order.size() / 2;
      ln_v[is_faster].push_back(drop.ln_v[order[k]]);
      eps[is_faster].push_back(drop.eps[order[k]]);
    }
    const double span = median(ln_v[1]) - median(ln_v[0]);
    if (span > 0.0) slopes.push_back((median(eps[1]) - median(eps[0])) / span);
  }
  return slopes.empty() ? 0.0 : median(std::move(slopes));
}

/// Sets each drop's `at_one_speed`.
Scatter bring_to_one_speed(std::vector<Drop>& drops) {
  const double slope = slope_within(drops);
  std::vector<double> deviations;
  double leverage = 0.0;
  for (Drop& drop : drops) {
    std::vector<double> eps = drop.eps;
    for (std::size_t k = 0; k < eps.size(); ++k) eps[k] -= slope * drop.ln_v[k];
    drop.at_one_speed = median(eps);
    drop.ln_v_median = median(drop.ln_v);
    for (const double e : eps) deviations.push_back(std::abs(e - drop.at_one_speed));
    for (const double ln_v : drop.ln_v) leverage += square(ln_v - drop.ln_v_median);
  }
  if (deviations.empty()) return {};
  Scatter scatter{kSdOverMad * median(std::move(deviations)), slope, 0.0};
  // medians of halves use the samples half as well as least squares
  if (leverage > 0.0) scatter.slope_se = 2.0 * scatter.sd / std::sqrt(leverage);
  return scatter;
}

/// Standard error of eps by the timing, of most bounces; 0 where it is not known.
double timing_of(const RestitutionSamples& samples) {
  std::vector<double> sigma;
  for (const RestitutionSample& s : samples) sigma.push_back(s.sigma_eps.value_or(0.0));
  return sigma.empty() ? 0.0 : median(std::move(sigma));
}

/// Drops in two groups, the first `below` of them in one, with eps as a straight line in ln v.
UnitSamples units_of(const std::vector<Drop>& drops, std::size_t below) {
  UnitSamples units;
  std::vector<double> ln_v;
  for (std::size_t d = 0; d < drops.size(); ++d)
    for (std::size_t k = 0; k < drops[d].eps.size(); ++k) {
      units.residual.push_back(drops[d].eps[k]);
      ln_v.push_back(drops[d].ln_v[k]);
      units.group.push_back(d < below ? 0 : 1);
      units.unit.push_back(d);
    }
  units.weight.assign(ln_v.size(), 1.0);
  units.curve = Eigen::Map<const Eigen::VectorXd>(ln_v.data(), static_cast<Eigen::Index>(ln_v.size()));
  units.n_groups = 2;
  units.n_units = drops.size();
  return units;
}

}  // namespace

std::optional<KindsOfDrops> two_kinds_of_drops(const RestitutionSamples& samples) {
  std::vector<Drop> drops = drops_of(samples);
  const Scatter scatter = bring_to_one_speed(drops);
  std::sort(drops.begin(), drops.end(), [](const Drop& a, const Drop& b) { return a.at_one_speed < b.at_one_speed; });
  const auto n = std::ssize(drops);
  std::ptrdiff_t below = 0;  // how many of them are in the lower group
  double gap = 0.0;
  const std::ptrdiff_t fewest = n == 2 ? 1 : kFewestOfKind;
  for (std::ptrdiff_t k = fewest; k + fewest <= n; ++k)
    if (const double here = drops[k].at_one_speed - drops[k - 1].at_one_speed; here > gap) gap = here, below = k;
  if (below == 0) return {};
  const double widest = std::max(drops[below - 1].at_one_speed - drops.front().at_one_speed,
                                 drops.back().at_one_speed - drops[below].at_one_speed);
  const auto ln_v_of = [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    std::vector<double> ln_v;
    for (std::ptrdiff_t k = first; k < last; ++k) ln_v.push_back(drops[k].ln_v_median);
    return median(std::move(ln_v));
  };
  const double by_slope = scatter.slope_se * std::abs(ln_v_of(0, below) - ln_v_of(below, n));
  if (gap < kFarApart * std::max({widest, scatter.sd, timing_of(samples), by_slope})) return {};
  if (gap < kBeyondCurvature * (1.0 - drops.front().at_one_speed)) return {};
  const auto test = agreement(units_of(drops, static_cast<std::size_t>(below)));
  if (!test || test->test.p_value >= kDoubt) return {};
  std::vector<double> lower, upper;
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    std::vector<double>& kind = k < below ? lower : upper;
    kind.insert(kind.end(), drops[k].eps.begin(), drops[k].eps.end());
  }
  const KindsOfDrops kinds{static_cast<std::size_t>(below), static_cast<std::size_t>(n - below),
                           median(std::move(lower)), median(std::move(upper))};
  // also as they are: a slope that few bounces tell parts what was dropped from two heights
  const double apart = kinds.eps_upper - kinds.eps_lower;
  if (apart < std::max(kFarApart * scatter.sd, kBeyondCurvature * (1.0 - kinds.eps_lower))) return {};
  return kinds;
}

std::vector<RepeatedDrop> repeated_drops(const RestitutionSamples& samples) {
  constexpr std::size_t kFewestBounces = 4;
  constexpr double kAlike = 0.1;  // of the scatter
  constexpr double kMostOfDrop = 0.8;
  constexpr std::size_t kNeighbours = 50;  // looked at: where more have one speed it tells nothing
  DropNumbers numbers;
  std::vector<std::size_t> drop_of, first_of, size_of;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::size_t d = numbers.of(samples[k]);
    if (d == size_of.size()) {
      first_of.push_back(k);
      size_of.push_back(0);
    }
    drop_of.push_back(d);
    ++size_of[d];
  }
  if (size_of.size() < 2) return {};
  std::vector<Drop> drops = drops_of(samples);
  const Scatter scatter = bring_to_one_speed(drops);
  const double within = kAlike * scatter.sd;
  // times so coarse are alike of drops that are not
  if (timing_of(samples) > 0.5 * scatter.sd) return {};
  const std::vector<std::size_t> order = by_speed(samples);
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> alike;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i + 1; j < std::min(order.size(), i + 1 + kNeighbours); ++j) {
      const RestitutionSample &a = samples[order[i]], &b = samples[order[j]];
      if (b.v_mps - a.v_mps > within * a.v_mps) break;
      const std::size_t first = drop_of[order[i]], second = drop_of[order[j]];
      if (first != second && std::abs(a.eps - b.eps) <= within) ++alike[std::minmax(first, second)];
    }
  std::vector<RepeatedDrop> repeated;
  std::vector<bool> is_told(size_of.size(), false);
  for (const auto& [pair, n] : alike) {
    const auto [of, drop] = pair;
    const auto shorter = static_cast<double>(std::min(size_of[of], size_of[drop]));
    if (is_told[drop] || n < kFewestBounces || static_cast<double>(n) < kMostOfDrop * shorter) continue;
    is_told[drop] = true;
    const RestitutionSample &here = samples[first_of[drop]], &there = samples[first_of[of]];
    repeated.push_back({here.recording, there.recording, here.drop, there.drop, n});
  }
  return repeated;
}

}  // namespace bouncelab::fit
