// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::synthesis {

/// A smooth function h of compact support, added to samples at any place between them.
class KernelTable {
 public:
  /// @param h           zero beyond half_width
  /// @param half_width  in samples
  KernelTable(const std::function<double(double)>& h, int half_width);
  /// Adds weight h(n + offset) to samples[n], for all n; h from a table by cubic interpolation, within 1e-8 of its peak
  /// where h is band-limited to half a cycle in a sample.
  void add(double offset_samples, double weight, std::span<double> samples) const;
  /// Integral of h.
  double integral() const;
  void scale_by(double factor);

 private:
  static constexpr int kPhases = 256;  // of the table, in one sample
  const double* row(int phase) const { return table_.data() + std::ptrdiff_t{phase + 1} * n_row_; }

  int half_width_, n_row_;     // h at one phase, a sample apart
  std::vector<double> table_;  // phases -1 to kPhases + 1: what the interpolation reaches
};

/// The anti-alias filter of the analogue-to-digital converter: linear phase, no delay, in continuous time.
///
///   h(u) = 2 f_c sinc(2 f_c u) (Kaiser_beta(u / W) - pedestal),  |u| <= W = 34,  f_c = 0.45,  beta = 10.06
///
/// Passes up to 0.40 of the sample rate within 2e-5, stops everything from 0.50 by 98 dB: after it, samples hold the
/// whole wave, and a shift of the impact by a fraction of a sample is a shift of phase. u in samples; unit integral.
/// Source: Kaiser's design rule, Oppenheim & Schafer, Discrete-Time Signal Processing (3rd ed. 2010), 7.5.3.
class ConverterFilter {
 public:
  static constexpr int kHalfWidth_samples = 34;

  ConverterFilter();
  /// Adds weight h(n + offset) to samples[n], for all n, within 1e-8 of its peak.
  void add(double offset_samples, double weight, std::span<double> samples) const {
    table_.add(offset_samples, weight, samples);
  }

 private:
  KernelTable table_;
};

/// Diffuse reverberation tail of a room: a feedback delay network of eight lines, 11 to 37 ms long, mixed by an
/// orthogonal (Hadamard) matrix, each attenuated so that the whole falls by 60 dB in the time wanted. Source: Jot &
/// Chaigne, Digital delay networks for designing artificial reverberators, AES 90th Convention (1991).
class ReverberationTail {
 public:
  ReverberationTail(const Reverberation& room, double rate_hz);
  /// False if there is no tail.
  bool is_audible() const { return input_gain_ > 0.0; }
  /// After this many frames the tail has fallen by 180 dB.
  std::int64_t memory_frames() const { return memory_frames_; }
  /// Adds the tail to a sound, in place. Starts from silence.
  void add_to(std::span<double> sound) const;

 private:
  static constexpr std::size_t kLines = 8;
  std::array<std::size_t, kLines> lengths_{};
  std::array<double, kLines> losses_{};
  double input_gain_ = 0.0;
  std::int64_t memory_frames_ = 0;
};

}  // namespace bouncelab::synthesis
