// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"

namespace bouncelab::detection {

/// Low-pass filter and decimation without delay: sample k lies at the time of sample k * factor of the source. A
/// Hann-windowed sinc of 16 factor + 1 taps: -6 dB at 0.8 of the new Nyquist frequency, below -40 dB above it. Sounds
/// of soft balls end below 1.5 kHz and are detected better without the noise above.
/// @param factor  >= 1
audio::AudioSource decimate(const audio::AudioSource& source, int factor);

/// Prediction error filter of an autoregressive model: u[n] = sum_k filter[k] x[n-k], filter[0] = 1. Free ringing and
/// hum are predicted from the past and vanish from u; what an impact adds does not.
struct ArModel {
  std::vector<float> filter;
  double quiet_variance = 0.0;  ///< of u in the quiet tenth of the recording; 0 only in digital silence
};

/// Autoregressive models of a recording.
struct ArModels {
  ArModel signal;  ///< of noise and ringing together
  ArModel noise;   ///< of the quietest tenth of the recording
};

/// Learned from frames of 10 ms over all of the recording (at most 2^18.6 samples of it, evenly spread), each weighted
/// by the inverse of its energy, so that noise and ringing have equal weight whatever their level; the noise model from
/// the quietest tenth of them. Levinson's recursion on the Hann-windowed autocorrelation of the differenced signal.
/// @param order  of the model, before the difference; >= 1
/// Source: Makhoul, Proc. IEEE 63, 561 (1975), doi:10.1109/PROC.1975.9792.
ArModels learn_ar_models(const audio::AudioSource& source, int order);

/// Prediction error filter for a given autocorrelation, filter[0] = 1, by Levinson's recursion.
std::vector<double> prediction_error_filter(const std::vector<double>& autocorrelation);

/// Innovations of samples first ... first + out.size() - 1 (samples before the recording are 0).
void read_innovations(const audio::AudioSource& source, const ArModel& model, std::int64_t first, std::span<float> out);
/// The same of sound in memory, which begins model.filter.size() - 1 samples before the first innovation.
void innovations_of(std::span<const float> sound, const ArModel& model, std::span<float> out);

/// One-sided power spectral density of the quiet parts, 2 variance / (rate |sum_k filter[k] exp(-2 pi i f k /
/// rate)|^2).
double quiet_psd(const ArModel& model, double rate_hz, double frequency_hz);

/// A recording whitened as by read_innovations(), the same bytes. Keeps what it has read last, and as much around it:
/// an impact is sought in windows that overlap.
class WhiteSound {
 public:
  /// @param source  kept by reference
  explicit WhiteSound(const audio::AudioSource& source) : source_(source) {}
  const audio::AudioSource& source() const { return source_; }
  void read(const std::vector<float>& whitener, std::int64_t first, std::span<float> out);

 private:
  const audio::AudioSource& source_;
  ArModel model_;  ///< that what is held was whitened by
  std::int64_t first_ = 0;
  std::vector<float> held_;
};

}  // namespace bouncelab::detection
