// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "bouncelab/synthesis/synthesize.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "excitation/point_response.hpp"
#include "excitation/resonator_bank.hpp"
#include "scene/background.hpp"
#include "scene/schedule.hpp"
#include "sensor/instrument.hpp"

namespace bouncelab::synthesis {

/// Sound of a strike in each channel, before gain and noise, and its true values.
class StrikeSound {
 public:
  /// The configuration must outlive this.
  StrikeSound(const SynthesisConfig& config, std::shared_ptr<const Instrument> instrument);

  const Instrument& instrument() const { return *instrument_; }
  Contact contact(std::size_t channel, const Strike& strike) const;
  /// What strikes make sound like in a channel, from the place of this one.
  using Wave = std::function<ContactWave(const Contact& contact, bool with_slopes)>;
  Wave wave_at(std::size_t channel, const Strike& strike) const;
  /// Longest time from a strike to the begin of its last echo in any channel, plus a contact.
  double largest_delay_s() const;

  /// Clean peaks of strikes at gain 1 in the measured channel.
  std::vector<double> peaks(std::span<const Strike> strikes) const;
  /// True values of the ball's strikes among these, for gain 1 and noise of rms 1.
  /// @param waves  if not null: of each strike in the measured channel, without slopes; empty of those that are not the
  ///               ball's
  std::vector<TrueImpact> truth(std::span<const Strike> strikes, std::vector<ContactWave>* waves = nullptr) const;
  /// The first channel that is not dead, in which all is measured.
  std::size_t measured_channel() const { return measured_channel_; }

 private:
  PoleValues amplitudes(std::size_t channel, const Strike& strike) const;
  std::shared_ptr<const PointResponse> response(std::size_t channel, const Strike& strike) const;
  TrueImpact true_impact(const Strike& strike, const ContactWave& wave) const;
  bool has_room() const { return !config_.sensor.echoes.empty() || instrument_->tail().is_audible(); }
  /// WaveMeasure::slope_energy of a strike with its echoes and the tail. @param direct  with slopes
  double slope_energy_in_room(const Strike& strike, const ContactWave& direct) const;

  struct Place {
    std::size_t channel;
    double x_m, y_m;
    bool operator==(const Place&) const = default;
  };

  const SynthesisConfig& config_;
  std::shared_ptr<const Instrument> instrument_;
  std::size_t measured_channel_;
  Whitening whitening_;
  // of points that many strikes share; safe from any thread
  mutable std::mutex mutex_;
  mutable std::vector<std::pair<Place, std::shared_ptr<const PointResponse>>> responses_;
};

/// From gain 1 and noise of rms 1 to these levels.
void scale_to(const Levels& levels, std::vector<TrueImpact>& truth);

/// The levels that put the strongest impact at config.peak and the noise config.snr_db below the weakest.
Levels levels_for(const SynthesisConfig& config, double weakest_peak, double strongest_peak);

/// Throw InvalidArgument naming the first value out of range.
void validate(const SynthesisConfig& config);
void validate(const Impacts& impacts, const SynthesisConfig& config);
/// The drops of a source in groups that sound together: each is asked for as one, of several drops.
DropSource in_groups(const DropSource& drops, int n_together);
/// @param duration_s  of a contact; the rate bounds how finely it can be followed
void check_contact(double duration_s, const SynthesisConfig& config);

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

 private:
  friend class PartsOfChannel;

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
