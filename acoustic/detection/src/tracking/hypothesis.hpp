// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "tracking/observations.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

/// The flight that an interval is, if it is that of a ball after a flight of which the length is known.
struct Flight {
  double eps = 0.0;       ///< the same at each impact of the interval
  double flight_s = 0.0;  ///< the last flight in the interval
  double slope_s = 0.0;   ///< d interval / d eps [s]
};

/// @param interval_s  > 0
/// @param flight_s    of the flight before
/// @param n_missing   impacts within the interval that were not detected, 0 ... kMostMissing
/// @return absent where eps is outside kLeastEps ... kLargestEps, or the flight shorter than kShortestFlight_s
std::optional<Flight> flight_of(double interval_s, double flight_s, int n_missing);

/// What is known of a ball's log eps and loudness up to an impact: running means, and the scatter of log eps with a
/// conjugate prior, so that a few impacts already tell a smooth ball from a rough one. A single loss or gain leaves the
/// mean; if the next coefficient is like it, the mean begins anew.
class Bounces {
 public:
  /// @param log_flight     of the first flight [ln s]
  /// @param log_amplitude  of the first two impacts, their mean
  /// @param eps_of_fall    of the first impact, after a fall from a known height
  Bounces(double log_flight, double log_amplitude, std::optional<double> eps_of_fall = {});

  /// Density of the next impact [1/s, per unit of log amplitude].
  /// @param jitter2  variance that errors of the times add to log eps
  double density(const Flight& flight, double log_eps, double log_flight, double log_amplitude, int n_missing,
                 double jitter2) const;
  /// No less than that, whatever the loudness; without a logarithm.
  double largest_density(const Flight& flight, int n_missing, double jitter2) const;
  void learn(double log_eps, double log_flight, double log_amplitude, int n_missing, double jitter2);

  /// log of the probability that it loses energy, as no rhythm does: on the whole, since eps changed, and over each
  /// kTracking.memory impacts.
  /// @param log_flight  of the last flight [ln s]
  double log_probability_of_loss(double log_flight) const;

 private:
  /// By how many standard errors of its mean a loss is above the least.
  double widths_above_least(double loss, int n_eps) const;
  double learned_variance() const;
  double variance(double most_of_loss) const;  ///< what of it a ball can have
  /// Of the next log eps about the mean, itself known from a few, but for errors of the times.
  double variance_of_next(int n_missing) const;
  bool expects_eps() const { return n_eps_ > 0 || has_fall_; }

  int n_eps_ = 0;  ///< ratios of intervals
  int n_of_mean_ = 0;
  double mean_log_eps_ = 0.0;
  bool has_fall_ = false;                   ///< the mean is that of the fall until a ratio of intervals is known
  double sum_squares_ = 0.0;                ///< of the deviations of log eps from its running mean, large ones cut
  std::optional<double> changed_log_eps_;   ///< the last one, where it was far from the mean: it may stay
  double loss_ = 0.0;                       ///< -sum of log eps, large deviations cut
  double log_probability_of_losses_ = 0.0;  ///< over each kTracking.memory impacts of constant eps
  double first_log_flight_;
  Loudness loudness_;  ///< amplitude over the flight before
};

/// Density of eps where nothing is known of the ball.
double prior_of_eps(double eps);

/// Probability that n_missing impacts are not detected, and the next one is.
double probability_of_missing(int n_missing);

constexpr std::size_t kRhythmKinds = 2;  // by hand, by a machine

/// What the same sounds are as a rhythm: steps, claps, syllables, strokes, a metronome.
///
/// By hand, the log interval follows a local level with a trend (Harvey 1989, doi:10.1017/CBO9781107049994). By a
/// machine, beats stand in an even row and the sounds scatter about them: an alpha-beta filter of beat and interval,
/// with the gains of a growing, then exponentially forgotten line (Kalata 1984, doi:10.1109/TAES.1984.310438). A beat
/// may be left out, as impacts are, or divided by two. Loudness scatters about its running mean, whatever the interval.
class Rhythm {
 public:
  /// @param log_interval   of the first two sounds [ln s]
  /// @param log_amplitude  their mean
  Rhythm(double log_interval, double log_amplitude);

  /// Densities of the next sound [1/s, per unit of log amplitude], by kind; then takes it into the rhythm.
  /// @param sigma_s  of the two times [s]
  std::array<double, kRhythmKinds> follow(double interval_s, double log_amplitude, double sigma_s);

