// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/averaged_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/law_data.hpp"
#include "law/law_search.hpp"
#include "numerics/distributions.hpp"
#include "numerics/linalg.hpp"

namespace bouncelab::fit {
namespace {

// Speeds within a factor of this are one: no curve can be seen.
constexpr double kSpeedRatioMin = 1.2;
// Of places on the grid of a parameter that is hardly known, and of one whose prior is narrow.
constexpr std::size_t kWide = 5, kNarrow = 3;
constexpr double kReach = 2.4;         // of the grid, in standard deviations: 98 % of a normal prior
constexpr double kNarrowPrior = 0.35;  // standard deviation of ln: between three places everything is straight
constexpr std::size_t kFiner = 8;      // places by interpolation for each one computed
constexpr int kMostRounds = 4;         // of closing in
constexpr double kUnlikely = 9.0;      // in the logarithm: a law so far behind the best is left out of the grid
// Scatter of eps from bounce to bounce, as of two samples, for those who have one or two: few balls do better than
// this on any floor.
constexpr double kScatterOfFew = 0.005;

/// Samples as the grid's fits take them.
struct Raw {
  LawData data;
  std::vector<bool> from_height;
  std::vector<std::int64_t> impact;
};

Raw raw_of(const RestitutionSamples& samples) {
  const OrderedSamples ordered = ordered_by_speed(samples);
  Raw raw{ordered.data, {}, {}};
  for (const std::size_t k : ordered.rows) {
    raw.from_height.push_back(samples[k].impact == 0);
    raw.impact.push_back(samples[k].impact);
  }
  return raw;
}

/// At the plate, by speed; and the logarithm of d eps / d (T'/T) over all samples.
struct Moved {
  LawData data;
  double ln_stretch = 0.0;
};
Moved moved(const Raw& raw, const AirAndContact& known, Deviation deviation) {
  if (!known.is_open()) return {raw.data, 0.0};
  const std::size_t n = raw.data.size();
  std::vector<AtThePlate> at;
  at.reserve(n);
  for (std::size_t k = 0; k < n; ++k)
    at.push_back(at_the_plate(raw.data.v_mps[k], raw.data.eps[k], raw.from_height[k], known, deviation));
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return at[a].v_mps < at[b].v_mps; });
  Moved moved;
  for (const std::size_t k : order) {
    moved.data.v_mps.push_back(at[k].v_mps);
    moved.data.eps.push_back(at[k].eps);
    moved.data.tau.push_back(raw.data.tau[k] * at[k].stretch);
    moved.data.drop.push_back(raw.data.drop[k]);
    moved.ln_stretch += log(at[k].stretch);
  }
  return moved;
}

/// One law at one place of the grid: eps at the nodes with its covariance by standard errors and correlations.
struct Fitted {
  double surprise = HUGE_VAL;     ///< minus the logarithm of the law's evidence
  std::vector<double> eps, se;    ///< at the nodes
  std::vector<double> change_se;  ///< of the difference from the middle node
  double nu = 1e9;                ///< degrees of freedom of the standard errors
  double stretch = 1.0;           ///< of the standard errors, where they are by drop
};

/// What a law says of the shape of eps(v), as sums of eps at some speeds; each is 0 with a standard deviation
/// beforehand. The viscoelastic law falls by (1 - eps)/5 in a factor e of speed; half as much again is usual.
struct Shape {
  std::vector<double> v_mps;
  Eigen::MatrixXd sums;  ///< a row a sum, a column a speed
  Eigen::VectorXd prior_sd;
};
Shape shape_of(const LawModel& model, const LawData& data) {
  constexpr double kSlope = 0.3, kCurvature = 0.25, kStep = 0.5;
  const std::vector<double> ends = spread_speeds(data.v_mps, 2);
  const double lost = std::max(0.01, 1.0 - median(data.eps)), change = kSlope * lost * log(ends[1] / ends[0]);
  Shape shape;
  if (model.kind == LawKind::slope) {
    shape = {ends, Eigen::MatrixXd(1, 2), Eigen::VectorXd(1)};
    shape.sums << -1.0, 1.0;
    shape.prior_sd << change;
  } else if (model.kind == LawKind::series && model.n_parameters() > 2) {
    shape = {{ends[0], std::sqrt(ends[0] * ends[1]), ends[1]}, Eigen::MatrixXd(2, 3), Eigen::VectorXd(2)};
    shape.sums << -1.0, 0.0, 1.0, -0.5, 1.0, -0.5;
    shape.prior_sd << change, kCurvature * change;
  } else if (model.kind == LawKind::step) {
    const double at = model.node_v_mps[2];
    shape = {{ends[0], at * (1.0 - 1e-9), at, ends[1]}, Eigen::MatrixXd(2, 4), Eigen::VectorXd(2)};
    shape.sums << -1.0, 1.0, -1.0, 1.0, 0.0, -1.0, 1.0, 0.0;
    shape.prior_sd << change, kStep * lost;
  }
  return shape;
}

