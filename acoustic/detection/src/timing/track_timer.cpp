// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/track_timer.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "timing/cycle_ambiguity.hpp"

namespace bouncelab::detection {
namespace {

// of the interval: four times the scatter of the train's own ratios, within these
constexpr double kLeastEpsReach = 0.015;
constexpr double kMostEpsReach = 0.06;  // four times the scatter that train_model.cpp starts from
// where nothing is found so near, a single loss or gain may be the reason: 0.73 to 1.07 of what is expected
constexpr double kOutlierCentre = 0.9;
constexpr double kOutlierReach = 0.17;
constexpr double kStepOfWave = 0.25;
constexpr double kShortestInterval_s = 1.2e-3;
constexpr double kLargestAmplitudeRatio = 3.5;  // between neighbours; eps and the place struck explain up to two
constexpr double kCyclesApart = 3.0;            // of the wave, nearer impacts cannot be told from its ringing
constexpr double kClearRise = 20.0;             // log likelihood ratio that no noise reaches in hours
constexpr double kReliable = 0.7;               // half of an impact's energy is the wave's
constexpr double kAmbiguous = 1e-3;             // odds of another place that are worth a flag
constexpr int kMostFailures = 3;                // impacts not heard in a row, then the train is over

// Gain over residual_variance from which an impact is believed. Under what still rings of others the misfit is that of
// few modes and not that of noise, so that `threshold` says nothing: a rise where the train expects it needs least, a
// place between two impacts more, one beyond the train's end most.
constexpr double kLlrOfCandidate = 1.3;
constexpr double kLlrOfGap = 2.0;
constexpr double kLlrBeyondEnd = 3.0;
constexpr double kLlrOfOutlier = 6.0;
// gain of an impact beyond the end over what the sound before it, where there is none, would offer: echoes, a ball that
// rolls and voices sound like the wave here and there
constexpr double kProminence = 2.0;

/// Log likelihood ratio that noise alone exceeds once in a hundred searches over n lags: the maximum of n squared
/// normals. A train goes on more often than not, so that a hundredth is enough.
double threshold(double n_lags) { return std::log(n_lags) + 4.6; }

class TrackTimer {
 public:
  TrackTimer(const audio::AudioSource& sound, const ImpactTemplate& wave, double end_s)
      : timer_(sound, wave),
        wave_(wave),
        sound_(sound),
        wave_s_(static_cast<double>(wave.n_template) / sound.rate_hz),
        end_s_(end_s),
        shortest_interval_s_(std::max(kShortestInterval_s, kCyclesApart / (wave.wave.rms_frequency() * sound.rate_hz))),
        wave_is_reliable_(wave.correlation > kReliable) {}

  /// A heard impact. @param next_s  the next one, as far as known
  void add(const Candidate& c, std::int64_t impact, double next_s) {
    const double last_s = onsets_.empty() ? -1.0 : onsets_.back().timed.t_s;
    const double reach_s = std::min({c.reach_s, 0.25 * (next_s - c.t_s), 0.25 * (c.t_s - last_s)});
    keep({impact, search(c.t_s, reach_s, next_s), next_s, false, next_s - c.t_s < wave_s_});
  }

  /// Searches for impacts between the last one and the next heard one.
  void fill_gap(std::int64_t next_impact, double next_s) {
    const std::int64_t n_missing = next_impact - onsets_.back().impact - 1;
    for (std::int64_t m = 0; m < n_missing; ++m) {
      const double left = static_cast<double>(n_missing - m);
      const double rest_s = next_s - onsets_.back().timed.t_s;
      // the intervals left are about a geometric series with the ratio of the one before
      const double eps = last_eps();
      const double expected_s = rest_s * (1.0 - eps) / (1.0 - std::pow(eps, left + 1.0));
      if (!search_missing(onsets_.back().impact + 1, expected_s, next_s, kLlrOfGap)) return;
    }
  }