 private:
  double follow_by_hand(double interval_s, double sigma_s);
  double follow_by_machine(double interval_s, double sigma_s);

  double level_;  ///< of the log interval, by hand
  double trend_ = 0.0;
  double sum_squares_ = 0.0;
  double period_s_;                       ///< by machine
  double late_s_ = 0.0;                   ///< by which the last sound came after its beat
  double sum_squares_of_lateness_ = 0.0;  ///< in intervals
  int n_sounds_ = 2;
  Loudness loudness_;
};

/// A hypothesis: that a sequence of observations are the impacts of one ball. The same sounds are followed as a rhythm,
/// which a ball has to surpass. All odds are natural logarithms against clutter, so that sequences of any length
/// compare:
///
///   sum over impacts of log{ p(t, a | state) w / [ lambda(t, a) ] } + log p(LLR | event)/p(LLR) + prior of the birth
///
/// with the density of time and log amplitude under the ball, the weight w of one source, and the intensity of the
/// clutter (observations.hpp).
///
/// What an impact would add is a Step, which costs less than to take it: most steps are never taken.
class Hypothesis {
 public:
  /// One more impact, or the second.
  struct Step {
    double log_odds = 0.0;    ///< of the ball with it
    double flight_s = 0.0;    ///< last interval then, or what it would have been
    double log_flight = 0.0;  ///< [ln s]
    double log_eps = 0.0;
    double jitter2 = 0.0;     ///< variance that errors of the times add to log eps
    double of_clutter = 0.0;  ///< intensity of the clutter over the weight of one source
    int n_missing = 0;        ///< impacts before it that were not detected
  };

  /// The first two impacts; absent below the least log odds that are of interest.
  /// @param same_source  weight of one source, 0 ... 1
  /// @param is_counted   whether the track's own sounds are among its observations' neighbours
  static std::optional<Step> first_step(const Observation& first, const Observation& second, double same_source,
                                        bool is_counted, double least_log_odds = -INFINITY);
  Hypothesis(const Observation& first, const Observation& second, const Step& step);
  /// A track that begins with two impacts, whatever its odds.
  static Hypothesis begin(const Observation& first, const Observation& second, double same_source, bool is_counted);

  /// One more impact after n_missing that were not detected; absent where no ball does that, or below the least log
  /// odds that are of interest.
  std::optional<Step> step_to(const Observation& next, int n_missing, double same_source, bool is_counted,
                              double least_log_odds = -INFINITY) const;
  /// @param step  to `next`
  void take(const Step& step, const Observation& next);

  /// Of a ball that loses energy against clutter.
  double log_odds_of_losing_ball() const { return log_odds + log_probability_of_loss_; }
  /// Of a rhythm of either kind, which may have ended before, against clutter.
  double log_odds_of_rhythm() const;
  /// Of the ball against clutter, rhythms, and what loses no energy.
  double log_odds_of_ball() const;

  double log_odds = 0.0;       ///< of the ball, whether it loses energy or not
  double flight_s = 0.0;       ///< last interval, or what it would have been
  std::int64_t impact = 1;     ///< number of the last
  std::int64_t n_impacts = 2;  ///< detected

 private:
  struct Impact {
    double t_s = -1e9;  ///< long ago: there was none
    double log_amplitude = 0.0;
    double sigma_s = 0.0;
  };
  double own_density(const Observation& next, const Flight& flight, double log_eps, double same_source) const;
  double jitter2(const Observation& next) const;

  std::array<Impact, 3> last_;  ///< the last first
  double log_flight_;
  Bounces bounces_;
  double log_probability_of_loss_ = 0.0;  ///< that it loses energy, as no rhythm does
  Rhythm rhythm_;
  std::array<double, kRhythmKinds> log_odds_rhythm_;
  std::array<double, kRhythmKinds> most_log_odds_rhythm_{-1e9, -1e9};  ///< of one that ended there
};

/// Log odds that `before` is the impact before a track's first one.
/// @param flight_s      the track's first interval
/// @param mean_log_eps  of the track's first impacts, and how much they scatter
double log_odds_before(const Observation& before, const Observation& first, double same_source, double flight_s,
                       double mean_log_eps, double scatter);

}  // namespace bouncelab::detection
