// SPDX-License-Identifier: GPL-3.0-or-later
#include "restitution/air_and_contact.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::fit {
namespace {

// The standard curve is one of smooth spheres; balls have seams and felt.
constexpr double kKappaSpreadOfNamed = 0.1;
// Nothing known: from steel (30 us) to a basketball (15 ms).
constexpr ContactDuration kAnyContact{0.5e-3, 0.0, 1.7};
// Of a ball by Hertz on a plate that is not named: from steel to wood E* changes by 3 or more, the time as its -2/5.
constexpr double kSpreadOverPlates = 0.5;
// Where the drag of a flight is taken, of its speed at the plate: drag takes energy as C_d v^2, most of it there.
constexpr double kSpeedOfDrag = 0.85;
// No ball that is dropped in air gets so fast, and what drag does to such a flight grows without bound.
constexpr double kFastest_mps = 50.0;
// Of a flight that a contact would leave nothing of.
constexpr double kLeastFlight = 0.05;
// Of the shortest interval: no ball rests longer than it flies.
constexpr double kLongestContact = 1.0 / 3.0;

/// A normal distribution as a sum of narrower ones: their means, weights and standard deviation.
struct Part {
  double mean = 0.0, ln_weight = 0.0, sd = 0.0;
};
std::vector<Part> split(double mean, double sd, double narrow) {
  if (sd <= 1.15 * narrow) return {{mean, 0.0, sd}};
  const double wide = std::sqrt(sd * sd - narrow * narrow);
  const int n = static_cast<int>(std::ceil(0.75 * wide / narrow));
  std::vector<Part> parts;
  double sum = 0.0;
  for (int k = -n; k <= n; ++k) {
    const double off = 1.5 * narrow * k;
    parts.push_back({mean + off, -0.5 * square(off / wide), narrow});
    sum += exp(parts.back().ln_weight);
  }
  for (Part& part : parts) part.ln_weight -= log(sum);
  return parts;
}

/// ln tau of any ball: narrow where a contact is a share of the shortest interval, wide where it is nothing beside it.
std::vector<Part> split_contact(double mean, double sd, double shortest_s) {
  struct Cell {
    double middle, sd, width;
  };
  double middle = log(kLongestContact * shortest_s) - 0.2;
  std::vector<Cell> cells;
  for (int k = 0; k < 7; ++k, middle -= 0.4) cells.push_back({middle, 0.25, 0.4});
  middle = cells.back().middle - 0.7;
  for (int k = 0; k < 2; ++k, middle -= 1.0) cells.push_back({middle, 0.6, 1.0});
  cells.push_back({cells.back().middle - 1.5, 0.9, 2.0});
  std::vector<Part> parts;
  for (const Cell& cell : cells) {
    const double wide = std::sqrt(std::max(sd * sd - cell.sd * cell.sd, 0.2 * sd * sd));
    if (std::abs(cell.middle - mean) < 2.6 * wide + 0.3)
      parts.push_back({cell.middle,
                       log(cell.width / (wide * std::sqrt(2.0 * kPi))) - 0.5 * square((cell.middle - mean) / wide),
                       cell.sd});
  }
  return parts;
}

/// A ball that people drop, by its name to ball_from_text(), and the eps that such a one has at most on a hard floor.
struct Usual {
  const char* name;
  double kappa_sd, tau_sd;  ///< of their logarithms: of one kind balls differ, drag is that of smooth spheres
  double most_eps;
};
constexpr Usual kUsual[] = {
    {"table-tennis", 0.2, 0.35, 0.94}, {"tennis", 0.2, 0.35, 0.82},         {"basketball", 0.2, 0.35, 0.88},
    {"football", 0.2, 0.35, 0.88},     {"volleyball", 0.2, 0.35, 0.88},     {"squash", 0.2, 0.35, 0.65},
    {"golf", 0.2, 0.35, 0.90},         {"superball:27mm", 0.35, 0.5, 0.94}, {"superball:45mm", 0.35, 0.5, 0.94},
    {"steel:6mm", 0.35, 0.5, 1.0},     {"steel:10mm", 0.35, 0.5, 1.0},      {"steel:20mm", 0.35, 0.5, 1.0},
    {"glass:16mm", 0.35, 0.5, 1.0},    {"glass:25mm", 0.35, 0.5, 1.0},      {"acrylic:20mm", 0.35, 0.5, 1.0},
    {"billiard", 0.35, 0.5, 1.0}};
constexpr double kSimulated = 0.05;  // share of sounds and times with neither air nor contact
/// What is none of them: what air slows is hollow or foam, and soft.
struct AnyOther {
  double share, kappa_per_m, kappa_sd, tau_s, tau_sd, most_eps;
};
constexpr AnyOther kAnyOther[] = {{0.10, 0.017, 0.6, 0.5e-3, 1.7, 1.0}, {0.05, 0.12, 0.7, 1.5e-3, 1.0, 0.94}};

}  // namespace

