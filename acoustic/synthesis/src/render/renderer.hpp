// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "render/strike_ringing.hpp"
#include "render/strike_sound.hpp"
#include "scene/background.hpp"
#include "scene/schedule.hpp"

namespace bouncelab::synthesis {

/// The samples of a recording, segment by segment, from its schedule. A segment depends on its number only: it may be
/// rendered on any thread, and only the events that sound in it need be in the schedule.
class Renderer {
 public:
  /// @param known  the waves of the schedule's strikes, as StrikeSound::truth gives them. All must outlive this.
  Renderer(const SynthesisConfig& config, const StrikeSound& sound, const Schedule& schedule, const Levels& levels,
           const std::vector<ContactWave>& known);

  std::int64_t segment_frames() const { return segment_frames_; }
  /// How far before and after a segment strikes contribute to it.
  double reach_back_s() const { return reach_back_s_; }
  double reach_ahead_s() const { return reach_ahead_s_; }
  /// Frames first ... first + n - 1, interleaved by channel, clipped to full scale. @param first  a multiple of
  /// segment_frames(), n at most so many
  std::vector<double> frames(std::int64_t first, std::int64_t n) const;
  /// Appends the same frames as they would be read back from a file of the configuration's encoding.
  void append_read_back(std::int64_t first, std::int64_t n, std::vector<float>& out) const;

 private:
  /// The noise, of which silence_ is 80 dB below, is 40 dB above what single precision rounds off amplitudes of 1.
  bool is_single() const;
  StrikeRinging ringing(std::size_t channel, std::int64_t first, std::int64_t n) const;
  /// All strikes' sound with the reverberation tail, begun so early that its start has decayed.
  template <class T>
  std::vector<double> reverberant_sound(std::size_t channel, std::int64_t first, std::int64_t n) const;
  /// Calls use(at, part): frames first + at ... of one channel, of type float where that is enough.
  template <class Use>
  void for_each_part(std::size_t channel, std::int64_t first, std::int64_t n, const Use& use) const;
  template <class T, class Use>
  void parts_of(std::size_t channel, std::int64_t first, std::int64_t n, const Use& use) const;
  /// The strike and its echoes, those that begin before frame `end`.
  void add_contacts(std::size_t channel, std::size_t strike, std::int64_t end, StrikeRinging& ringing) const;

  const SynthesisConfig& config_;
  const StrikeSound& sound_;
  const Schedule& schedule_;
  Levels levels_;
  const std::vector<ContactWave>& known_;
  Background background_;
  std::int64_t segment_frames_;
  double reach_back_s_, reach_ahead_s_;
  double silence_;
};

}  // namespace bouncelab::synthesis