/// What is known of eps at some speeds when the prior of its shape has been taken in. @return minus the logarithm of
/// the likelihood's mean over that prior, relative to its maximum
double take_in(const Shape& shape, Eigen::Index n_nodes, Eigen::VectorXd& eps, Eigen::MatrixXd& covariance) {
  if (shape.v_mps.empty()) return 0.0;
  const Eigen::Index n = eps.size(), n_sums = shape.sums.rows();
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(n_sums, n);
  sums.rightCols(n - n_nodes) = shape.sums;
  const Eigen::MatrixXd with_sums = product(covariance, sums.transpose());
  const Eigen::MatrixXd of_sums = product(sums, with_sums);
  Eigen::MatrixXd total = of_sums;
  total.diagonal() += shape.prior_sd.cwiseAbs2();
  const Eigen::MatrixXd gain = product(with_sums, inverse(total));
  const Eigen::VectorXd found = product(sums, eps);
  const double misfit = found.dot(Eigen::VectorXd(product(inverse(total), found)));
  const auto ln_det = [](const Eigen::MatrixXd& m) {
    const double det = m.rows() == 1 ? m(0, 0) : m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
    return log(std::max(det, 1e-300));
  };
  const double surprise = 0.5 * (ln_det(total) - ln_det(of_sums) + misfit);
  eps -= product(gain, found);
  covariance -= product(gain, Eigen::MatrixXd(with_sums.transpose()));
  return surprise;
}

Fitted fit_of(const LawData& data, const LawModel& model, const LawFitConfig& config,
              const std::vector<double>& nodes_mps) {
  Fitted fitted;
  std::optional<Candidate> candidate = best_candidate(data, model, config);
  constexpr double kLittle = 0.05;  // of log-likelihood: a search that stopped so near its end knows enough
  if (!candidate || (!candidate->maximum.converged && !(candidate->maximum.gain_left < kLittle))) return fitted;
  candidate->data.basis = make_law_basis(model, candidate->data.v_mps);
  const LawLikelihood likelihood(candidate->data, model, candidate->family);
  LawFit fit;
  fit.n = data.size();
  const Shape shape = shape_of(model, data);
  std::vector<double> speeds_mps = nodes_mps;
  speeds_mps.insert(speeds_mps.end(), shape.v_mps.begin(), shape.v_mps.end());
  describe_nodes(fit, likelihood, candidate->maximum, speeds_mps);
  const auto n_speeds = static_cast<Eigen::Index>(speeds_mps.size()),
             n_nodes = static_cast<Eigen::Index>(nodes_mps.size());
  Eigen::VectorXd eps(n_speeds);
  Eigen::MatrixXd covariance(n_speeds, n_speeds);
  for (Eigen::Index i = 0; i < n_speeds; ++i) {
    const auto a = static_cast<std::size_t>(i);
    eps[i] = fit.nodes[a].eps.value;
    for (Eigen::Index j = 0; j < n_speeds; ++j) {
      const auto b = static_cast<std::size_t>(j);
      covariance(i, j) = fit.nodes[a].eps.se.value_or(0.0) * fit.nodes[b].eps.se.value_or(0.0) *
                         (a == b ? 1.0 : fit.node_correlation[a][b]);
    }
  }
  const auto n = static_cast<double>(data.size());
  const auto n_scatter = static_cast<double>(fit.n_parameters) - static_cast<double>(model.n_parameters());
  fitted.surprise = 0.5 * n_scatter * log(n) - candidate->maximum.loglik + take_in(shape, n_nodes, eps, covariance);
  const std::size_t middle = nodes_mps.size() / 2;
  const auto m = static_cast<Eigen::Index>(middle);
  for (Eigen::Index j = 0; j < n_nodes; ++j) {
    fitted.eps.push_back(eps[j]);
    fitted.se.push_back(std::sqrt(std::max(0.0, covariance(j, j))));
    fitted.change_se.push_back(
        model.n_parameters() == 1 && model.is_linear()
            ? 0.0
            : std::sqrt(std::max(0.0, covariance(j, j) + covariance(m, m) - 2.0 * covariance(j, m))));
  }
  if (fit.drops.errors == ErrorBasis::independent_samples) {
    fitted.nu = std::max(1.0, n - static_cast<double>(model.n_parameters()) - 1.0);
  } else if (const Estimate& e = fit.nodes[middle].eps; e.se && *e.se > 0.0 && e.ci95) {
    fitted.stretch = (e.ci95->hi - e.ci95->lo) / (2.0 * 1.959963984540054 * *e.se);
  }
  return fitted;
}