  /// Follows the train beyond its last impact.
  void extend() {
    for (int failures = 0; failures < kMostFailures && onsets_.size() >= 3;) {
      const double eps = last_eps();
      double expected_s = last_flight();
      double sum_s = 0.0;
      for (int k = 0; k <= failures; ++k) sum_s += expected_s *= eps;
      if (expected_s < shortest_interval_s_ || onsets_.back().timed.t_s + sum_s + 0.5 * expected_s > end_s_) break;
      const std::int64_t next = onsets_.back().impact + 1 + failures;
      const double until_s = onsets_.back().timed.t_s + sum_s + 0.9 * expected_s;
      const bool found = search_missing(next, sum_s, until_s, kLlrBeyondEnd) ||
                         (failures == 0 &&
                          search_missing(next, kOutlierCentre * sum_s, kOutlierReach * sum_s, until_s, kLlrOfOutlier));
      failures = found ? 0 : failures + 1;
    }
  }

  /// Gives up the last impact where the wave does not support it; where impacts do not sound alike, the wave has no
  /// say.
  bool trim_tail(const Candidate& c) {
    if (onsets_.size() <= 3) return false;
    const double interval_s = onsets_.back().timed.t_s - onsets_[onsets_.size() - 2].timed.t_s;
    // what rises out of quiet is an impact though it sound unlike the others; within their sound it may be an echo
    if (!wave_is_reliable_ && (c.log_likelihood_ratio > kClearRise || interval_s > wave_s_)) return false;
    const bool rises_out_of_quiet = c.log_likelihood_ratio > kClearRise && interval_s > wave_s_;
    if (is_supported(onsets_.back(), onsets_[onsets_.size() - 2], 100.0, kLlrOfCandidate, rises_out_of_quiet))
      return false;
    onsets_.pop_back();
    return true;
  }

  /// Decides what may be a cycle off, and hands over.
  std::vector<TimedTrackImpact> take() {
    std::vector<ImpactHypotheses> places;
    for (const TimedTrackImpact& onset : onsets_) {
      places.push_back({onset.impact, {{onset.timed.t_s, 0.0}}});
      places.back().places.insert(places.back().places.end(), onset.timed.others.begin(), onset.timed.others.end());
    }
    const std::vector<CycleChoice> choices = resolve_cycle_slips(places);
    ImpactTimer again(sound_, wave_);
    for (std::size_t k = 0; k < onsets_.size(); ++k) {
      TimedTrackImpact& onset = onsets_[k];
      const double next_s = k + 1 < onsets_.size() ? onsets_[k + 1].timed.t_s : INFINITY;
      const bool next_was_unknown = next_s - onset.timed.t_s < wave_s_ && onset.until_s > next_s + kShortestInterval_s;
      if (choices[k].place > 0 || next_was_unknown) {
        onset.until_s = std::min(onset.until_s, next_s);
        onset.timed = again.time(places[k].places[choices[k].place].t_s, 0.0, onset.until_s);
        onset.overlap = onset.overlap || next_was_unknown;
      }
      doubt(places[k].places, choices[k], onset);
      again.subtract_from_later(onset.timed);
    }
    return std::move(onsets_);
  }

 private:
  /// What the other places, with odds exp(-log_odds_margin), add to the variance about the chosen one.
  static void doubt(const std::vector<DelayHypothesis>& places, const CycleChoice& choice, TimedTrackImpact& onset) {
    double elsewhere = 0.0, squares = 0.0;
    for (std::size_t p = 0; p < places.size(); ++p) {
      if (p == choice.place) continue;
      const double odds = std::exp(-choice.log_odds_margin[p]);
      elsewhere += odds;
      squares += odds * std::pow(places[p].t_s - onset.timed.t_s, 2);
    }
    onset.doubtful = elsewhere > kAmbiguous;
    onset.doubt_s = std::sqrt(squares / (1.0 + elsewhere));
  }

  void keep(const TimedTrackImpact& onset) {
    timer_.subtract_from_later(onset.timed);
    onsets_.push_back(onset);
  }

  /// The most likely impact within reach_s. A window that begins after an impact misses its loudest part, so that a
  /// wide search takes several.
  TimedImpact search(double t_s, double reach_s, double until_s) {
    const double step_s = kStepOfWave * wave_s_;
    TimedImpact best = timer_.time(t_s, reach_s, until_s);
    if (reach_s < step_s) return best;
    for (double from_s = t_s - reach_s; from_s < t_s + reach_s; from_s += step_s) {
      const TimedImpact here = timer_.time(from_s, step_s, until_s);
      if (here.log_likelihood_ratio > best.log_likelihood_ratio && std::abs(here.t_s - t_s) <= reach_s) best = here;
    }
    return best;
  }

