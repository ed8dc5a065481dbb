// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_search.hpp"

#include <algorithm>
#include <functional>
#include <numbers>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "law/law_model.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

struct SpeedBin {
  std::size_t begin = 0, end = 0;
  double v_mps = 0.0, median_eps = 0.0;
};

std::vector<SpeedBin> speed_bins(const LawData& data) {
  const std::size_t n = data.size();
  const std::size_t n_bins = std::clamp<std::size_t>(n / 10, 4, 40);
  std::vector<SpeedBin> bins;
  for (std::size_t j = 0; j < n_bins; ++j) {
    SpeedBin bin{j * n / n_bins, (j + 1) * n / n_bins};
    if (bin.begin == bin.end) continue;
    bin.v_mps = data.v_mps[(bin.begin + bin.end) / 2];
    bin.median_eps = upper_median({data.eps.begin() + static_cast<std::ptrdiff_t>(bin.begin),
                                   data.eps.begin() + static_cast<std::ptrdiff_t>(bin.end)});
    bins.push_back(bin);
  }
  return bins;
}

Eigen::VectorXd start_of_law(const std::vector<SpeedBin>& bins, const LawModel& model) {
  if (model.kind == LawKind::viscoelastic) {
    const SpeedBin& middle = bins[bins.size() / 2];
    if (!(middle.median_eps < 1.0) || middle.median_eps < 0.05) return {};
    return Eigen::VectorXd::Constant(1, log_gamma_through(middle.v_mps, middle.median_eps));
  }
  std::vector<double> v;
  Eigen::VectorXd eps(static_cast<Eigen::Index>(bins.size()));
  for (std::size_t j = 0; j < bins.size(); ++j) {
    v.push_back(bins[j].v_mps);
    eps[static_cast<Eigen::Index>(j)] = bins[j].median_eps;
  }
  const Eigen::MatrixXd rows = model.jacobian(v, {});
  const Eigen::VectorXd above_one = least_squares(rows, (eps.array() - 1.0).matrix());
  return above_one.array() + 1.0;
}

/// The mean distance of exponential scatter whose median distance is that of these.
double mean_of_median(std::vector<double> distances) { return upper_median(std::move(distances)) / std::numbers::ln2; }

/// Mean distances from the curve below (side -1) or above (side +1) in each bin, freed of what timing explains. By
/// medians: lost bounces count little.
Eigen::VectorXd log_scales(const LawData& data, const std::vector<SpeedBin>& bins, const Eigen::VectorXd& fitted,
                           double side) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(bins.size()));
  for (std::size_t j = 0; j < bins.size(); ++j) {
    std::vector<double> distances;
    double timing = 0.0;
    for (std::size_t k = bins[j].begin; k < bins[j].end; ++k) {
      const double d = side * (data.eps[k] - fitted[static_cast<Eigen::Index>(k)]);
      timing += data.tau[k] * data.tau[k];
      if (d > 0.0) distances.push_back(d);
    }
    const double mean = distances.empty() ? 0.0 : mean_of_median(std::move(distances));
    timing /= static_cast<double>(bins[j].end - bins[j].begin);
    // an exponential of mean b and a half-normal add in variance: 2 b^2 + tau^2 against 2 mean^2
    const double free_of_timing = std::sqrt(std::max(mean * mean - 0.5 * timing, 0.04 * mean * mean));
    result[static_cast<Eigen::Index>(j)] = log(std::max(free_of_timing, 1e-8));
  }
  return result;
}

/// Least absolute deviations by reweighted least squares: of few samples one may be anywhere.
/// Source: Schlossmacher, J. Am. Stat. Assoc. 68, 857 (1973), doi:10.1080/01621459.1973.10481439.
Eigen::VectorXd least_absolute(const LawData& data, const LawModel& model) {
  constexpr int kMost = 50;
  const Eigen::MatrixXd rows = model.jacobian(data.v_mps, {});
  const Eigen::VectorXd losses = Eigen::Map<const Eigen::VectorXd>(data.eps.data(), rows.rows()).array() - 1.0;
  Eigen::VectorXd root_weights = Eigen::VectorXd::Ones(rows.rows()), q;
  for (int i = 0; i < kMost; ++i) {
    q = least_squares(root_weights.asDiagonal() * rows, root_weights.cwiseProduct(losses));
    const Eigen::VectorXd distances = (losses - product(rows, q)).cwiseAbs();
    root_weights = distances.array().max(1e-6 * distances.mean() + 1e-12).sqrt().inverse();
  }
  return q.array() + 1.0;
}

/// The same of all samples, the curve's own left out.
double log_scale_of_few(const LawData& data, const Eigen::VectorXd& fitted, std::size_t n_law) {
  std::vector<double> distances;
  for (std::size_t k = 0; k < data.size(); ++k)
    distances.push_back(std::abs(data.eps[k] - fitted[static_cast<Eigen::Index>(k)]));
  std::sort(distances.begin(), distances.end());
  distances.erase(distances.begin(),
                  distances.begin() + static_cast<std::ptrdiff_t>(std::min(n_law, distances.size() - 1)));
  return log(std::max(mean_of_median(std::move(distances)), 1e-8));
}

