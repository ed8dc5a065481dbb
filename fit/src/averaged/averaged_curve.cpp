// SPDX-License-Identifier: GPL-3.0-or-later
#include "averaged/averaged_curve.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <utility>

#include "averaged/axis.hpp"
#include "averaged/fit_of_law.hpp"
#include "averaged/student_sum.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "curve/release.hpp"
#include "law/law_search.hpp"

namespace bouncelab::fit {
namespace {

constexpr int kMostRounds = 4;     // of closing in
constexpr double kUnlikely = 9.0;  // in the logarithm: a law so far behind the best is left out of the grid

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
  const OneAirAndContact one(known, deviation);
  std::vector<AtThePlate> at;
  at.reserve(n);
  for (std::size_t k = 0; k < n; ++k)
    at.push_back(one.at_the_plate(raw.data.v_mps[k], raw.data.eps[k], raw.from_height[k]));
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
  /// Between those at the corners about it: where a likelihood falls off steeply, a cubic has maxima of its own.
  double surprise() const {
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (const std::size_t i : {kappa->below, kappa->above})
      for (const std::size_t j : {tau->below, tau->above}) {
        const double corner = grid->fits[grid->index(i, j)].surprise;
        least = std::min(least, corner), most = std::max(most, corner);
      }
    return std::clamp(between([](const Fitted& f) { return f.surprise; }), least, most);
  }
};

/// With the logarithms of their weights.
std::vector<Term> terms_of(const Grid& grid) {
  std::vector<Term> terms;
  for (const FinePlace& kappa : grid.fine_kappa)
    for (const FinePlace& tau : grid.fine_tau) {
      Term term{0.0, &grid, &kappa, &tau};
      if (!term.is_there()) continue;
      term.weight = grid.known->ln_prior({kappa.at, tau.at}) - term.surprise() + log(grid.cell());
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

/// @param of  value and standard error of a term
template <class Of>
Estimate estimate_of(const std::vector<Term>& terms, Of of, double outside = 0.05) {
  std::map<double, Student> students;  // few: the degrees of freedom are those of a law
  std::vector<Part> parts;
  for (const Term& t : terms) {
    const double nu = t.grid->fits.front().nu;
    const auto [value, se] = of(t);
    parts.push_back({t.weight, value, se, &students.try_emplace(nu, nu).first->second});
  }
  return estimate_of(parts, outside);
}

template <class Error>
double error_of(const Term& t, Error error) {
  return std::max(0.0, t.between(error)) * t.between([](const Fitted& f) { return f.stretch; });
}

template <class Value, class Error>
Estimate estimate_of(const std::vector<Term>& terms, Value value, Error error) {
  return estimate_of(terms, [&](const Term& t) { return std::pair{t.between(value), error_of(t, error)}; });
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
      : raw_(raw_of(samples)),
        first_(first_flights(samples)),
        known_(known),
        config_(config),
        nodes_mps_(std::move(nodes_mps)) {
    worlds_ = worlds_of(known_);
    config_.n_goodness = config_.n_bootstrap = 0;
    const Moved middle = moved(raw_, known_, {});
    if (nodes_mps_.empty()) nodes_mps_ = nodes_for(middle.data.v_mps);
    speeds_mps_ = nodes_mps_;
    // the nodes first; then, for the picture, places over all speeds
    constexpr std::size_t kPlaces = 25;
    const double lo = middle.data.v_mps.front(), hi = middle.data.v_mps.back();
    for (std::size_t k = 0; k < kPlaces && hi > kOneSpeed * lo; ++k)
      speeds_mps_.push_back(lo * pow(hi / lo, static_cast<double>(k) / (kPlaces - 1)));
    n_shown_ = speeds_mps_.size();
    // of impact 0, by the eps of impact 1: eps changes little with what that is off by
    for (const FirstFlights& flights : first_) speeds_mps_.push_back(speed_of_first_impact(flights));
    models_ = models_of(middle.data, config_);
  }

  std::optional<Curve> run(DeviationEstimate& estimate) {
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
    if (v_mps.size() < kFewest || v_mps.back() < kOneSpeed * v_mps.front()) return {median(v_mps)};
    return node_speeds(v_mps);
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
      fitted = raw_.data.size() < kFewest
                   ? fit_of_few(there.data, speeds_mps_.size())
                   : fit_of(there.data, models_[law], config_, speeds_mps_, nodes_mps_.size() / 2);
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
    constexpr double kNarrow = 0.35;  // in ln: between places so near everything is straight
    const auto too_coarse = [](const Axis& axis, double sd) {
      return axis.distance() > kNarrow && sd < kEnough * axis.distance();
    };
    return too_coarse(grid.kappa, e.sd.ln_kappa) || too_coarse(grid.tau, e.sd.ln_tau);
  }

  Curve curve_of(const std::vector<Term>& terms, const DeviationEstimate& estimate) const {
    Curve curve;
    const std::size_t middle = nodes_mps_.size() / 2;
    const auto change_at = [&](std::size_t j) {
      return estimate_of(
          terms, [j, middle](const Fitted& f) { return f.eps[j] - f.eps[middle]; },
          [j](const Fitted& f) { return f.change_se[j]; });
    };
    for (std::size_t j = 0; j < nodes_mps_.size(); ++j) {
      curve.nodes.push_back({nodes_mps_[j], estimate_of(
                                                terms, [j](const Fitted& f) { return f.eps[j]; },
                                                [j](const Fitted& f) { return f.se[j]; })});
      curve.changes.push_back(change_at(j));
    }
    if (n_shown_ > nodes_mps_.size()) curve.end_changes = {change_at(nodes_mps_.size()), change_at(n_shown_ - 1)};
    curve.n_drops = 1 + *std::max_element(raw_.data.drop.begin(), raw_.data.drop.end());
    for (std::size_t j = nodes_mps_.size(); j < n_shown_; ++j) {
      const Estimate e = estimate_of(
          terms, [j](const Fitted& f) { return f.eps[j]; }, [j](const Fitted& f) { return f.se[j]; });
      curve.points.push_back({speeds_mps_[j], e.value, e.ci95, e.se});
    }
    std::vector<double> weights(models_.size(), 0.0);
    for (const Term& t : terms) weights[t.grid->law] += t.weight;
    constexpr double kNearlyCertain = 0.99;
    if (models_.back().kind == LawKind::step && weights.back() > kNearlyCertain) curve.step = step_at(estimate);
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
    for (std::size_t k = 0; k < first_.size(); ++k)
      add_heights(first_[k], ln_height_of(terms, first_[k], n_shown_ + k), curve.heights);
    return curve;
  }

  /// @param j  the speed of the impact that the flights began with
  Estimate ln_height_of(const std::vector<Term>& terms, const FirstFlights& flights, std::size_t j) const {
    const auto of_term = [&, j](const Term& t) {
      const double of_curve = error_of(t, [j](const Fitted& f) { return f.se[j]; });
      const double of_bounce = t.between([](const Fitted& f) { return f.scatter; });
      const double eps = t.between([j](const Fitted&f) { return f.eps[j]; }), se = hypot(of_curve, of_bounce);
      const OneAirAndContact one(*t.grid->known, {t.kappa->at, t.tau->at});
      return std::pair{ln_release_height(flights, one, eps),
                       0.5 * (ln_release_height(flights, one, eps - se) - ln_release_height(flights, one, eps + se))};
    };
    // A ball that is not named is one of a dozen kinds, and the interval has to hold for each of them: beyond one end
    // of 95 % of their sum there may be a third of a kind whose share is 7 %.
    constexpr double kOutside = 0.05, kOutsideOfAny = 0.01;
    return estimate_of(terms, of_term, worlds_.size() > 1 ? kOutsideOfAny : kOutside);
  }

  std::optional<RestitutionStep> step_at(const DeviationEstimate& estimate) const {
    const LawModel& model = models_.back();
    const double v_mps = model.node_v_mps[2];
    const AirAndContact& known = estimate.is_ideal ? worlds_.back() : known_;
    const Fitted there = fit_of(moved(raw_, known, estimate.mean).data, model, config_, {v_mps * 0.9999, v_mps}, 1);
    if (there.eps.empty()) return std::nullopt;
    RestitutionStep step{v_mps, there.eps[1], there.eps[0],
                         normal_estimate(there.eps[1] - there.eps[0], hypot(there.se[0], there.se[1])), std::nullopt};
    const std::vector<std::size_t>& drops = raw_.data.drop;
    if (std::count(drops.begin(), drops.end(), drops.front()) != static_cast<std::ptrdiff_t>(drops.size())) return step;
    // speeds are in the order of those without drag and contact
    const LawData at = moved(raw_, known_, {}).data;
    const auto n_slower = std::lower_bound(at.v_mps.begin(), at.v_mps.end(), v_mps) - at.v_mps.begin();
    step.impact = *std::max_element(raw_.impact.begin() + n_slower, raw_.impact.end());
    return step;
  }

  Raw raw_;
  std::vector<FirstFlights> first_;
  AirAndContact known_;
  std::vector<AirAndContact> worlds_;
  LawFitConfig config_;
  std::vector<double> nodes_mps_, speeds_mps_;
  std::size_t n_shown_ = 0;  ///< of the speeds, nodes and picture; the others are those of first impacts
  std::vector<LawModel> models_;
  double best_ = -HUGE_VAL;  ///< logarithm of the largest weight so far
};

}  // namespace

std::optional<Curve> averaged_curve(const RestitutionSamples& samples, const AirAndContact& known,
                                    const LawFitConfig& config, std::vector<double> node_speeds_mps,
                                    DeviationEstimate& estimate) {
  if (samples.empty()) return std::nullopt;
  return Averaging(samples, known, config, std::move(node_speeds_mps)).run(estimate);
}

void to_mean_square(Curve& curve, const LawFit& law, double scatter) {
  curve.mean = curve.nodes;
  if (!law.scatter) return;
  const auto move = [](Estimate& e, double shift) {
    e.value += shift;
    for (std::optional<Interval>* interval : {&e.ci68, &e.ci95})
      if (*interval) (*interval)->lo += shift, (*interval)->hi += shift;
  };
  const NodeEstimate& middle = curve.mean[curve.mean.size() / 2];
  const double about_law = std::sqrt(law.scatter->variance(middle.v_mps));
  curve.scatter = std::min(about_law, scatter);
  const double smaller = about_law > 0.0 ? curve.scatter / about_law : 1.0;
  const auto to_mean = [&](double v_mps) { return smaller * law.scatter->mean_minus_peak(v_mps); };
  const auto shift = [&](double v_mps, double peak) {
    return std::sqrt(square(peak + to_mean(v_mps)) + square(smaller) * law.scatter->variance(v_mps)) - peak;
  };
  const double at_middle = shift(middle.v_mps, middle.eps.value);
  for (std::size_t k = 0; k < curve.nodes.size(); ++k) {
    const double v_mps = curve.nodes[k].v_mps, here = shift(v_mps, curve.nodes[k].eps.value);
    move(curve.nodes[k].eps, here);
    if (2 * k + 1 != curve.nodes.size()) move(curve.changes[k], here - at_middle);
  }
  for (std::size_t k = 0; k < curve.points.size(); ++k) {
    CurvePoint& p = curve.points[k];
    const double here = shift(p.x, p.y);
    if (k == 0) move(curve.end_changes.front(), here - at_middle);
    if (k + 1 == curve.points.size()) move(curve.end_changes.back(), here - at_middle);
    p.y += here;
    if (p.band95) p.band95->lo += here, p.band95->hi += here;
  }
  for (NodeEstimate& node : curve.mean) move(node.eps, to_mean(node.v_mps));
}

}  // namespace bouncelab::fit
