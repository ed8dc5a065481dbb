// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::loop {

/// How drops become sound: one recording each, all with the same gain and noise level.
struct DropRecording {
  synthesis::SynthesisConfig config;  ///< one channel; positions drawn, one for each drop
  synthesis::Levels levels;
  std::shared_ptr<const synthesis::Instrument> instrument;
  /// The recordings are kept in this folder, which must exist, as BALL.0017.flac; files there are replaced. Absent:
  /// they are not kept.
  std::optional<std::filesystem::path> folder;
};

constexpr std::int64_t kDropsForLevels = 40;
/// Gain and noise are chosen for the first drops (up to kDropsForLevels): the weakest impact of so many has the SNR of
/// the configuration.
/// @throws InvalidArgument where there is more than one channel
DropRecording drop_recording(const synthesis::SynthesisConfig& config, const Impacts& impacts);

/// One recording, of a drop or of all: its true impact times and those detected in its sound.
struct RecordingResult {
  std::string recording;  ///< its name in tables
  std::vector<synthesis::TrueImpact> truth;
  std::vector<synthesis::OtherSound> others;  ///< of one recording of all drops
  Onsets onsets;
  double sound_s = 0.0;       ///< length of the recording
  double synthesize_s = 0.0;  ///< processor time, of a recording of one drop
  double detect_s = 0.0;      ///< likewise
};

/// Synthesizes the sound of one drop and detects the impacts in it. A pure function of its arguments but for the
/// recording kept.
/// @param impacts  of this drop alone
/// @param ball     names the recordings, BALL.0017.flac
RecordingResult run_drop(const Impacts& impacts, const std::string& ball, const DropRecording& recording);

/// All drops of a ball, in parallel, through memory.
/// @param n_threads  0: all cores
/// @param progress   in drops
/// @return ordered by drop; the same for any number of threads
std::vector<RecordingResult> run_drops(const Impacts& impacts, const std::string& ball, const DropRecording& recording,
                                       int n_threads, const ProgressCallback& progress = {});

/// All drops in one file, one after the other: what they have in common is learned of all.
/// @param file      .wav or .flac; replaced where it is there
/// @param progress  of the synthesis, in seconds of sound
/// @return without times; detect_together finds them
RecordingResult synthesize_together(const Impacts& impacts, const synthesis::SynthesisConfig& config,
                                    const std::filesystem::path& file, const ProgressCallback& progress = {});
/// @param progress  in seconds of sound
void detect_together(RecordingResult& result, int n_threads, const ProgressCallback& progress = {});

/// The detected onsets, one recording after the other.
Onsets onsets_of(const std::vector<RecordingResult>& recordings);
/// The true times as onsets.
Onsets true_onsets_of(const std::vector<RecordingResult>& recordings);
/// The truth with all its columns.
Table truth_table_of(const std::vector<RecordingResult>& recordings);

}  // namespace bouncelab::loop