/// One eps for one or two samples: their scatter is that of few, and their own.
Fitted fit_of_few(const LawData& data, std::size_t n_nodes) {
  const auto n = static_cast<double>(data.size());
  double weights = 0.0, sum = 0.0;
  for (std::size_t k = 0; k < data.size(); ++k) {
    const double w = 1.0 / (square(data.tau[k]) + square(kScatterOfFew));
    weights += w, sum += w * data.eps[k];
  }
  const double mean = sum / weights;
  double own = 0.0;
  for (const double eps : data.eps) own += square(eps - mean);
  const double timing =
      std::accumulate(data.tau.begin(), data.tau.end(), 0.0, [](double a, double tau) { return a + tau * tau; }) / n;
  const double nu = 2.0 + (n - 1.0);
  const double scatter2 = (2.0 * square(kScatterOfFew) + std::max(0.0, own - (n - 1.0) * timing)) / nu;
  Fitted fitted;
  fitted.surprise = 0.0;
  fitted.eps.assign(n_nodes, mean);
  fitted.se.assign(n_nodes, std::sqrt((scatter2 + timing) / n));
  fitted.change_se.assign(n_nodes, 0.0);
  fitted.nu = nu;
  return fitted;
}

struct Law {
  LawKind kind;
  std::vector<int> orders;
};

std::string name_of(const LawModel& model) {
  std::string name;
  for (const std::string& one : model.names()) name += (name.empty() ? "" : ", ") + one;
  return name;
}

std::vector<Law> laws_of(const LawData& data, const LawFitConfig& config) {
  const std::size_t n = data.size();
  const double lo = data.v_mps[n / 20], hi = data.v_mps[n - 1 - n / 20];
  const LawFitConfig usual;
  if (config.kind != usual.kind || config.orders != usual.orders) return {{config.kind, config.orders}};
  std::vector<Law> laws{{LawKind::constant, {}}};
  if (n < 4 || hi < kSpeedRatioMin * lo) return laws;
  laws.push_back({LawKind::viscoelastic, {}});
  laws.push_back({LawKind::slope, {}});
  if (n > 5) laws.push_back({LawKind::series, config.orders});
  return laws;
}

