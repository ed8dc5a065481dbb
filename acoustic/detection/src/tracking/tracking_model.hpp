// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "model_number.hpp"

namespace bouncelab::detection {

// physical limits of what is followed
constexpr double kShortestFirstFlight_s = 40e-3;  // a track begins with 0.2 m/s or more, a drop from 2 mm
constexpr double kLongestFlight_s = 2.5;          // a fall from 7.6 m
constexpr double kShortestFlight_s = 1e-3;
constexpr double kLeastEps = 0.2;    // a cold squash ball has 0.3
constexpr double kLargestEps = 1.2;  // single gains of a spinning ball
constexpr int kMostMissing = 2;      // impacts in a row that were not detected
constexpr double kMostGap = kLargestEps * (1.0 + kLargestEps * (1.0 + kLargestEps));  // of the last flight

/// The numbers of the model of tracks and clutter (docs/detector.md, "Tracks"): priors and scatters in natural
/// logarithms unless said otherwise. tests/bench/tracking_fit prints how the log score of recordings with and without
/// balls depends on each.
struct TrackingModel {
  // birth and end
  double start_log_odds = -1.5;  ///< of a ball that begins within birth_window_s, against none
  double birth_window_s = 4.0;
  double usual_first_flight_s = 0.4;    ///< median; a ball dropped from some 30 cm
  double first_flight_scatter = 0.6;    ///< of its logarithm
  double detection_probability = 0.93;  ///< of an impact

  // the ball: log eps
  double usual_eps = 0.8;       ///< until two flights are known
  double gains = 0.1;           ///< share of coefficients that may be above 1: a spinning ball
  double scatter = 0.015;       ///< of log eps from impact to impact, before the track itself shows it
  double scatter_weight = 3.0;  ///< impacts that this is worth: 0.003 and 0.06 are both plausible
  double most_scatter = 3.0;    ///< of log eps over its mean loss: a rough ball at its last impacts has 2.5
  double first_scatter = 0.08;  ///< of log eps at the first impact against those that follow
  double outliers = 0.07;       ///< share of single losses, gains and irregular beats
  double least_loss = 0.008;    ///< of log eps on the mean: steel on glass has 0.011 at 2 cm/s, a clock none
  int memory = 8;               ///< impacts over which eps and loudness are taken as constant
  double most_of_one = 3.0;     ///< widths by which one observation moves a running mean at most

  // what surrounds a track
  double unexplained = 2.0;   ///< log odds against a ball of each sound like its own but not of it
  double as_loud = 0.5;       ///< of its sounds' amplitudes, from which a sound is like them
  double row_flights = 1.25;  ///< before the first and after the last impact, where a row of other sounds would go on
  double echo_s = 40e-3;      ///< after an impact: what is fainter then is taken for its echo
  double timing_of_echo_s = 0.6e-3;  ///< scatter of its delay
  double same_echo_s = 3e-3;         ///< by which the delays of a row of echoes differ at most
  double rattle_log_odds = -2.0;     ///< of a plate that rattles after a ball's impacts
  double pre_echo_s = 14e-3;         ///< by which a codec's noise comes before an attack at most
  double echo_of_flight = 0.15;      ///< at most: where a flight is short, what follows may be anything

  /// Log odds by which a lower band must win: one ball in twelve is heard in it only, and the best of three is chosen.
  double lower_band = 2.5;

  // a track whose ball is known: its first impact is chosen anew
  std::size_t known_after = 6;     ///< impacts without the first
  std::size_t first_of_line = 10;  ///< coefficients that say what is expected before: by a line, which follows eps(v),
  std::size_t fewest_of_line = 5;  ///< or a mean of fewer than these

  // the probability of an impact
  double other_sound = 0.1;          ///< odds of a sound that no candidate stands for; counted among knocks
  double refused = 0.5;              ///< of an inferred impact where the search left a candidate out
  double same_sound_s = 3e-3;        ///< what is so near is noticed twice, or rises in steps
  double rise_of_template_s = 3e-3;  ///< between a template's time and that of the rise

  // loudness: log amplitude
  /// From the first impact to the second, of which eps is not known: the mean of loudness_exponent log eps over eps
  /// from 0.2 to 1, and its scatter with those of the exponent and of loudness.
  double usual_first_change = -0.75;
  double first_change_scatter = 0.85;
  double loudness_exponent = 1.3;  ///< of the speed of a ball, on the mean
  double exponent_scatter = 0.8;
  double loudness_scatter = 0.56;  ///< of amplitude over speed from impact to impact, before the track itself shows it
  double loudness_weight = 4.0;    ///< impacts that this is worth

  // likeness of the sounds after two impacts: Fisher's z of their correlation, artanh, which scatters normally
  double likeness = 1.05;  ///< of one ball's: median and scatter over balls and plates
  double likeness_scatter = 0.45;
  double other_likeness = 0.45;  ///< of sounds that make a track by chance, often of one source too: knocks, speech
  double other_likeness_scatter = 0.3;