  /// The last flight, or what it was where impacts before the last are missing.
  double last_flight() const {
    const TimedTrackImpact& last = onsets_.back();
    const TimedTrackImpact& before = onsets_[onsets_.size() - 2];
    const auto n = static_cast<double>(last.impact - before.impact);
    const double eps = last_eps();
    return (last.timed.t_s - before.timed.t_s) * std::pow(eps, n - 1.0) * (1.0 - eps) / (1.0 - std::pow(eps, n));
  }

  /// Ratios of the last intervals, at most nine, sorted.
  std::vector<double> last_ratios() const {
    std::vector<double> ratios;
    for (std::size_t k = onsets_.size(); k-- > 2 && ratios.size() < 9;)
      if (onsets_[k].impact - onsets_[k - 2].impact == 2)
        ratios.push_back((onsets_[k].timed.t_s - onsets_[k - 1].timed.t_s) /
                         (onsets_[k - 1].timed.t_s - onsets_[k - 2].timed.t_s));
    std::sort(ratios.begin(), ratios.end());
    return ratios;
  }

  /// Their median; 1 - 1e-3 at most, so that the geometric series stays one.
  double last_eps() const {
    const std::vector<double> ratios = last_ratios();
    return ratios.empty() ? 0.97 : std::clamp(ratios[ratios.size() / 2], 0.3, 0.999);
  }

  /// How far the next interval may be off, as a share of it.
  double eps_reach() const {
    constexpr double kHalfToSigma = 0.74;  // half of a normal lies within 1.35 sigma
    const std::vector<double> ratios = last_ratios();
    if (ratios.size() < 7) return kMostEpsReach;
    const double half = ratios[3 * ratios.size() / 4] - ratios[ratios.size() / 4];
    return std::clamp(4.0 * kHalfToSigma * half, kLeastEpsReach, kMostEpsReach);
  }

  /// Amplitude over interval before of what was heard, not inferred; the median, where there are a few.
  std::optional<double> amplitude_per_s() const {
    constexpr std::size_t kFewest = 4;
    std::vector<double> ratios;
    for (std::size_t k = onsets_.size(); k-- > 1 && ratios.size() < 15;)
      if (!onsets_[k].inferred && onsets_[k].impact == onsets_[k - 1].impact + 1)
        ratios.push_back(onsets_[k].timed.amplitude / (onsets_[k].timed.t_s - onsets_[k - 1].timed.t_s));
    if (ratios.size() < kFewest) return std::nullopt;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return *middle;
  }

  /// Whether an impact so loud goes with its speed as those that were heard did.
  bool has_plausible_amplitude(double amplitude, double interval_s) const {
    const std::optional<double> per_s = amplitude_per_s();
    if (!per_s) return true;
    const double ratio = amplitude / (*per_s * interval_s);
    return ratio > 1.0 / kLargestAmplitudeRatio && ratio < kLargestAmplitudeRatio;
  }

  /// @param min_llr_ratio  least gain in units of what is left of other sounds
  /// @param any_loudness  whether it may be as faint or loud as it likes
  bool is_supported(const TimedTrackImpact& onset, const TimedTrackImpact& neighbour, double n_lags,
                    double min_llr_ratio, bool any_loudness = false) const {
    const double ratio = onset.timed.amplitude / neighbour.timed.amplitude;
    // within the neighbour's sound what is learned as noise is what rings, for which there is the residual_variance
    const bool is_isolated = onset.timed.t_s - neighbour.timed.t_s > wave_s_;
    const double noise = is_isolated ? onset.timed.noise : 1.0;
    const bool as_loud = ratio > 1.0 / kLargestAmplitudeRatio && ratio < kLargestAmplitudeRatio;
    return (as_loud || any_loudness) && onset.timed.log_likelihood_ratio > threshold(n_lags) * noise &&
           onset.timed.log_likelihood_ratio > min_llr_ratio * onset.timed.residual_variance;
  }