/// A law with a step where that explains the samples much better than one without, by weighted least squares; the step
/// leaves some samples on either side, or lost impacts would be steps.
std::optional<LawModel> step_of(const LawData& data) {
  constexpr std::size_t kBeside = 4, kMostPlaces = 100;
  const std::size_t n = data.size();
  if (n < 3 * kBeside) return std::nullopt;
  const auto rows = static_cast<Eigen::Index>(n);
  const Eigen::Map<const Eigen::VectorXd> eps(data.eps.data(), rows);
  Eigen::VectorXd root_weights = Eigen::VectorXd::Ones(rows);
  const auto residuals_of = [&](const LawModel& model) -> Eigen::VectorXd {
    const Eigen::MatrixXd j = root_weights.asDiagonal() * model.jacobian(data.v_mps, {});
    const Eigen::VectorXd y = root_weights.cwiseProduct(eps);
    return y - product(j, least_squares(j, y));
  };
  const LawModel without = make_law_model(LawKind::slope, {}, data.v_mps);
  const Eigen::VectorXd first = residuals_of(without).cwiseAbs();
  constexpr double kOfNormal = 1.4826;  // standard deviation over the median distance
  const double scatter = kOfNormal * median({first.data(), first.data() + rows});
  for (std::size_t k = 0; k < n; ++k) root_weights[static_cast<Eigen::Index>(k)] = 1.0 / hypot(data.tau[k], scatter);
  const auto length = static_cast<double>(n);
  double least = residuals_of(without).squaredNorm();
  const double enough = least * exp(-2.0 * (log(length) + 2.0) / length);
  std::optional<LawModel> best;
  const std::size_t stride = 1 + n / kMostPlaces;
  for (std::size_t k = kBeside; k + kBeside <= n; k += stride) {
    LawModel model = make_step_model(data.v_mps, std::sqrt(data.v_mps[k - 1] * data.v_mps[k]));
    const double squares = residuals_of(model).squaredNorm();
    if (squares < least) least = squares, best = std::move(model);
  }
  return least < enough ? best : std::nullopt;
}

/// Places of one parameter, in ln.
struct Axis {
  std::vector<double> at;
  double prior_sd = 0.0;
  double distance() const { return at.size() > 1 ? at[1] - at[0] : 0.0; }
};
Axis axis_of(double prior_sd, double middle, double reach) {
  if (!(prior_sd > 0.0)) return {{0.0}, 0.0};
  const std::size_t n = reach > kReach * kNarrowPrior ? kWide : kNarrow;
  Axis axis{{}, prior_sd};
  for (std::size_t k = 0; k < n; ++k)
    axis.at.push_back(middle + reach * (2.0 * static_cast<double>(k) / static_cast<double>(n - 1) - 1.0));
  return axis;
}

/// A place between those of an axis: cubic convolution of four neighbours, exact where a function is a parabola.
/// Source: Keys, IEEE Trans. ASSP 29, 1153 (1981), doi:10.1109/TASSP.1981.1163711.
struct FinePlace {
  double at = 0.0;
  std::vector<std::pair<std::size_t, double>> neighbours;  ///< with their weights
};
FinePlace fine_place(const Axis& axis, std::size_t k, double s) {
  double w[] = {s * (-0.5 + s * (1.0 - 0.5 * s)), 1.0 + s * s * (-2.5 + 1.5 * s), s * (0.5 + s * (2.0 - 1.5 * s)),
                s * s * (-0.5 + 0.5 * s)};
  // beyond the ends the parabola of the last three goes on
  std::size_t first = k - 1;
  if (k == 0) {
    const double beyond = w[0];
    w[0] = w[1] + 3.0 * beyond, w[1] = w[2] - 3.0 * beyond, w[2] = w[3] + beyond, w[3] = 0.0;
    first = 0;
  } else if (k + 2 == axis.at.size()) {
    w[2] += 3.0 * w[3], w[1] -= 3.0 * w[3], w[0] += w[3], w[3] = 0.0;
  }
  FinePlace place{axis.at[k] + s * axis.distance(), {}};
  for (std::size_t j = 0; j < 4; ++j)
    if (first + j < axis.at.size() && w[j] != 0.0) place.neighbours.emplace_back(first + j, w[j]);
  return place;
}
std::vector<FinePlace> finer(const Axis& axis) {
  if (axis.at.size() == 1) return {{axis.at[0], {{0, 1.0}}}};
  std::vector<FinePlace> places;
  for (std::size_t k = 0; k + 1 < axis.at.size(); ++k)
    for (std::size_t j = 0; j < kFiner; ++j)
      places.push_back(fine_place(axis, k, (static_cast<double>(j) + 0.5) / kFiner));
  return places;
}

