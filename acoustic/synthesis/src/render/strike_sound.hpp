// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "excitation/point_response.hpp"
#include "scene/noise.hpp"
#include "scene/schedule.hpp"
#include "sensor/instrument.hpp"

namespace bouncelab::synthesis {

/// Sound of a strike in each channel, before gain and noise, and its true values.
class StrikeSound {
 public:
  /// The configuration must outlive this.
  StrikeSound(const SynthesisConfig& config, std::shared_ptr<const Instrument> instrument);
  ~StrikeSound();

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

  const SynthesisConfig& config_;
  std::shared_ptr<const Instrument> instrument_;
  std::size_t measured_channel_;
  Whitening whitening_;
  struct Responses;
  std::unique_ptr<Responses> responses_;  // of points that many strikes share; safe from any thread
};

/// From gain 1 and noise of rms 1 to these levels.
void scale_to(const Levels& levels, std::vector<TrueImpact>& truth);

/// The levels that put the strongest impact at config.peak and the noise config.snr_db below the weakest.
Levels levels_for(const SynthesisConfig& config, double weakest_peak, double strongest_peak);

}  // namespace bouncelab::synthesis