double kappa_at_1_mps(const AirAndContact& known) {
  return known.ball ? drag_per_m(*known.ball, known.air, 1.0) : known.kappa_per_m;
}

namespace {

double median_speed_mps(const RestitutionSamples& samples) {
  std::vector<double> speeds_mps;
  for (const RestitutionSample& s : samples)
    if (std::isfinite(s.v_mps)) speeds_mps.push_back(s.v_mps);
  return speeds_mps.empty() ? 0.0 : median(std::move(speeds_mps));
}

/// What the samples say, without drag and contact time.
AirAndContact conditions_of(const RestitutionSamples& samples) {
  AirAndContact known;
  known.contact = {0.0, 0.0, 0.0};
  known.has_drag = known.has_contact = false;
  if (samples.empty()) return known;
  const SampleConditions& said = samples.front().conditions;
  known.gravity_mps2 = said.gravity_mps2.value_or(kDefaultGravity_mps2);
  if (said.air_kgpm3) known.air.density_kgpm3 = *said.air_kgpm3;
  known.has_drag = said.of_flights() && !said.drag_corrected && known.air.density_kgpm3 > 0.0 &&
                   median_speed_mps(samples) < kFastest_mps;
  known.of_heights = said.of_heights;
  known.has_contact = said.of_flights() && !said.contact_time_corrected && !said.of_heights;
  return known;
}

/// A ball with what is known of its contact; the time of any ball where nothing is.
AirAndContact with_ball(AirAndContact known, const std::string& name, const Ball& ball,
                        const std::optional<Material>& plate) {
  known.name = name;
  known.ball = ball;
  if (known.has_drag) known.kappa_spread = kKappaSpreadOfNamed;
  if (!known.has_contact) return known;
  known.contact = kAnyContact;
  if (const auto of_ball = contact_duration(ball, plate)) {
    known.contact = *of_ball;
  } else if (const auto on_glass = plate ? std::nullopt : contact_duration(ball, kGlass)) {
    known.contact = *on_glass;
    known.contact.spread = kSpreadOverPlates;
  }
  known.has_contact = known.contact.at_1_mps_s > 0.0;
  if (!known.has_contact) known.contact = {0.0, 0.0, 0.0};
  return known;
}

/// The same in parts that are each linear in ln tau.
void add_parts(const AirAndContact& whole, double shortest_s, std::vector<AirAndContact>& places) {
  constexpr double kNothing = 0.03, kNarrow = 0.24, kWide = 1.0;
  if (!whole.has_contact) return places.push_back(whole);
  const double ln_tau = log(whole.contact.at_1_mps_s), sd = whole.contact.spread;
  const std::vector<Part> parts = sd > kWide ? split_contact(ln_tau, sd, shortest_s)
                                  : whole.contact.at_1_mps_s > kNothing * shortest_s
                                      ? split(ln_tau, sd, kNarrow)
                                      : std::vector{Part{ln_tau, 0.0, sd}};
  for (const Part& part : parts) {
    if (exp(part.mean) > kLongestContact * shortest_s && parts.size() > 1) continue;
    places.push_back(whole);
    places.back().contact.at_1_mps_s = exp(part.mean);
    places.back().contact.spread = part.sd;
    places.back().ln_share += part.ln_weight;
  }
}

}  // namespace