/// Fits of one law on a grid of its own: a law that can bend little knows drag better than one that can take its place.
struct Grid {
  std::size_t law = 0;
  const AirAndContact* known = nullptr;
  Axis kappa, tau;
  std::vector<FinePlace> fine_kappa, fine_tau;
  std::vector<Fitted> fits;  ///< kappa first
  std::size_t index(std::size_t i, std::size_t j) const { return i * tau.at.size() + j; }
  /// Of a place on the finer grid, in ln kappa and ln tau.
  double cell() const {
    return (kappa.at.size() > 1 ? kappa.distance() / kFiner : 1.0) *
           (tau.at.size() > 1 ? tau.distance() / kFiner : 1.0);
  }
};

/// A term of the sum of distributions.
struct Term {
  double weight = 0.0;
  const Grid* grid = nullptr;
  const FinePlace *kappa = nullptr, *tau = nullptr;
  /// Of what the fits have, between the computed places.
  template <class Of>
  double between(Of of) const {
    double sum = 0.0;
    for (const auto& [i, of_kappa] : kappa->neighbours)
      for (const auto& [j, of_tau] : tau->neighbours) sum += of_kappa * of_tau * of(grid->fits[grid->index(i, j)]);
    return sum;
  }
  bool is_there() const {
    return std::isfinite(between([](const Fitted& f) { return f.eps.empty() ? HUGE_VAL : f.surprise; }));
  }
};

/// With the logarithms of their weights.
std::vector<Term> terms_of(const Grid& grid) {
  std::vector<Term> terms;
  for (const FinePlace& kappa : grid.fine_kappa)
    for (const FinePlace& tau : grid.fine_tau) {
      Term term{0.0, &grid, &kappa, &tau};
      if (!term.is_there()) continue;
      term.weight = grid.known->ln_prior({kappa.at, tau.at}) -
                    term.between([](const Fitted& f) { return f.surprise; }) + log(grid.cell());
      terms.push_back(term);
    }
  return terms;
}

/// Weights instead of their logarithms, of those that matter.
std::vector<Term> normalized(std::vector<Term> terms) {
  double best = -HUGE_VAL, sum = 0.0;
  for (const Term& term : terms) best = std::max(best, term.weight);
  for (Term& term : terms) sum += term.weight = exp(term.weight - best);
  for (Term& term : terms) term.weight /= sum;
  std::erase_if(terms, [](const Term& term) { return term.weight < 1e-6; });
  return terms;
}

/// Of the terms in which there are drag and contact time; their weights need not add up to 1.
DeviationEstimate deviation_of(const std::vector<Term>& all) {
  DeviationEstimate e;
  std::vector<Term> terms;
  double open = 0.0, closed = 0.0;
  for (const Term& t : all) (t.grid->known->is_open() ? open : closed) += t.weight;
  e.is_ideal = closed > open;
  for (Term t : all) {
    if (!t.grid->known->is_open()) continue;
    t.weight /= open;
    terms.push_back(t);
  }
  for (const Term& t : terms) e.mean.ln_kappa += t.weight * t.kappa->at, e.mean.ln_tau += t.weight * t.tau->at;
  for (const Term& t : terms) {
    e.sd.ln_kappa += t.weight * square(t.kappa->at - e.mean.ln_kappa);
    e.sd.ln_tau += t.weight * square(t.tau->at - e.mean.ln_tau);
  }
  e.sd = {std::sqrt(e.sd.ln_kappa), std::sqrt(e.sd.ln_tau)};
  return e;
}

/// Student's distribution function, tabulated: a sum of thousands is asked for hundreds of times.
class Student {
 public:
  explicit Student(double nu) : reach_(nu < 3.0 ? 80.0 : 12.0) {
    for (std::size_t k = 0; k <= kSteps; ++k)
      below_[k] = student_t_below(-reach_ + static_cast<double>(k) * step(), nu);
  }
  double below(double t) const {
    if (t <= -reach_) return 0.0;
    if (t >= reach_) return 1.0;
    const double at = (t + reach_) / step(), k = std::floor(at);
    const auto i = std::min(static_cast<std::size_t>(k), kSteps - 1);
    return below_[i] + (at - k) * (below_[i + 1] - below_[i]);
  }
  /// Beyond it there is 1e-4 or less.
  double reach() const { return reach_; }