  /// The most that is found between the last impact and t_s, where there is none; 0 where there is no room.
  double log_likelihood_ratio_before(double t_s, double least_room_s) {
    constexpr double kUnambiguousLogOdds = 0.4;  // of the time from the last impact
    const double last_s = onsets_.back().timed.t_s;
    const double half_s = 0.5 * (1.0 - kUnambiguousLogOdds) * (t_s - last_s);
    return half_s > least_room_s ? search(t_s - half_s, half_s, t_s).log_likelihood_ratio : 0.0;
  }

  /// What lies beside a place and is so much clearer that the place is a side lobe of it: a single gain or loss that
  /// the search did not reach.
  std::optional<TimedImpact> sidelobe_check(const TimedImpact& found, double after_s, double until_s) {
    constexpr double kSideLobes_s = 1.5e-3;
    constexpr double kClearer = 2.0;
    if (after_s < 4.0 * kSideLobes_s) return std::nullopt;  // nearer, it is a neighbour
    const TimedImpact best = search(found.t_s, kSideLobes_s, until_s);
    if (best.log_likelihood_ratio < kClearer * found.log_likelihood_ratio) return std::nullopt;
    return best;
  }

  bool search_missing(std::int64_t impact, double after_s, double until_s, double min_llr_ratio) {
    return search_missing(impact, after_s, eps_reach() * after_s, until_s, min_llr_ratio);
  }

  bool search_missing(std::int64_t impact, double after_s, double eps_reach_s, double until_s, double min_llr_ratio) {
    const double t_s = onsets_.back().timed.t_s + after_s;
    const double reach_s = eps_reach_s + 2.0 / sound_.rate_hz;
    TimedTrackImpact onset{impact, search(t_s, reach_s, until_s), until_s, true, until_s - t_s < wave_s_};
    if (const auto louder = sidelobe_check(onset.timed, after_s, until_s)) {
      onset.timed = *louder;
      min_llr_ratio = std::max(min_llr_ratio, kLlrOfOutlier);
    }
    if (!is_supported(onset, onsets_.back(), 4.0 * reach_s * sound_.rate_hz, min_llr_ratio)) return false;
    // within the last impact's sound what sounds like the wave is mostly that
    const bool is_isolated = after_s > wave_s_;
    if (is_isolated && min_llr_ratio >= kLlrBeyondEnd &&
        onset.timed.log_likelihood_ratio < kProminence * log_likelihood_ratio_before(t_s - reach_s, reach_s))
      return false;
    if (impact == onsets_.back().impact + 1 &&
        !has_plausible_amplitude(onset.timed.amplitude, onset.timed.t_s - onsets_.back().timed.t_s))
      return false;
    keep(onset);
    return true;
  }

  ImpactTimer timer_;
  const ImpactTemplate& wave_;
  const audio::AudioSource& sound_;
  double wave_s_;
  double end_s_;
  double shortest_interval_s_;
  bool wave_is_reliable_;
  std::vector<TimedTrackImpact> onsets_;
};

}  // namespace

std::vector<TimedTrackImpact> time_track(const audio::AudioSource& sound, const ImpactTemplate& wave,
                                         const Train& train, const std::vector<Candidate>& candidates, double end_s) {
  TrackTimer timer(sound, wave, end_s);
  std::int64_t last_impact = -1;
  for (std::size_t k = 0; k < train.impacts.size(); ++k) {
    const TrainImpact& here = train.impacts[k];
    const Candidate& c = candidates[here.candidate];
    if (last_impact >= 0 && here.impact > last_impact + 1) timer.fill_gap(here.impact, c.t_s);
    double next_s = c.t_s + 1.0;
    if (k + 1 < train.impacts.size()) {
      const TrainImpact& next = train.impacts[k + 1];
      next_s = c.t_s + (candidates[next.candidate].t_s - c.t_s) / static_cast<double>(next.impact - here.impact);
    }
    timer.add(c, here.impact, next_s);
    last_impact = here.impact;
  }
  for (std::size_t k = train.impacts.size(); k-- > 0 && timer.trim_tail(candidates[train.impacts[k].candidate]);) {
  }
  timer.extend();
  return timer.take();
}

}  // namespace bouncelab::detection