/// Of two exponentials half of the variance to a normal part: both can be seen from there.
Eigen::VectorXd with_normal_part(const Eigen::VectorXd& exponentials, const ScatterFamily& scatter,
                                 Eigen::Index n_law) {
  constexpr double kHalf = 0.5 * std::numbers::ln2;
  Eigen::VectorXd theta(exponentials.size() + 1);
  theta << exponentials, kHalf;
  theta[n_law] -= kHalf;
  theta[n_law + static_cast<Eigen::Index>(scatter.n_terms)] -= kHalf;
  return theta;
}

}  // namespace

std::optional<FirstLook> first_look(const LawData& data, const LawModel& model) {
  constexpr std::size_t kFew = 40;  // below, bins have no medians
  const bool few = data.size() < kFew;
  const auto bins = speed_bins(data);
  FirstLook look{few && model.is_linear() ? least_absolute(data, model) : start_of_law(bins, model), {}, {}, {}};
  if (look.law.size() == 0) return std::nullopt;
  for (const SpeedBin& bin : bins) look.v_mps.push_back(bin.v_mps);
  const Eigen::VectorXd fitted = model.eps(data.v_mps, look.law);
  if (few) {
    look.log_below = look.log_above =
        Eigen::VectorXd::Constant(1, log_scale_of_few(data, fitted, static_cast<std::size_t>(model.n_parameters())));
  } else {
    look.log_below = log_scales(data, bins, fitted, -1.0);
    look.log_above = log_scales(data, bins, fitted, 1.0);
  }
  return look;
}

Eigen::VectorXd start_values(const FirstLook& look, const ScatterFamily& scatter) {
  const Eigen::VectorXd& law = look.law;
  const auto n_terms = static_cast<Eigen::Index>(scatter.n_terms);
  Eigen::VectorXd below = Eigen::VectorXd::Zero(n_terms), above = below;
  if (look.log_below.size() == 1) {
    below[0] = look.log_below[0];
    above[0] = look.log_above[0];
  } else {
    Eigen::MatrixXd powers(look.log_below.size(), n_terms);
    for (Eigen::Index j = 0; j < powers.rows(); ++j)
      for (Eigen::Index i = 0; i < n_terms; ++i)
        powers(j, i) = power(log(look.v_mps[static_cast<std::size_t>(j)] / scatter.v_ref_mps), static_cast<int>(i));
    below = least_squares(powers, look.log_below);
    above = least_squares(powers, look.log_above);
  }
  Eigen::VectorXd theta(law.size() + 2 * n_terms);
  theta << law, below, above;
  return scatter.has_normal_part ? with_normal_part(theta, scatter, law.size()) : theta;
}

namespace {

/// Of bounces that are lost: the ball hit something else, or an impact was missed.
constexpr double kLostShare = 0.01;

constexpr std::size_t kManySamples = 1000;  // enough to tell two exponentials from a rounded peak

/// Numbers of terms in log b(v) to choose from by BIC; the first decides about the normal part, and has to follow the
/// widths well: normal scatter of widths that go with speed, taken as one width, looks like exponentials.
std::vector<std::size_t> numbers_of_terms(const LawFitConfig& config, std::size_t n) {
  constexpr std::size_t kFew = 30, kVeryMany = 20000;
  if (config.n_scatter_terms > 0) return {config.n_scatter_terms};
  if (n >= kVeryMany) return {3, 6};  // the widths' shape is resolved beyond a parabola
  if (n < kFew) return {1};
  return {3, 2, 1};
}

/// @param near       where the search begins
/// @param widths     the timing errors are widened by these
/// @param n_counted  parameters that BIC counts
Candidate fit_near(const Eigen::VectorXd& near, const LawData& data, const LawModel& model, const ScatterFamily& family,
                   const ScatterModel& widths, Eigen::Index n_counted) {
  Candidate candidate{family, data, {}};
  const auto n = static_cast<double>(data.size());
  widen(candidate.data, widths, std::sqrt(static_cast<double>(model.n_parameters()) / n));
  const LawLikelihood likelihood(candidate.data, model, candidate.family);
  candidate.maximum = maximise(std::cref(likelihood), near, likelihood.information(near));
  if (!candidate.maximum.converged)  // the metric of a poor start may be poor: once more from where it led
    candidate.maximum =
        maximise(std::cref(likelihood), candidate.maximum.x, likelihood.information(candidate.maximum.x));
  candidate.bic = static_cast<double>(n_counted) * log(n) - 2.0 * candidate.maximum.loglik;
  return candidate;
}

/// @param start  has the scales of a first look
Candidate fit_family(const LawData& data, const LawModel& model, ScatterFamily family, const Eigen::VectorXd& start,
                     const Eigen::VectorXd& near) {
  const Eigen::Index n_law = model.n_parameters(), below = n_law,
                     above = n_law + static_cast<Eigen::Index>(family.n_terms);
  family.log_size = 0.5 * (start[below] + start[above]);
  return fit_near(near, data, model, family, scatter_model_of(start, n_law, family), n_law + family.n_parameters());
}

/// With the scales of a rough ball released at rest, near another candidate. The sides' ratio is hardly free, so it
/// does not count as a parameter.
Candidate fit_by_place(const LawData& data, const LawModel& model, const Candidate& other) {
  ScatterFamily family{false, 1, other.family.v_ref_mps, other.family.lost_share};
  family.by_place = true;
  const Eigen::Index n_law = model.n_parameters();
  const ScatterModel seen = LawLikelihood(other.data, model, other.family).scatter_model(other.maximum.x);
  double log_q = 0.0;
  for (std::size_t k = 0; k < data.size(); ++k)
    log_q += 0.5 * (log(seen.variance(data.v_mps[k]) / 2.0) - data.log_below[k] - data.log_above[k]);
  log_q /= static_cast<double>(data.size());
  family.log_size = log_q;
  Eigen::VectorXd near(n_law + 2);
  near << other.maximum.x.head(n_law), log_q, log_q;
  return fit_near(near, data, model, family, seen, n_law + 1);
}

}  // namespace