 private:
  static constexpr std::size_t kSteps = 4000;
  double step() const { return 2.0 * reach_ / static_cast<double>(kSteps); }
  double reach_;
  std::array<double, kSteps + 1> below_{};
};

/// A Student distribution with its weight.
struct Part {
  double weight, middle, se;
  const Student* student;
};

/// Quantiles of a sum of distributions, and value with errors by them.
Estimate estimate_of(const std::vector<Part>& parts) {
  double lo = HUGE_VAL, hi = -HUGE_VAL;
  for (const Part& p : parts) {
    const double reach = p.student->reach() * p.se;
    lo = std::min(lo, p.middle - reach), hi = std::max(hi, p.middle + reach);
  }
  const auto below = [&](double x) {
    double sum = 0.0;
    for (const Part& p : parts)
      sum += p.weight * (p.se > 0.0 ? p.student->below((x - p.middle) / p.se) : x >= p.middle ? 1.0 : 0.0);
    return sum;
  };
  const auto quantile = [&](double p) {
    double a = lo, b = hi;
    for (int i = 0; i < 60 && b - a > 1e-12; ++i) {
      const double x = 0.5 * (a + b);
      (below(x) < p ? a : b) = x;
    }
    return 0.5 * (a + b);
  };
  Estimate e;
  e.value = quantile(0.5);
  e.ci68 = Interval{quantile(0.158655253931457), quantile(0.841344746068543)};
  e.ci95 = Interval{quantile(0.025), quantile(0.975)};
  e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
  return e;
}

template <class Value, class Error>
Estimate estimate_of(const std::vector<Term>& terms, Value value, Error error) {
  std::map<double, Student> students;  // few: the degrees of freedom are those of a law
  std::vector<Part> parts;
  for (const Term& t : terms) {
    const double nu = t.grid->fits.front().nu;
    parts.push_back({t.weight, t.between(value),
                     std::max(0.0, t.between(error)) * t.between([](const Fitted& f) { return f.stretch; }),
                     &students.try_emplace(nu, nu).first->second});
  }
  return estimate_of(parts);
}

/// Variance of the mean of `value` over the places of one axis.
template <class Value, class Place>
double variance_along(const std::vector<Term>& terms, Value value, Place place) {
  std::map<double, std::pair<double, double>> sums;  // by place: weight, weight times value
  double mean = 0.0;
  for (const Term& t : terms) {
    const double x = t.between(value);
    auto& [w, wx] = sums[place(t)];
    w += t.weight, wx += t.weight * x, mean += t.weight * x;
  }
  double variance = 0.0;
  for (const auto& [at, sum] : sums) variance += sum.first * square(sum.second / sum.first - mean);
  return variance;
}

class Averaging {
 public:
  Averaging(const RestitutionSamples& samples, const AirAndContact& known, const LawFitConfig& config,
            std::vector<double> nodes_mps)
      : raw_(raw_of(samples)), known_(known), config_(config), nodes_mps_(std::move(nodes_mps)) {
    worlds_ = worlds_of(known_);
    config_.n_goodness = config_.n_bootstrap = 0;
    const Moved middle = moved(raw_, known_, {});
    if (nodes_mps_.empty()) nodes_mps_ = nodes_for(middle.data.v_mps);
    for (const Law& law : laws_of(middle.data, config_))
      models_.push_back(make_law_model(law.kind, law.orders, middle.data.v_mps));
    if (models_.size() > 1)
      if (std::optional<LawModel> step = step_of(middle.data)) models_.push_back(*std::move(step));
  }

  std::optional<AveragedCurve> run(DeviationEstimate& estimate) {
    std::deque<Grid> grids;
    std::vector<Term> terms;
    for (const AirAndContact& world : worlds_)
      for (std::size_t law = 0; law < models_.size(); ++law) {
        const std::vector<Term> of_law = resolved(law, world, grids);
        terms.insert(terms.end(), of_law.begin(), of_law.end());
      }
    terms = normalized(std::move(terms));
    if (terms.empty()) return std::nullopt;
    estimate = deviation_of(terms);
    return curve_of(terms, estimate);
  }

