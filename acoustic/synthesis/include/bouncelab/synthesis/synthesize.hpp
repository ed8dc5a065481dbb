// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::synthesis {

/// Gives the impacts of the k-th drop of its table, k = 0, 1, 2 ...; false after the last one. A synthesis asks
/// for them in order, twice, from k = 0 on each time: first for loudness and length, then for the sound. So hours of
/// impacts need not be in memory.
using DropSource = std::function<bool(std::int64_t k, Impacts& drop)>;
/// The drops of impacts in memory, which must outlive the source.
DropSource drops_of(const Impacts& impacts);

/// True values of one drop, or of those that sound together, in a recording.
struct DropTruth {
  std::filesystem::path recording;
  std::vector<TrueImpact> impacts;  ///< by time
  std::vector<OtherSound> others;   ///< by time; until the next release after the pause
};
/// Receives the truth drop by drop, in order.
using TruthSink = std::function<void(const DropTruth&)>;

struct SynthesisResult {
  std::int64_t n_impacts = 0;
  std::int64_t n_clipped = 0;       ///< impacts beyond full scale
  std::int64_t n_other_sounds = 0;  ///< of things that are not the ball
  std::int64_t n_files = 1;
  Levels levels;
  double duration_s = 0.0;  ///< of all files
  int n_modes = 0;          ///< of ground, below half the sample rate and max_mode_hz
  std::vector<Note> notes;  ///< modes that the rate cannot hold, clipped impacts
};
Description members_of(const SynthesisResult*);

/// Impact times to sound: renders the recording to a file, in constant memory for any length and number of drops.
///
/// Each impact is a Hertz pulse of impulse m (v + v_after) at its exact time. It excites the modes of the ground; the
/// sensor's response to them is band-limited by the converter's anti-alias filter.
/// @param progress  in seconds of sound; 0 of 0 during the first passage
/// @throws as SyntheticRecording and AudioWriter do
SynthesisResult synthesize(const DropSource& drops, const SynthesisConfig& config, const std::filesystem::path& out,
                           bool may_replace, const TruthSink& truth = {}, const ProgressCallback& progress = {});

/// One file for each drop, named by path_of_drop and configured by config_of_drop: gain and noise are those of
/// all drops in one recording; the noise of each file is its own.
/// @throws InvalidArgument where drops are to sound together
/// @param progress  in impacts
SynthesisResult synthesize_each_drop(const DropSource& drops, const SynthesisConfig& config,
                                     const std::filesystem::path& out, bool may_replace, const TruthSink& truth,
                                     const ProgressCallback& progress = {});

}  // namespace bouncelab::synthesis