  // rhythms: log interval
  double rhythm_log_odds = -0.5;    ///< of a rhythm against a ball
  double beat_scatter = 0.05;       ///< by hand: drummers 2 %, hands and feet 3 to 8 %
  double beat_weight = 2.0;         ///< intervals that this is worth
  double machine_scatter = 0.01;    ///< of a machine's beats about an even row, in intervals, before it shows its own
  double tempo_gain = 0.5;          ///< of the level that follows the interval
  double trend_gain = 0.15;         ///< of its trend
  double any_interval = 1.0 / 3.0;  ///< density of an irregular log interval, within a factor of 4.5 either way

  // clutter
  double kernel_width = 0.35;  ///< of log amplitude
  double unseen = 0.5;         ///< sounds that an interval without any counts as (Jeffreys's prior)
  double excess = 1.5;         ///< mean of LLR - threshold of fluctuations of a ringing sound, whatever the window,
  double excess_per_sample = 0.14;   ///< and for each sample of it
  double event_per_sample = 1.7;     ///< median of LLR - threshold of events, for each sample of the window
  std::size_t rise_neighbours = 24;  ///< candidates on either side, among which the share of events is estimated
  double rise_around_s = 1.0;        ///< and no farther
  double events_weight = 4.0;        ///< candidates that its prior of one half is worth

  // times of candidates
  double sharp_s = 1.8e-3;        ///< reach of the shortest window at 4 kHz and more; at 1 kHz all are longer
  double timing_samples = 2.0;    ///< their error in samples
  double timing_of_reach = 0.15;  ///< where a longer window has noticed them
};

BOUNCELAB_MODEL TrackingModel kTracking;

/// Density of Student's t with three degrees of freedom, scaled: a normal core, tails that forgive. Integrates to one.
/// @param width  > 0, in units of x
inline double student3(double x, double width) {
  const double width2 = width * width;
  const double core = width2 + x * x * (1.0 / 3.0);  // (1 + z^2 / 3) width^2
  return 2.0 / (kPi * std::numbers::sqrt3) * width2 * width / (core * core);
}

/// log(exp(a) + exp(b)), for any log odds: their exponentials may be beyond a double's range.
inline double log_of_sum(double a, double b) { return std::max(a, b) + log1p(exp(-std::abs(a - b))); }

/// No less than log(x), without taking it; of what is not a number no more than of 0.
inline double largest_log(double x) {
  return x > 0.0 ? std::numbers::ln2 * (std::ilogb(x) + 1) : -std::numeric_limits<double>::infinity();
}

/// What is known of the loudness of one source: a running mean of its logarithm, which gain control may carry along,
/// and its scatter with a conjugate prior. The same for balls and rhythms, so that neither is preferred for being even
/// or uneven; a ball's goes with a power of its speed, of which the exponent is not known well: hard balls have 1, soft
/// ones, whose slow impacts are long and dull, up to 4. So it is estimated with the mean, by regression with its prior.
class Loudness {
 public:
  /// @param mean        log loudness of the first two sounds
  /// @param log_flight  of a ball, before them [ln s]; 0 of a rhythm
  explicit Loudness(double mean, double log_flight = 0.0) : mean_(mean), mean_log_flight_(log_flight) {}

  /// Density of the next log loudness.
  double density(double log_loudness, double log_flight) const {
    return student3(deviation(log_loudness, log_flight), width(log_flight));
  }

  /// At the mean.
  double largest_density() const { return student3(0.0, std::sqrt(variance())); }

  void learn(double log_loudness, double log_flight) {
    const double most = kTracking.most_of_one * width(log_flight);
    const double step = std::clamp(deviation(log_loudness, log_flight), -most, most);
    const double own = std::min(1.0, std::sqrt(variance()) / width(log_flight)) * step;
    const double change = log_flight - mean_log_flight_;
    const double louder = exponent() * change + step;
    n_sounds_ = std::min(n_sounds_ + 1, kTracking.memory);
    const double kept = n_sounds_ < kTracking.memory ? 1.0 : 1.0 - 1.0 / kTracking.memory;
    const double others = 1.0 - 1.0 / n_sounds_;
    sum_squares_ = kept * (sum_squares_ + square(own));
    sum_change2_ = kept * (sum_change2_ + others * square(change));
    sum_change_louder_ = kept * (sum_change_louder_ + others * change * louder);
    mean_ += louder / n_sounds_;
    mean_log_flight_ += change / n_sounds_;
  }

 private:
  double deviation(double log_loudness, double log_flight) const {
    return log_loudness - mean_ - exponent() * (log_flight - mean_log_flight_);
  }
  double width(double log_flight) const {
    return std::sqrt(variance() * (1.0 + square(log_flight - mean_log_flight_) / (prior_weight() + sum_change2_)));
  }
  double prior_weight() const { return variance() / square(kTracking.exponent_scatter); }
  double exponent() const {
    return (prior_weight() * kTracking.loudness_exponent + sum_change_louder_) / (prior_weight() + sum_change2_);
  }
  double variance() const {
    return (kTracking.loudness_weight * square(kTracking.loudness_scatter) + sum_squares_) /
           (kTracking.loudness_weight + n_sounds_ - 2);
  }

  double mean_;
  double mean_log_flight_;
  double sum_squares_ = 0.0;
  double sum_change2_ = 0.0, sum_change_louder_ = 0.0;  // of log flight, and with that of loudness, about the means
  int n_sounds_ = 2;
};

}  // namespace bouncelab::detection