 private:
  static std::vector<double> nodes_for(const std::vector<double>& v_mps) {
    if (v_mps.size() < kFewest || v_mps.back() < kSpeedRatioMin * v_mps.front()) return {median(v_mps)};
    return spread_speeds(v_mps, 3);
  }

  Grid grid(std::size_t law, const AirAndContact& known, Deviation middle, Deviation sd) const {
    Grid grid{law,
              &known,
              axis_of(known.kappa_spread, middle.ln_kappa, kReach * sd.ln_kappa),
              axis_of(known.contact.spread, middle.ln_tau, kReach * sd.ln_tau),
              {},
              {},
              {}};
    grid.fine_kappa = finer(grid.kappa);
    grid.fine_tau = finer(grid.tau);
    grid.fits.resize(grid.kappa.at.size() * grid.tau.at.size());
    parallel_for(grid.fits.size(), 0, [&](std::size_t k) {
      const Deviation at{grid.kappa.at[k / grid.tau.at.size()], grid.tau.at[k % grid.tau.at.size()]};
      const Moved there = moved(raw_, known, at);
      Fitted& fitted = grid.fits[k];
      fitted = raw_.data.size() < kFewest ? fit_of_few(there.data, nodes_mps_.size())
                                          : fit_of(there.data, models_[law], config_, nodes_mps_);
      // the step may be at any sample
      if (models_[law].kind == LawKind::step) fitted.surprise += log(static_cast<double>(raw_.data.size()));
      // of the ratios as measured: their density is that of eps times d eps / d (T'/T)
      fitted.surprise -= there.ln_stretch;
    });
    return grid;
  }

  /// Terms of one law on a grid that resolves what samples know of drag and contact time.
  std::vector<Term> resolved(std::size_t law, const AirAndContact& known, std::deque<Grid>& grids) {
    grids.push_back(grid(law, known, {}, {known.kappa_spread, known.contact.spread}));
    std::vector<Term> terms = terms_of(grids.back());
    if (!known.is_open()) return terms;
    for (int round = 1; round < kMostRounds && !terms.empty(); ++round) {
      const double best = std::max_element(terms.begin(), terms.end(), [](const Term& a, const Term& b) {
                            return a.weight < b.weight;
                          })->weight;
      best_ = std::max(best_, best);
      const DeviationEstimate e = deviation_of(normalized(terms));
      const Grid& coarse = grids.back();
      if (best < best_ - kUnlikely || !is_too_coarse(coarse, e)) break;
      // should the best lie between two places
      const Deviation sd{std::max(e.sd.ln_kappa, 0.35 * coarse.kappa.distance()),
                         std::max(e.sd.ln_tau, 0.35 * coarse.tau.distance())};
      grids.push_back(grid(law, known, e.mean, sd));
      std::vector<Term> finer_terms = terms_of(grids.back());
      if (finer_terms.empty()) break;
      terms = std::move(finer_terms);
    }
    return terms;
  }

  static bool is_too_coarse(const Grid& grid, const DeviationEstimate& e) {
    constexpr double kEnough = 0.6;  // of the distance of places: a normal shape is then known at three or more of them
    return (grid.kappa.at.size() > 1 && e.sd.ln_kappa < kEnough * grid.kappa.distance()) ||
           (grid.tau.at.size() > 1 && e.sd.ln_tau < kEnough * grid.tau.distance());
  }

