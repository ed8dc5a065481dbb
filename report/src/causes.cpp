// SPDX-License-Identifier: GPL-3.0-or-later
// Why eps is not the same at every bounce: the speed, the air, the roughness, each by its size in this recording.
#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "words.hpp"

namespace bouncelab::report {
using namespace fit;
namespace {

std::string speed(double v_mps) { return formatted("%.2g m/s", v_mps); }

/// "0.0069": two digits, without a power of ten.
std::string size_text(double x) {
  return formatted("%.*f", std::clamp(1 - static_cast<int>(std::floor(log10(std::max(x, 1e-9)))), 1, 9), x);
}

/// The change of eps between the least and the greatest speed; seen where the answer states one.
Cause of_speed(const FitResult& result, const PlainAnswer& answer) {
  const auto& step = result.curve->step;
  Cause cause{"speed", {}, !answer.elsewhere.empty() || step, {}};
  const auto& points = result.curve->points;
  if (points.empty()) {
    cause.sentence = "The effect of the speed is not known: the impacts have too few different speeds.";
    return cause;
  }
  const CurvePoint &slow = points.front(), &fast = points.back();
  double from_mps = slow.x, to_mps = fast.x, change = fast.y - slow.y;
  const auto& elsewhere = answer.elsewhere;
  if (elsewhere.size() == 1) {  // what the other end does is not seen
    const SpeedAndRestitution &at = *answer.at, &other = elsewhere[0];
    const bool is_faster = other.v_mps > at.v_mps;
    from_mps = is_faster ? at.v_mps : other.v_mps;
    to_mps = is_faster ? other.v_mps : at.v_mps;
    change = (is_faster ? 1.0 : -1.0) * (other.eps.value - at.eps.value);
  }
  cause.size = std::abs(change);
  const std::string between = " between " + speed(from_mps) + " and " + speed(to_mps);
  const double at_fast = fast.y - answer.at->eps.value, at_slow = slow.y - answer.at->eps.value;
  if (!cause.is_seen)
    cause.sentence = "No effect of the speed is seen" + between + ".";
  else if (step)
    cause.sentence = "the surface that the ball meets: ε steps by " + size_text(std::abs(step->change.value)) + " at " +
                     speed(step->v_mps) + ", and goes from " + size_text(slow.y) + " to " + size_text(fast.y) +
                     between + ".";
  else if (elsewhere.size() == 2 && at_fast * at_slow > 0.0) {
    cause.size = std::max(std::abs(at_fast), std::abs(at_slow));
    cause.sentence = "the speed: from its value at " + speed(answer.at->v_mps) +
                     (at_fast < 0.0 ? " ε falls by " : " ε rises by ") + size_text(std::abs(at_slow)) + " towards " +
                     speed(slow.x) + " and by " + size_text(std::abs(at_fast)) + " towards " + speed(fast.x) + ".";
  } else if (change < 0.0)
    cause.sentence = "the speed: a faster ball is pressed in more and loses more, ε falls by " +
                     size_text(*cause.size) + between + ".";
  else
    cause.sentence = "the speed: ε rises by " + size_text(*cause.size) + between + ".";
  return cause;
}

bool has_drag(const FitResult& result) { return result.curve->kappa_per_m.has_value(); }
bool of_heights(const RestitutionSamples& samples) { return !samples.empty() && samples.front().conditions.of_heights; }
bool ball_is_named(const RestitutionSamples& samples) {
  return !samples.empty() && samples.front().conditions.ball.has_value();
}

/// What drag takes from eps as the intervals have it, and as much as heights do, at the fastest bounce more than at the
/// slowest: eps kappa v^2 (1 + eps^2) / (4 g), docs/physics.md.
Cause of_air(const FitResult& result, const PlainAnswer& answer, const RestitutionSamples& samples) {
  Cause cause{"air", {}, false, {}};
  const auto& points = result.curve->points;
  if (!has_drag(result) || points.empty()) {
    cause.sentence = "No effect of the air is seen or taken into account.";
    return cause;
  }
  const double g_mps2 = samples.front().conditions.gravity_mps2.value_or(kDefaultGravity_mps2);
  const Estimate& kappa_per_m = *result.curve->kappa_per_m;
  const double eps = answer.at->eps.value, fast = points.back().x, slow = points.front().x;
  const double by_kappa = eps * (1.0 + eps * eps) * (square(fast) - square(slow)) / (4.0 * g_mps2);
  if (!ball_is_named(samples)) {
    cause.sentence = "The effect of the air is not known";
    if (kappa_per_m.ci95)
      cause.sentence += " (" + size_text(by_kappa * kappa_per_m.ci95->lo) + " to " +
                        size_text(by_kappa * kappa_per_m.ci95->hi) + " in ε)";
    cause.sentence += ": name the ball.";
    return cause;
  }
  cause.size = by_kappa * kappa_per_m.value;
  cause.is_seen = true;
  cause.sentence = std::string("the air, which slows fast flights most: ") +
                   (of_heights(samples) ? "the heights make" : "the time from bounce to bounce makes") + " ε look " +
                   size_text(*cause.size) + " smaller at " + speed(fast) + " than at " + speed(slow) +
                   " (taken out of the values here).";
  return cause;
}

/// The width of the band that holds two thirds of the bounces, at the middle speeds; seen where it is wider than the
/// errors of the times make it.
Cause of_roughness(const FitResult& result, const RestitutionSamples& samples) {
  Cause cause{"roughness", {}, false, {}};
  const auto& rows = result.budget.rows;
  const BudgetRow* row = rows.empty() ? nullptr : &rows[rows.size() / 2];
  constexpr std::size_t kFewestOfAWidth = 8;  // of fewer it is not known to a quarter
  if (!row || !row->spread_asperities || result.n_used < kFewestOfAWidth) {
    cause.sentence = "The roughness of ball and floor is not known: there are too few bounces.";
    return cause;
  }
  // what a law misses, or drops differ by, is no scatter of bounces
  const double spread = std::min(*row->spread_asperities, result.curve->scatter);
  cause.size = 2.0 * spread;
  const double timing = std::max(row->spread_timing_stated.value_or(0.0), row->spread_timing_lag1.value_or(0.0));
  cause.is_seen = spread > timing;
  const std::string errors = std::string("errors of the ") + measured_in_words(samples.front().conditions);
  cause.sentence = cause.is_seen
                       ? "the roughness of ball and floor: each bounce meets another spot, which turns some of "
                         "the motion into spin or back; two thirds of the bounces lie in a band of " +
                             size_text(*cause.size) + ", wider than " + errors + " make it."
                       : "No roughness of ball or floor is seen: the " + errors + " explain the scatter of ε.";
  return cause;
}

}  // namespace

std::vector<Cause> causes_of(const FitResult& result, const PlainAnswer& answer, const RestitutionSamples& samples) {
  if (!answer.at) return {};
  std::vector<Cause> causes{of_speed(result, answer), of_air(result, answer, samples), of_roughness(result, samples)};
  std::stable_sort(causes.begin(), causes.end(), [](const Cause& a, const Cause& b) {
    return (a.is_seen ? *a.size : -1.0) > (b.is_seen ? *b.size : -1.0);
  });
  const bool air_is_open = has_drag(result) && !ball_is_named(samples);
  for (std::size_t k = 0; k < causes.size(); ++k)
    if (causes[k].is_seen)
      causes[k].sentence = (k == 0 ? (air_is_open ? "Of what is seen, mostly " : "Mostly ")
                            : *causes[k].size > 0.5 * *causes[0].size ? "Nearly as much "
                            : *causes[k].size > 0.1 * *causes[0].size ? "Less "
                                                                      : "Hardly ") +
                           causes[k].sentence;
  return causes;
}

}  // namespace bouncelab::report
