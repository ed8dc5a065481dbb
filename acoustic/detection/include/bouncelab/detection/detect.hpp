// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::detection {

/// Nothing has to be set: level, noise, band, channel, template and tracks are estimated from the recording itself.
struct DetectionConfig {
  std::optional<int> channel;  ///< from 0; absent = the one whose tracks of impacts are the most probable
  std::optional<int> track;    ///< of sound, from 0, of a video for instance; absent = the one with the likeliest drops
  double gravity_mps2 = kDefaultGravity_mps2;  ///< > 0; gives the impact speeds g T / 2 for the contact-time law
  /// Of the ball's lowest point at release [m], > 0: what says how long the flight after the first impact may be.
  std::optional<double> drop_height_m;
  std::optional<double> rate_hz;  ///< of numbers (.npy, tables) that come without their sampling rate
  std::int64_t min_impacts = 3;   ///< drops of fewer are left out; no drop has fewer than three
  /// RecordingSummary::lossy_coding of samples that something else has decoded; that of a file goes before it.
  std::string lossy_coding;
};
/// The options: channel, track, rate, min_impacts.
Description members_of(const DetectionConfig*);

enum class DetectionStatus {
  ok,               ///< at least one track of impacts
  too_few_impacts,  ///< candidates, but no track of at least min_impacts among them
  silent,           ///< nothing rises above the noise
  unreadable,       ///< one of several files that could not be read; its note says why
};

/// The words of summary.json: "ok", "too_few_impacts", ...
const char* to_string(DetectionStatus status);

/// Odds above this are stated as this: no set of recordings is so large that the model could be tested beyond.
constexpr double kMostOdds = 1e6;

/// One drop.
struct DropSummary {
  double begin_s = 0.0;  ///< of its first impact
  std::int64_t n_impacts = 0;
  double odds = 0.0;  ///< that it is a ball against rhythms and other sounds, 1 ... kMostOdds

  double probability() const { return odds / (1.0 + odds); }
  bool is_doubtful() const { return odds < kDoubtfulOdds; }

  static constexpr double kDoubtfulOdds = 10.0;  ///< of drops with such odds one in eleven is none
};
Description members_of(const DropSummary*);

/// Estimates of one recording as a whole.
struct RecordingSummary {
  std::string format;  ///< container and encoding, in words; empty where samples were in memory
  std::string
      lossy_coding;    ///< "MP3", "AAC" ...: its times may be off by more than stated; empty where it loses nothing
  std::string ffmpeg;  ///< version of the ffmpeg that decoded it; empty where none did
  int n_tracks = 1;    ///< of sound in the file
  int track = 0;       ///< the one used
  int n_gaps = 0;      ///< of its time stamps, that hold no sound
  double rate_hz = 0.0;
  int n_channels = 0;
  int channel = 0;             ///< the one used
  std::string channel_reason;  ///< why that one, in words
  double duration_s = 0.0;
  double noise_rms = 0.0;  ///< of the quiet parts, full scale = 1
  /// tau_1, the contact time at 1 m/s of tau = tau_1 v^(-1/5), by which the times were moved to the start of contact;
  /// absent if tau_1 is not significant at 4 sigma; what the sound's frequencies suggest is then used
  std::optional<double> contact_time_at_1_mps_s;
  /// Standard error d of the tau_1 used: all times share an error of d (v^(-1/5) - const) / 2, which sigma_t_s
  /// excludes. Absent where no time was moved.
  std::optional<double> contact_time_sigma_s;
  std::int64_t n_candidates = 0;             ///< rises of the variance, impacts or not
  std::int64_t n_drops = 0;                  ///< tracks found
  std::optional<double> restitution_median;  ///< of T_{k+1} / T_k over all tracks; absent where there is none
};
Description members_of(const RecordingSummary*);

/// Mean sound of an impact of the recording (full scale = 1), from a little before the start of contact: the
/// matched-filter template before whitening.
struct LearnedWave {
  double t0_s = 0.0;  ///< time of the first sample, relative to the start of contact
  double dt_s = 0.0;
  std::vector<double> mean;    ///< of impacts scaled to the strongest
  std::vector<double> spread;  ///< standard deviation from impact to impact
  std::int64_t n_impacts = 0;  ///< that the template is the mean of
};
Description members_of(const LearnedWave*);

