// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "autoregression.hpp"
#include "bouncelab/acoustic/sound.hpp"
#include "wave_template.hpp"

namespace bouncelab {

/// An impact whose time is known to a millisecond or better.
struct RoughImpact {
  double t_s = 0.0;
  double amplitude = 0.0;  ///< any unit, the same for all
  double reach_s = 1e-3;   ///< how far from t_s it may lie
};

/// An impact timed by maximum likelihood.
struct TimedImpact {
  double t_s = 0.0;
  double sigma_s = 0.0;
  double amplitude = 0.0;    ///< in units of the wave
  double gain = 0.0;         ///< log likelihood ratio against no impact there
  double misfit = 0.0;       ///< mean square residual, noise = 1
  double correlation = 0.0;  ///< of the sound with the wave, 0 ... 1
  bool ambiguous = false;    ///< another time, a cycle off, is almost as likely; sigma_s says how far
};

/// The sound of an impact, whitened by the noise, as learned from the recording.
struct ImpactWave {
  std::vector<float> whitener;  ///< filter that makes the noise white with variance 1
  WaveTemplate wave;
  double contact_index = 0.0;  ///< start of contact, in samples from the template's first
  double correlation = 0.0;    ///< median of the learned impacts with the template
  std::int64_t n_impacts = 0;  ///< learned from
  std::vector<double> heard;   ///< the mean wave as recorded, not whitened
  std::vector<double> spread;  ///< its standard deviation from impact to impact
  double peak = 0.0;           ///< of `heard`
};

/// Learns the wave from the recording's own strong and isolated impacts: aligned below a sample, averaged, again.
/// Absent where no three impacts sound alike.
std::optional<ImpactWave> learn_impact_wave(const Sound& sound, const Autoregression& noise,
                                            const std::vector<RoughImpact>& impacts);

/// Times impacts one after the other, what still rings of the earlier ones subtracted.
class ImpactTimer {
 public:
  /// @param sound, wave  kept by reference
  ImpactTimer(const Sound& sound, const ImpactWave& wave) : sound_(sound), wave_(wave) {}

  /// The most likely impact within reach_s of t_s. Does not remember it.
  /// @param until_s  sound from here on belongs to the next impact
  TimedImpact time(double t_s, double reach_s, double until_s) const;
  /// From now on its ringing is subtracted. Impacts come in time order.
  void remember(const TimedImpact& impact);

 private:
  const Sound& sound_;
  const ImpactWave& wave_;
  std::vector<TimedImpact> heard_;
};

}  // namespace bouncelab
