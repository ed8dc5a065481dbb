// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/progress.hpp"

namespace bouncelab::detection {

/// Nothing has to be set: rate, level, noise, channel, wave and trains are found in the recording itself.
struct DetectionConfig {
  std::optional<int> channel;  ///< from 0; absent = the one in which impacts are heard best
};

enum class DetectionStatus {
  ok,               ///< at least one train of impacts
  too_few_impacts,  ///< sounds, but no train of at least four impacts among them
  silent,           ///< nothing rises above the noise
  unreadable,       ///< one of several files that could not be read; the message says why
};

/// What was learned about one recording.
struct RecordingSummary {
  double rate_hz = 0.0;
  int n_channels = 0;
  int channel = 0;             ///< the one used
  std::string channel_reason;  ///< why that one, for people
  double duration_s = 0.0;
  double noise_rms = 0.0;  ///< of the quiet parts, full scale = 1
  /// tau at 1 m/s, tau = tau_1 v^(-1/5), by which the times were moved to the start of contact; absent = the sound does
  /// not tell it to four standard errors: then steel's, 35 +- 20 us, has a say
  std::optional<double> contact_time_at_1_mps_s;
  /// Standard error of the tau_1 used, d: all times share an error of d (v^(-1/5) - const) / 2, which sigma_t_s leaves
  /// out. Absent where no time was moved.
  std::optional<double> contact_time_sigma_s;
  std::int64_t n_candidates = 0;             ///< sounds that rise like impacts
  std::int64_t n_drops = 0;                  ///< trains found
  std::optional<double> restitution_median;  ///< of T_{k+1} / T_k over all trains; absent where there is none
};

/// The sound of an impact as learned from the recording (full scale = 1), from a little before the start of contact.
struct LearnedWave {
  double t0_s = 0.0;  ///< time of the first sample, relative to the start of contact
  double dt_s = 0.0;
  std::vector<double> mean;    ///< of impacts scaled to the strongest
  std::vector<double> spread;  ///< standard deviation from impact to impact
  std::int64_t n_impacts = 0;  ///< learned from
};

/// Power spectral density of the quiet parts [1/Hz], full scale = 1.
struct NoiseSpectrum {
  std::vector<double> frequency_hz;
  std::vector<double> psd;
};

struct Detection {
  Onsets onsets;
  RecordingSummary summary;
  std::optional<LearnedWave> wave;
  std::optional<NoiseSpectrum> noise;
  DetectionStatus status = DetectionStatus::silent;
  std::string message;                ///< one line: what was found, or why not
  std::vector<std::string> warnings;  ///< one line each
};

/// Impact times of bouncing balls in one recording: several drops one after the other, each a train of impacts with
/// intervals T_{k+1} = eps_k T_k, eps_k varying slowly but for single losses and gains.
///
/// 1. sounds that rise over what rings already, in the innovations of an autoregressive model of the recording;
/// 2. trains: the chains of such sounds most probable under T_{k+1} = eps_k T_k against chance;
/// 3. the time of each impact, below a sample, with a standard error.
///
/// sigma_t_s is what an interval needs: the standard error of t_s against the times of its neighbours, independent from
/// impact to impact. It leaves out what all times of a drop share, a constant (where in its wave contact begins) and
/// the error of the contact law, d (v^(-1/5) - const) / 2 with d = contact_time_sigma_s: 1 us over a drop of steel
/// balls, but some 10 ns from one impact to the next.
///
/// Reads the recording in pieces, several times; holds at most 2^24 of its samples, what rises in it (about 150 bytes a
/// sound) and the onsets. May run in several threads at once. t_s counts from the first sample.
/// @throws FileError where the file cannot be read; InvalidArgument where the channel does not exist
Detection detect(const std::filesystem::path& recording, const DetectionConfig& config = {},
                 const ProgressCallback& progress = {});

/// The same from samples in memory, full scale = 1, one channel.
/// @param rate_hz  4e3 ... 4e6 [Hz]
/// @param name     goes into the column `recording`
/// @throws InvalidArgument where the rate is out of range or a sample is not finite
Detection detect(std::span<const float> samples, double rate_hz, const std::string& name,
                 const DetectionConfig& config = {}, const ProgressCallback& progress = {});

/// Several recordings side by side, each as if it were alone: the result does not depend on the threads. One that
/// cannot be read does not keep the others from being heard: its status is `unreadable`. A single one throws.
/// @param n_threads  0 = all cores
/// @param progress   counts recordings; where there is only one, seconds of its sound
std::vector<Detection> detect(const std::vector<std::filesystem::path>& recordings, const DetectionConfig& config,
                              int n_threads, const ProgressCallback& progress = {});

}  // namespace bouncelab::detection