/// Power spectral density of the quiet parts [1/Hz], full scale = 1.
struct NoiseSpectrum {
  std::vector<double> frequency_hz;
  std::vector<double> psd;
};
Description members_of(const NoiseSpectrum*);

struct Detection {
  Onsets onsets;
  RecordingSummary summary;
  std::vector<DropSummary> drops;  ///< by their number
  std::optional<LearnedWave> wave;
  std::optional<NoiseSpectrum> noise;
  DetectionStatus status = DetectionStatus::silent;
  std::vector<Note> notes;  ///< what limits the times; where there are none, why
};

/// One of several recordings. Of very many the onsets, wave and noise need not be kept.
struct RecordingDetection {
  std::string recording;  ///< as it was given
  std::size_t n_onsets = 0;
  Detection found;
};
Description members_of(const RecordingDetection*);
/// The first recording in which impacts were found; nullptr where there is none.
const RecordingDetection* first_found(const std::vector<RecordingDetection>& recordings);

/// Impact times of bouncing balls in one recording: several drops one after the other, each a track of impacts with
/// intervals T_{k+1} = eps_k T_k, where eps_k varies slowly but for single losses and gains.
///
/// 1. candidates: rises of the variance in the innovations of an autoregressive model of the recording;
/// 2. tracks: the sequences of candidates that are most probable under T_{k+1} = eps_k T_k against clutter;
/// 3. the time of each impact by maximum likelihood with a template estimated from the recording, with a standard
/// error;
/// 4. the contact time, by which the times are moved to the start of contact.
///
/// sigma_t_s is the standard error of t_s relative to the times of its neighbours, independent from impact to impact:
/// that of an interval is the root of the sum of two squares. It excludes errors that all times of a drop share: a
/// constant (where in the template contact begins) and the error of the contact law, d (v^(-1/5) - const) / 2 with d =
/// contact_time_sigma_s, which is 1 us over a drop of steel balls but some 10 ns from one impact to the next: these 10
/// ns are in sigma_t_s, but for what the pulse's shape adds to d.
///
/// Reads the recording in pieces, several times; holds at most 2^24 of its samples, its candidates (about 150 bytes
/// each) and the onsets. May run in several threads at once. t_s counts from the first sample [s].
/// @throws FileError where the file cannot be read; InvalidArgument where the channel does not exist or gravity_mps2 is
///         not above 0
Detection detect(const std::filesystem::path& recording, const DetectionConfig& config = {},
                 const ProgressCallback& progress = {});

/// The same from samples in memory, full scale = 1.
/// @param rate_hz     4e3 ... 4e6 [Hz]
/// @param name        goes into the column `recording`
/// @param n_channels  interleaved in the samples
/// @throws InvalidArgument where the rate is out of range or a sample is not finite
Detection detect(std::span<const float> samples, double rate_hz, const std::string& name,
                 const DetectionConfig& config = {}, const ProgressCallback& progress = {}, int n_channels = 1);

/// Takes what was found in the k-th recording as soon as it is known: in any order, from one thread at a time.
using DetectionSink = std::function<void(std::size_t k, Detection&& found)>;

/// Several recordings in parallel, each as if it were alone: the result does not depend on the number of threads. One
/// that cannot be read has the status `unreadable` and does not affect the others; with a single recording it throws.
/// @param n_threads  0 = all cores
/// @param progress   counts recordings; where there is only one, seconds of its sound, 0 when it is being decoded
void detect_each(const std::vector<std::filesystem::path>& recordings, const DetectionConfig& config, int n_threads,
                 const DetectionSink& sink, const ProgressCallback& progress = {});
/// The same, everything in memory, in the order of the recordings.
std::vector<Detection> detect(const std::vector<std::filesystem::path>& recordings, const DetectionConfig& config,
                              int n_threads, const ProgressCallback& progress = {});

}  // namespace bouncelab::detection