double shortest_interval_s(const RestitutionSamples& samples, double gravity_mps2) {
  double shortest_s = HUGE_VAL;
  for (const RestitutionSample& s : samples)
    if (s.v_mps > 0.0 && s.eps > 0.0)
      shortest_s = std::min(shortest_s, 2.0 * s.v_mps / gravity_mps2 * std::min(1.0, s.eps));
  return shortest_s;
}

AirAndContact air_and_contact_of(const RestitutionSamples& samples) {
  AirAndContact known = conditions_of(samples);
  if (!samples.empty() && samples.front().conditions.ball)
    return with_ball(known, to_text(*samples.front().conditions.ball), *samples.front().conditions.ball,
                     samples.front().conditions.plate);
  known.has_drag = known.has_contact = false;
  return known;
}

std::vector<AirAndContact> places_of(const RestitutionSamples& samples) {
  const AirAndContact conditions = conditions_of(samples);
  if (samples.empty() || !conditions.is_open()) return {conditions};
  const SampleConditions& said = samples.front().conditions;
  const double shortest_s = shortest_interval_s(samples, conditions.gravity_mps2);
  std::vector<AirAndContact> places;
  if (said.ball) {
    const AirAndContact named = air_and_contact_of(samples);
    constexpr double kWide = 1.0;
    if (named.contact.spread > kWide)
      add_parts(named, shortest_s, places);
    else
      places.push_back(named);
    return places;
  }
  double left = 1.0 - kSimulated;
  for (const AnyOther& other : kAnyOther) left -= other.share;
  for (const Usual& usual : kUsual) {
    AirAndContact place = with_ball(conditions, usual.name, ball_from_text(usual.name), said.plate);
    place.is_named = false;
    place.ln_share = log(left / std::size(kUsual));
    if (place.has_drag) place.kappa_spread = usual.kappa_sd;
    if (place.has_contact) place.contact.spread = usual.tau_sd;
    place.most_eps = usual.most_eps;
    add_parts(place, shortest_s, places);
  }
  AirAndContact simulated = conditions;
  simulated.has_drag = simulated.has_contact = simulated.is_named = false;
  simulated.ln_share = log(kSimulated);
  places.push_back(simulated);
  for (const AnyOther& other : kAnyOther)
    for (const Part& kappa : split(log(other.kappa_per_m), other.kappa_sd, 0.55)) {
      AirAndContact place = conditions;
      place.is_named = false;
      place.ln_share = log(other.share) + kappa.ln_weight;
      if (place.has_drag) {
        place.kappa_per_m = exp(kappa.mean) * conditions.air.density_kgpm3 / Air{}.density_kgpm3;
        place.kappa_spread = kappa.sd;
      }
      if (place.has_contact) place.contact = {other.tau_s, 0.0, other.tau_sd};
      place.most_eps = other.most_eps;
      add_parts(place, shortest_s, places);
    }
  return places;
}

OneAirAndContact::OneAirAndContact(const AirAndContact& known, Deviation deviation)
    : known_(known), kappa_factor_(exp(deviation.ln_kappa)), tau_factor_(exp(deviation.ln_tau)) {}

double OneAirAndContact::kappa_per_m(double v_mps) const {
  if (!known_.has_drag || v_mps > kFastest_mps) return 0.0;
  constexpr double kLeastSpeed_mps = 0.1;  // below it drag is nothing, and the power grows
  const double v = std::max(kLeastSpeed_mps, kSpeedOfDrag * v_mps);
  return kappa_factor_ * (known_.ball ? drag_per_m(*known_.ball, known_.air, v) : known_.kappa_per_m);
}

