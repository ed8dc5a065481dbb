// SPDX-License-Identifier: GPL-3.0-or-later
/// Sound files made byte by byte, so that bad ones can be made too.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "support/modal_sound.hpp"

namespace bouncelab::cli_test {

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

/// A mono WAV of 32-bit floats.
inline std::string float_wav(const std::vector<float>& samples, std::uint32_t rate_hz) {
  const auto size = static_cast<std::uint32_t>(4 * samples.size());
  std::string bytes = "RIFF";
  put<std::uint32_t>(bytes, 36 + size);
  bytes += "WAVEfmt ";
  put<std::uint32_t>(bytes, 16);
  put<std::uint16_t>(bytes, 3);  // IEEE float
  put<std::uint16_t>(bytes, 1);
  put<std::uint32_t>(bytes, rate_hz);
  put<std::uint32_t>(bytes, 4 * rate_hz);
  put<std::uint16_t>(bytes, 4);
  put<std::uint16_t>(bytes, 32);
  bytes += "data";
  put<std::uint32_t>(bytes, size);
  for (const float sample : samples) put(bytes, sample);
  return bytes;
}

/// Deterministic noise of a given rms: a linear congruential generator, uniform.
inline std::vector<float> noise(std::size_t n, double rms) {
  std::vector<float> samples(n);
  std::uint32_t state = 12345;
  for (float& sample : samples) {
    state = 1664525u * state + 1013904223u;
    sample = static_cast<float>(rms * std::sqrt(3.0) * (2.0 * state / 4294967296.0 - 1.0));
  }
  return samples;
}

/// Noise at 44.1 kHz with one drop of decaying 5 kHz pings, intervals shrinking by eps: an easy case for a detector.
inline std::vector<float> bouncing(std::size_t n_impacts, double eps = 0.9, double first_interval_s = 0.3) {
  constexpr double kRate = 44100.0;
  std::vector<double> times{0.25};
  double interval = first_interval_s;
  for (std::size_t k = 1; k < n_impacts; ++k, interval *= eps) times.push_back(times.back() + interval);
  std::vector<float> samples = noise(static_cast<std::size_t>((times.back() + 0.5) * kRate), 1e-4);
  const test::ModalSound ping = test::equal_modes({5000.0}, 2.5e-3, 0.03);
  double amplitude = 0.5;
  for (const double t0 : times) {
    test::add_modal_sound(samples, kRate, t0, amplitude, ping);
    amplitude *= eps;
  }
  return samples;
}

}  // namespace bouncelab::cli_test
