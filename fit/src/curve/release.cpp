// SPDX-License-Identifier: GPL-3.0-or-later

#include <algorithm>
#include <cmath>
#include <map>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "curve/curve_sum.hpp"

namespace bouncelab::fit {

std::vector<FirstFlights> first_flights(const RestitutionSamples& samples) {
  constexpr double kNearlyOne = 0.01;
  std::map<double, FirstFlights> by_speed;
  for (const RestitutionSample& s : samples) {
    if (s.impact != 1 || s.conditions.of_heights) continue;
    FirstFlights& flights = by_speed[std::round(log(s.v_mps) / kNearlyOne)];
    if (flights.samples.empty()) flights.v_mps = s.v_mps, flights.eps = s.eps;
    flights.samples.push_back(s);
  }
  std::vector<FirstFlights> all;
  for (auto& [at, flights] : by_speed) all.push_back(std::move(flights));
  return all;
}

double speed_of_first_impact(const FirstFlights& flights) { return flights.v_mps / std::clamp(flights.eps, 0.1, 1.0); }

/// Heights of the drops of one speed. @param ln_height  that of `flights.v_mps`
static void add_heights(const FirstFlights& flights, const Estimate& ln_height, std::vector<ReleaseHeight>& heights) {
  const double reach = 0.5 * (ln_height.ci95->hi - ln_height.ci95->lo);
  for (const RestitutionSample& s : flights.samples) {
    // the timing of the flight is an error apart
    const double timing = kNormal95 * 2.0 * s.sigma_v_mps.value_or(0.0) / s.v_mps;
    const double more = reach > 0.0 ? hypot(reach, timing) / reach : 1.0;
    Estimate ln = ln_height;
    ln.value += 2.0 * log(s.v_mps / flights.v_mps);
    for (std::optional<Interval>* interval : {&ln.ci68, &ln.ci95})
      *interval = Interval{ln.value + more * ((*interval)->lo - ln_height.value),
                           ln.value + more * ((*interval)->hi - ln_height.value)};
    heights.push_back({s.recording, s.drop, exp_of(ln)});
  }
}

/// What is known of samples whose flights are not seen, or were corrected, in the air that a drop falls through.
static AirAndContact in_air(AirAndContact known, const std::optional<Ball>& ball) {
  if (known.has_drag || known.air.density_kgpm3 == 0.0) return known;
  known.has_drag = true;
  known.ball = ball;
  return known;
}

std::optional<Rebound> rebound_within(const RestitutionSamples& samples, const AirAndContact& known) {
  const std::optional<Ball>& ball = samples.front().conditions.ball;
  const ReboundRule* rule = ball ? rebound_rule(*ball) : nullptr;
  if (!rule) return std::nullopt;
  constexpr double kNearly = 1.05;
  const AirAndContact of_drop = in_air(known, ball);
  Rebound rebound{*rule, OneAirAndContact(of_drop, {}).fall_mps(rule->height_m), {}};
  bool is_above = false, is_below = false;
  for (const RestitutionSample& s : samples) {
    is_above = is_above || s.v_mps * kNearly > rebound.v_mps;
    is_below = is_below || s.v_mps < rebound.v_mps * kNearly;
  }
  return is_above && is_below ? std::optional(std::move(rebound)) : std::nullopt;
}

/// The logarithm of a height that follows from eps at a speed, at each place linear about what is likely there.
/// @param j          of the speed
/// @param ln_height  (what is known, drag and contact time, eps)
/// @param more       (part, its derivative by eps, mean of eps, standard deviation of one bounce) changes a part
template <class LnHeight, class More>
Estimate SmoothCurve::height_at(const Sum& sum, std::size_t j, LnHeight ln_height, More more) const {
  const auto column = static_cast<Eigen::Index>(j);
  std::vector<Quantity> of_places;
  for (std::size_t c = 0; c < places_.size(); ++c) {
    const AirAndContact& known = places_[c].known();
    const Deviation at = places_[c].at();
    double eps = 0.0, weights = 0.0;
    for (const Term& term : sum.terms)
      if (term.curve == c) weights += term.weight, eps += term.weight * term.mean[column];
    of_places.emplace_back();
    if (!(weights > 0.0)) continue;
    eps /= weights;
    constexpr double kStep = 0.02;
    const auto moved = [&](double of_eps, Deviation off) {
      return ln_height(known, Deviation{at.ln_kappa + off.ln_kappa, at.ln_tau + off.ln_tau}, eps + of_eps);
    };
    const auto slope = [&](Deviation step, double of_eps) {
      return (moved(of_eps, step) - moved(-of_eps, {-step.ln_kappa, -step.ln_tau})) / (2.0 * kStep);
    };
    Quantity& quantity = of_places.back();
    quantity.offset = moved(0.0, {});
    const auto add = [&](Eigen::Index of, double factor, double about) {
      quantity.parts.emplace_back(of, factor);
      quantity.offset -= factor * about;
    };
    const auto n_speeds = static_cast<Eigen::Index>(sum.x.size());
    add(column, slope({}, kStep), eps);
    if (known.has_drag) add(n_speeds, slope({kStep, 0.0}, 0.0), log(kappa_at_1_mps(known)) + at.ln_kappa);
    if (known.has_contact) add(n_speeds + 1, slope({0.0, kStep}, 0.0), log(known.contact.at_1_mps_s) + at.ln_tau);
  }
  const auto quantity_of = [&](const Term& term) -> const Quantity& { return of_places[term.curve]; };
  const auto changed = [&](const Term& term, NormalPart& part) {
    const double one = noise_at(sum, term.curve, term.noise).variance(sum.x[j] - places_[term.curve].x_middle());
    more(part, of_places[term.curve].parts.front().second, term.mean[column], std::sqrt(one));
  };
  return stated(parts_of(sum.terms, quantity_of, changed), sum.balls, -50.0, 50.0);
}

static constexpr double kLeastEps = 0.05;

/// The launch u follows from the flight, the speed of impact 0 is w = u/eps, and a fall through the air from the height
/// lands with it. @param j  of the speed of the impact that the flights began with
void SmoothCurve::describe_heights(const Sum& sum, const FirstFlights& flights, std::size_t j) {
  const auto ln_height = [&](const AirAndContact& known, Deviation at, double eps) {
    constexpr double kHighest_m = 1e4;  // at its limit speed a ball may come from anywhere
    const OneAirAndContact one(known, at);
    const double launch_mps = one.flight_before(flights.v_mps, eps).launch_mps;
    return log(std::min(kHighest_m, one.fall_height_m(launch_mps / std::max(kLeastEps, eps))));
  };
  const auto with_scatter = [](NormalPart& part, double by_eps, double, double one_sd) {
    part.sd = hypot(part.sd, by_eps * one_sd);
  };
  add_heights(flights, height_at(sum, j, ln_height, with_scatter), curve_.heights);
}

/// With the eps that is stated, the root mean square.
void SmoothCurve::describe_rebound(const Sum& sum, const std::optional<Ball>& ball, Rebound& rebound) {
  const auto ln_height = [&](const AirAndContact& known, Deviation at, double eps) {
    const AirAndContact of_drop = in_air(known, ball);
    const OneAirAndContact one(of_drop, at);
    return log(one.rise_height_m(std::max(kLeastEps, eps) * one.fall_mps(rebound.rule.height_m)));
  };
  const auto root_mean_square = [](NormalPart& part, double by_eps, double mean, double one_sd) {
    part.mean += by_eps * (hypot(mean, one_sd) - mean);
  };
  rebound.height_m = exp_of(height_at(sum, sum.x.size() - 1, ln_height, root_mean_square));
}

}  // namespace bouncelab::fit
