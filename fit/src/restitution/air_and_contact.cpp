// SPDX-License-Identifier: GPL-3.0-or-later
#include "restitution/air_and_contact.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::fit {
namespace {

// A ball that is not named. From steel (.009/m) to table tennis (.13/m) kappa is that of the balls people drop.
constexpr double kKappa_per_m = 0.02, kKappaSpread = 1.1;
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

/// One of the balls people drop, without a name.
struct Usual {
  double ln_kappa, kappa_sd, ln_tau, tau_sd;
  double kappa_exponent;  ///< kappa goes as about this power of the speed: small balls' most
};
/// Those of the catalogue that have a size, and steel, marbles and superballs of the usual ones.
const std::vector<Usual>& usual_balls() {
  static const std::vector<Usual> balls = [] {
    std::vector<Usual> all;
    // of one kind balls differ, and drag is read off a curve of smooth spheres
    const auto add = [&](const std::string& text, double kappa_sd, double tau_sd) {
      const Ball ball = ball_from_text(text);
      if (const auto contact = contact_duration(ball, kGlass))
        all.push_back({log(drag_per_m(ball, {}, 1.0)), kappa_sd, log(contact->at_1_mps_s), tau_sd,
                       log(drag_per_m(ball, {}, 2.0) / drag_per_m(ball, {}, 0.5)) / log(4.0)});
    };
    for (const BallKind& kind : ball_kinds())
      if (kind.diameter_m) add(kind.name, 0.2, 0.35);
    for (const char* sized : {"steel:6mm", "steel:10mm", "glass:16mm", "superball:30mm"}) add(sized, 0.35, 0.5);
    return all;
  }();
  return balls;
}
constexpr double kSimulated = 0.05;  // share of sounds and times with neither air nor contact
constexpr double kAnyOther = 0.15;   // share of what is none of them

double normal_density(double x, double sd) { return exp(-0.5 * square(x / sd)) / sd; }

/// What may be of a ball that is not named: the density of one of the usual balls with its share, and of any other.
/// @param visit  (density, ball), ball null of any other
template <class Visit>
void for_each_possible(const AirAndContact& known, Deviation deviation, Visit visit) {
  const double ln_kappa = log(known.kappa_per_m) + deviation.ln_kappa;
  const double ln_tau = known.has_contact ? log(known.contact.at_1_mps_s) + deviation.ln_tau : 0.0;
  const auto of_contact = [&](double median, double sd) {
    return known.has_contact ? normal_density(ln_tau - median, sd) : 1.0;
  };
  visit(kAnyOther * normal_density(deviation.ln_kappa, kKappaSpread) *
            of_contact(log(kAnyContact.at_1_mps_s), kAnyContact.spread),
        nullptr);
  for (const Usual& one : usual_balls())
    visit((1.0 - kAnyOther) / static_cast<double>(usual_balls().size()) *
              normal_density(ln_kappa - one.ln_kappa, one.kappa_sd) * of_contact(one.ln_tau, one.tau_sd),
          &one);
}

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

}  // namespace

AirAndContact air_and_contact_of(const RestitutionSamples& samples) {
  AirAndContact known;
  if (samples.empty()) return known;
  const SampleConditions& said = samples.front().conditions;
  known.gravity_mps2 = said.gravity_mps2.value_or(kDefaultGravity_mps2);
  known.ball = said.ball;
  if (said.air_kgpm3) known.air.density_kgpm3 = *said.air_kgpm3;
  // speeds without a gravity are of no intervals: measured as they are
  const bool of_intervals = said.gravity_mps2.has_value();
  known.has_drag =
      of_intervals && !said.drag_corrected && known.air.density_kgpm3 > 0.0 && median_speed_mps(samples) < kFastest_mps;
  if (known.has_drag) {
    known.kappa_per_m = kKappa_per_m * known.air.density_kgpm3 / Air{}.density_kgpm3;
    known.kappa_spread = known.ball ? kKappaSpreadOfNamed : kKappaSpread;
  }
  known.contact = kAnyContact;
  if (said.ball) {
    if (const auto named = contact_duration(*said.ball, said.plate)) {
      known.contact = *named;
    } else if (const auto on_glass = said.plate ? std::nullopt : contact_duration(*said.ball, kGlass)) {
      known.contact = *on_glass;
      known.contact.spread = kSpreadOverPlates;
    }
  }
  known.has_contact = of_intervals && !said.contact_time_corrected && known.contact.at_1_mps_s > 0.0;
  if (!known.has_contact) known.contact = {0.0, 0.0, 0.0};
  return known;
}

AirAndContact as_found(AirAndContact known, Deviation mean, Deviation sd) {
  constexpr double kLeast = 1e-3;
  known.kappa_per_m *= exp(mean.ln_kappa);
  known.contact.at_1_mps_s *= exp(mean.ln_tau);
  if (known.has_drag) known.kappa_spread = std::max(kLeast, sd.ln_kappa);
  if (known.has_contact) known.contact.spread = std::max(kLeast, sd.ln_tau);
  return known;
}

std::vector<AirAndContact> worlds_of(const AirAndContact& known) {
  if (known.ball || !known.has_drag) return {known};
  AirAndContact ideal;
  ideal.gravity_mps2 = known.gravity_mps2;
  ideal.has_drag = ideal.has_contact = false;
  ideal.contact = {0.0, 0.0, 0.0};
  // the density of the other, of a normal in each of its parameters, leaves out 1/sqrt(2 pi) for each
  ideal.ln_share = log(kSimulated * (known.has_contact ? 2.0 * kPi : std::sqrt(2.0 * kPi)));
  return {known, ideal};
}

double AirAndContact::ln_prior(Deviation deviation) const {
  if (!is_open()) return ln_share;
  const auto normal = [](double x, double sd) { return sd > 0.0 ? -0.5 * square(x / sd) : 0.0; };
  if (!has_drag || ball) {
    return normal(deviation.ln_kappa, kappa_spread) + normal(deviation.ln_tau, contact.spread);
  }
  double sum = 0.0;
  for_each_possible(*this, deviation, [&](double density, const Usual*) { sum += density; });
  return log(sum);
}

OneAirAndContact::OneAirAndContact(const AirAndContact& known, Deviation deviation)
    : known_(known), kappa_factor_(exp(deviation.ln_kappa)), tau_factor_(exp(deviation.ln_tau)) {
  if (!known.has_drag || known.ball) return;
  double sum = 0.0;
  for_each_possible(known, deviation, [&](double density, const Usual* ball) {
    sum += density;
    if (ball) kappa_exponent_ += density * ball->kappa_exponent;
  });
  kappa_exponent_ = sum > 0.0 ? kappa_exponent_ / sum : 0.0;
}

double OneAirAndContact::kappa_per_m(double v_mps) const {
  if (!known_.has_drag) return 0.0;
  constexpr double kLeastSpeed_mps = 0.1;  // below it drag is nothing, and the power grows
  const double v = std::max(kLeastSpeed_mps, kSpeedOfDrag * v_mps);
  return kappa_factor_ *
         (known_.ball ? drag_per_m(*known_.ball, known_.air, v) : known_.kappa_per_m * pow(v, kappa_exponent_));
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

AtThePlate OneAirAndContact::at_the_plate(double v_mps, double eps, bool from_height) const {
  const double g = known_.gravity_mps2;
  const double before_s = 2.0 * v_mps / g;
  AtThePlate at;
  at.v_mps = from_height ? fall_with_drag_mps(v_mps * v_mps / (2.0 * g), g, kappa_per_m(v_mps))
                         : flight_before(v_mps, eps).landing_mps;
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
