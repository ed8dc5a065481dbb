// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::synthesis {

/// Something that strikes the ground: the ball or a second object.
struct Strike {
  double t_s = 0.0;  ///< begin of contact, from the first sample of the recording
  double x_m = 0.0, y_m = 0.0;
  double duration_s = 0.0;
  double impulse_ns = 0.0;
  std::int64_t impact_index = -1;  ///< number among all impacts of the recording; -1: not the ball
  std::int64_t drop = 0, impact = 0;
  double v_mps = 0.0;
  bool shares_point = false;  ///< the whole drop strikes this point
};

/// An electric click, straight into the converter; level in units of the weakest wanted peak.
struct Click {
  double t_s = 0.0;
  double level = 0.0;
};

/// A syllable of speech, faded in and out.
struct Syllable {
  double t_s = 0.0;
  double duration_s = 0.0;
  double level = 0.0;
  std::uint64_t number = 0;  ///< in the recording: chooses the voice
};

/// What an impact does to an automatic gain, from the arrival of its sound.
struct GainPush {
  double t_s = 0.0;
  double reduction_db = 0.0;  ///< that it comes to by itself
};

/// All events of a recording, or of a part of it.
struct Schedule {
  double duration_s = 0.0;
  std::vector<Strike> strikes;      ///< by time
  std::vector<Click> clicks;        ///< by time
  std::vector<Syllable> syllables;  ///< by time
  std::vector<OtherSound> others;   ///< by time
  std::vector<GainPush> pushes;     ///< by time
};

/// A phone's automatic gain, 10^(-G / 20), as a function of time:
///
///   G(t) = max_k D_k a(t - t_k),   a(u) = sin^2(pi u / 2 ms) up to 1 ms, then exp(-(u - 1 ms) / 0.3 s)
///
/// D_k is config.gain_control_db times the peak of impact k over that of the strongest. The maximum, not a sum, so that
/// G is at most D of the strongest.
constexpr double kGainRise_s = 1e-3, kGainDecay_s = 0.3, kGainMemory_s = 40.0 * kGainDecay_s;

/// Appends the pushes of a group; one that an earlier one hides at all times is left out.
void add_pushes(const SynthesisConfig& config, const std::vector<TrueImpact>& scaled, Schedule& schedule);
/// Frames first ... first + samples.size() - 1 under the gain.
template <class T>
void apply_gain(const std::vector<GainPush>& pushes, std::int64_t first, double rate_hz, std::span<T> samples);

/// Removes strikes and clicks that begin before a time and syllables and pushes that end before it.
void forget(Schedule& schedule, double before_s);

/// Lays the groups of drops one after the other: lead-in, release, impacts, pause, release ... Within a group each ball
/// is released 0.05 to 0.5 s after the one before. Everything else that sounds is laid into the window of a group, from
/// the end of the one before to the end of its pause.
class Scheduler {
 public:
  /// @param weakest_impulse_ns  of all impacts: knocks are about as strong
  Scheduler(const SynthesisConfig& config, double weakest_impulse_ns);
  /// The balls' strikes of the next group, by time. @throws InvalidArgument where an impact has no forward impulse
  std::vector<Strike> place_balls(const Impacts& group);
  /// Appends the next group, unless the recording is one without the ball, with everything else that sounds in its
  /// window.
  void add_group(const Impacts& group, Schedule& schedule);
  /// End of the last group's pause.
  double duration_s() const { return window_end_s_; }

 private:
  void add_knock(double t_s, Random& random, Schedule& schedule) const;
  void add_knocks(std::size_t first_strike, Schedule& schedule);
  void add_clicks(Schedule& schedule);
  void add_speech(Schedule& schedule);

  const SynthesisConfig& config_;
  double weakest_impulse_ns_;
  double window_end_s_ = 0.0;
  std::int64_t n_impacts_ = 0;
  std::uint64_t n_syllables_ = 0;
  Random knocks_, clicks_, speech_;
  double next_knock_s_, next_click_s_, next_syllable_s_;  // infinite: none
};

/// m (v + v_after) of an impact. @throws InvalidArgument where it is not forward
double impulse_ns(const SynthesisConfig& config, const Impact& impact);

}  // namespace bouncelab::synthesis