double OneAirAndContact::contact_s(double v_mps) const {
  return known_.has_contact ? tau_factor_ * known_.contact.at(v_mps) : 0.0;
}

Flight OneAirAndContact::flight_before(double v_mps, double eps) const {
  const double g = known_.gravity_mps2;
  const double before_s = 2.0 * v_mps / g;
  // the contact with which the interval begins: the ball came down there by 1/eps faster than it went up
  const double flight_s = std::max(kLeastFlight * before_s, before_s - contact_s(v_mps / std::clamp(eps, 0.2, 1.0)));
  return flight_with_drag(flight_s, g, kappa_per_m(0.5 * g * flight_s));
}

double OneAirAndContact::fall_height_m(double speed_mps) const {
  return bouncelab::fall_height_m(speed_mps, known_.gravity_mps2, kappa_per_m(speed_mps));
}

double OneAirAndContact::fall_mps(double height_m) const {
  const double g = known_.gravity_mps2;
  return fall_with_drag_mps(height_m, g, kappa_per_m(std::sqrt(2.0 * g * height_m)));
}

double OneAirAndContact::rise_height_m(double launch_mps) const {
  return bouncelab::rise_height_m(launch_mps, known_.gravity_mps2, kappa_per_m(launch_mps));
}

AtThePlate OneAirAndContact::at_the_plate(double v_mps, double eps, bool from_height) const {
  const double g = known_.gravity_mps2;
  const double before_s = 2.0 * v_mps / g;
  AtThePlate at;
  if (known_.of_heights) {  // the launch that rises to h': u^2 = (g/kappa) (exp(2 kappa h') - 1)
    at.v_mps = fall_mps(v_mps * v_mps / (2.0 * g));
    const double launch_mps = eps * v_mps, twice_kappa_h = kappa_per_m(launch_mps) * square(launch_mps) / g;
    const double more = std::sqrt(twice_kappa_h > 1e-6 ? (exp(twice_kappa_h) - 1.0) / twice_kappa_h : 1.0);
    at.eps = more * launch_mps / at.v_mps;
    at.stretch = exp(twice_kappa_h) / more * v_mps / at.v_mps;
    return at;
  }
  at.v_mps = from_height ? fall_mps(v_mps * v_mps / (2.0 * g)) : flight_before(v_mps, eps).landing_mps;
  const double after_s = eps * before_s, rest_s = after_s - contact_s(at.v_mps);
  if (rest_s > kLeastFlight * std::abs(after_s)) {
    const double kappa = kappa_per_m(0.5 * g * rest_s);
    at.eps = flight_with_drag(rest_s, g, kappa).launch_mps / at.v_mps;
    // the launch grows with the flight as kappa v^2/g faster than in proportion, twice its own share
    at.stretch = v_mps / at.v_mps * (1.0 + 0.75 * kappa * square(0.5 * g * rest_s) / g);
  } else {
    at.eps = eps * kLeastFlight * v_mps / at.v_mps;
    at.stretch = kLeastFlight * v_mps / at.v_mps;
  }
  return at;
}

RestitutionSamples at_the_plate(RestitutionSamples samples, const AirAndContact& known, Deviation deviation) {
  if (!known.is_open()) return samples;
  const OneAirAndContact one(known, deviation);
  for (RestitutionSample& s : samples) {
    if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps) || !(s.v_mps > 0.0)) continue;
    const AtThePlate at = one.at_the_plate(s.v_mps, s.eps, s.impact == 0);
    s.v_mps = at.v_mps;
    s.eps = at.eps;
    if (s.sigma_eps) *s.sigma_eps *= at.stretch;
    s.conditions.drag_corrected = s.conditions.contact_time_corrected = true;
  }
  return samples;
}

}  // namespace bouncelab::fit