  AveragedCurve curve_of(const std::vector<Term>& terms, const DeviationEstimate& estimate) const {
    AveragedCurve curve;
    const std::size_t middle = nodes_mps_.size() / 2;
    for (std::size_t j = 0; j < nodes_mps_.size(); ++j) {
      curve.nodes.push_back({nodes_mps_[j], estimate_of(
                                                terms, [j](const Fitted& f) { return f.eps[j]; },
                                                [j](const Fitted& f) { return f.se[j]; })});
      curve.changes.push_back(estimate_of(
          terms, [j, middle](const Fitted& f) { return f.eps[j] - f.eps[middle]; },
          [j](const Fitted& f) { return f.change_se[j]; }));
    }
    std::vector<double> weights(models_.size(), 0.0);
    for (const Term& t : terms) weights[t.grid->law] += t.weight;
    for (std::size_t law = 0; law < models_.size(); ++law) curve.laws.emplace_back(name_of(models_[law]), weights[law]);
    constexpr double kNearlyCertain = 0.99;
    if (models_.back().kind == LawKind::step && weights.back() > kNearlyCertain) curve.step = step_at(estimate);
    std::stable_sort(curve.laws.begin(), curve.laws.end(), [](auto& a, auto& b) { return a.second > b.second; });
    const auto at_middle = [middle](const Fitted& f) { return f.eps[middle]; };
    const double variance = square(*curve.nodes[middle].eps.se);
    const auto share = [&](double part) { return variance > 0.0 ? std::min(1.0, part / variance) : 0.0; };
    curve.share_of_drag = share(variance_along(
        terms, at_middle, [](const Term& t) { return t.grid->known->is_open() ? t.kappa->at : -HUGE_VAL; }));
    curve.share_of_contact = share(variance_along(
        terms, at_middle, [](const Term& t) { return t.grid->known->is_open() ? t.tau->at : -HUGE_VAL; }));
    const auto log_normal = [](double median, double mean, double sd) {
      constexpr double k95 = 1.959963984540054;
      Estimate e;
      e.value = median * exp(mean);
      e.ci68 = Interval{e.value * exp(-sd), e.value * exp(sd)};
      e.ci95 = Interval{e.value * exp(-k95 * sd), e.value * exp(k95 * sd)};
      e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
      return e;
    };
    if (known_.has_drag && !estimate.is_ideal)
      curve.kappa_per_m = log_normal(kappa_at_1_mps(known_), estimate.mean.ln_kappa, estimate.sd.ln_kappa);
    if (known_.has_contact && !estimate.is_ideal)
      curve.contact_s = log_normal(known_.contact.at_1_mps_s, estimate.mean.ln_tau, estimate.sd.ln_tau);
    return curve;
  }

  std::optional<RestitutionStep> step_at(const DeviationEstimate& estimate) const {
    const LawModel& model = models_.back();
    const double v_mps = model.node_v_mps[2];
    const AirAndContact& known = estimate.is_ideal ? worlds_.back() : known_;
    const Fitted there = fit_of(moved(raw_, known, estimate.mean).data, model, config_, {v_mps * 0.9999, v_mps});
    if (there.eps.empty()) return std::nullopt;
    RestitutionStep step{v_mps, there.eps[1], there.eps[0], std::nullopt};
    const std::vector<std::size_t>& drops = raw_.data.drop;
    if (std::count(drops.begin(), drops.end(), drops.front()) != static_cast<std::ptrdiff_t>(drops.size())) return step;
    // speeds are in the order of those without drag and contact
    const LawData at = moved(raw_, known_, {}).data;
    const auto n_slower = std::lower_bound(at.v_mps.begin(), at.v_mps.end(), v_mps) - at.v_mps.begin();
    step.impact = *std::max_element(raw_.impact.begin() + n_slower, raw_.impact.end());
    return step;
  }

  Raw raw_;
  AirAndContact known_;
  std::vector<AirAndContact> worlds_;
  LawFitConfig config_;
  std::vector<double> nodes_mps_;
  std::vector<LawModel> models_;
  double best_ = -HUGE_VAL;  ///< logarithm of the largest weight so far
};

}  // namespace

std::optional<AveragedCurve> averaged_curve(const RestitutionSamples& samples, const AirAndContact& known,
                                            const LawFitConfig& config, std::vector<double> node_speeds_mps,
                                            DeviationEstimate& estimate) {
  if (samples.empty()) return std::nullopt;
  return Averaging(samples, known, config, std::move(node_speeds_mps)).run(estimate);
}

}  // namespace bouncelab::fit