bool is_better(const Candidate& a, const Candidate& b) {
  return (a.maximum.converged && !b.maximum.converged) || (a.maximum.converged == b.maximum.converged && a.bic < b.bic);
}

std::optional<Candidate> best_candidate(const LawData& data, const LawModel& model, const LawFitConfig& config) {
  std::optional<Candidate> best;
  const std::optional<FirstLook> look = first_look(data, model);
  if (!look) return best;
  for (const std::size_t n_terms : numbers_of_terms(config, data.size())) {
    const ScatterFamily family{!best || best->family.has_normal_part, n_terms, data.v_mps[data.size() / 2], kLostShare};
    Eigen::VectorXd start = start_values(*look, family);
    const bool undecided = !best && data.size() >= kManySamples;
    if (undecided) {
      ScatterFamily exponentials = family;
      exponentials.has_normal_part = false;
      const Eigen::VectorXd of_exponentials = start_values(*look, exponentials);
      best = fit_family(data, model, exponentials, of_exponentials, of_exponentials);
      if (best->maximum.converged) start = with_normal_part(best->maximum.x, family, model.n_parameters());
    }
    Candidate candidate = fit_family(data, model, family, start, start);
    // a normal part that is smaller than the exponentials
    const bool rounds_the_peak = undecided && best->maximum.converged && !(candidate.maximum.x.tail(1)[0] > 0.0);
    if (!best || (is_better(candidate, *best) && !rounds_the_peak)) best = std::move(candidate);
  }
  if (best && best->maximum.converged && config.n_scatter_terms == 0) {
    // "very strong" evidence: Kass and Raftery, doi:10.1080/01621459.1995.10476572
    constexpr double kVeryStrong = 10.0;
    Candidate candidate = fit_by_place(data, model, *best);
    if (candidate.maximum.converged && candidate.bic < best->bic - kVeryStrong) best = std::move(candidate);
  }
  return best;
}

std::optional<Candidate> again_without_outliers(const LawData& data, const LawModel& model, const Candidate& before) {
  const std::optional<FirstLook> look = first_look(data, model);
  if (!look) return std::nullopt;
  if (before.family.by_place) return fit_by_place(data, model, before);
  return fit_family(data, model, before.family, start_values(*look, before.family), before.maximum.x);
}

bool remove_outliers(const LawData& data, const LawModel& model, const Candidate& fit, std::vector<std::size_t>& rows,
                     std::vector<std::size_t>& outliers) {
  constexpr double kLeastOfLost = 1e-3;  // of eps: an impact that is missed or invented changes it by hundredths
  if (!(fit.family.lost_share > 0.0)) return false;
  const LawLikelihood likelihood(data, model, fit.family);
  const std::vector<double> p = likelihood.probabilities_of_lost(fit.maximum.x);
  const Eigen::VectorXd fitted = model.eps(data.v_mps, fit.maximum.x.head(model.n_parameters()));
  const auto is_lost = [&](std::size_t k) {
    return p[k] > 0.5 && std::abs(data.eps[k] - fitted[static_cast<Eigen::Index>(k)]) > kLeastOfLost;
  };
  std::vector<std::size_t> kept, lost;
  for (std::size_t k = 0; k < data.size(); ++k) (is_lost(k) ? lost : kept).push_back(rows[k]);
  // a curve that so few follow is none: a search of few samples may end beside nearly all of them
  if (lost.empty() || kept.size() < std::max(kFewest, lost.size())) return false;
  rows = std::move(kept);
  outliers.insert(outliers.end(), lost.begin(), lost.end());
  return true;
}

}  // namespace bouncelab::fit
