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

/// One drop: its true impact times and those detected in its sound.
struct DropResult {
  std::int64_t drop = 0;
  std::vector<synthesis::TrueImpact> truth;
  Onsets onsets;
  double sound_s = 0.0;       ///< length of the recording
  double synthesize_s = 0.0;  ///< processor time
  double detect_s = 0.0;      ///< processor time
};

/// Synthesizes the sound of one drop and detects the impacts in it. A pure function of its arguments but for the
/// recording kept.
/// @param impacts  of this drop alone
/// @param ball     names the recordings, BALL.0017.flac
DropResult run_drop(const Impacts& impacts, const std::string& ball, const DropRecording& recording);

/// All drops of a ball, in parallel, through memory.
/// @param n_threads  0: all cores
/// @param progress   in drops
/// @return ordered by drop; the same for any number of threads
std::vector<DropResult> run_drops(const Impacts& impacts, const std::string& ball, const DropRecording& recording,
                                  int n_threads, const ProgressCallback& progress = {});

/// The detected onsets of all drops, one drop after the other.
Onsets onsets_of(const std::vector<DropResult>& drops);
/// The true times as onsets, recordings named as in `onsets_of`.
Onsets true_onsets_of(const std::vector<DropResult>& drops, const std::string& ball);
/// The truth with all its columns, recordings named likewise.
Table truth_table_of(const std::vector<DropResult>& drops, const std::string& ball);

}  // namespace bouncelab::loop
