// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "command.hpp"
#include "run_journal.hpp"

namespace bouncelab::cli {

/// How drops become sound: one recording each, all with the same gain and noise.
struct SoundStage {
  synthesis::SynthesisConfig config;
  synthesis::Levels levels;
  std::shared_ptr<const synthesis::Instrument> instrument;
  std::filesystem::path folder;  ///< recordings are kept here, FLAC, where keep_sound; replaced
  bool keep_sound = false;
};

/// Gain and noise are chosen for the first drops (up to 40): the weakest impact of so many has the SNR asked for.
/// @throws InvalidArgument where there is more than one channel
SoundStage make_sound_stage(const synthesis::SynthesisConfig& config, const Impacts& impacts);

/// One drop, heard.
struct HeardDrop {
  std::int64_t drop = 0;
  std::vector<synthesis::TrueImpact> truth;
  Onsets onsets;
  double sound_s = 0.0;       ///< length of the recording
  double synthesize_s = 0.0;  ///< processor time
  double detect_s = 0.0;      ///< likewise
};

/// A drop for the journal, and back: bit by bit the same. @throws FileError where the line is not of this form
Json to_json(const std::string& ball, const HeardDrop& heard);
HeardDrop heard_drop_from_json(const Json& json);

/// Sound of one drop and what is heard in it. A pure function of its arguments but for the sound kept.
/// @param impacts  of this drop alone
/// @param ball     names the recordings, BALL.0017.flac
HeardDrop hear_drop(const Impacts& impacts, const std::string& ball, const SoundStage& stage);

/// All drops of a ball, in parallel, through memory; those that `heard` has already are not done again.
/// @param journal  where each drop is noted when it is finished; null: nowhere
/// @return ordered by drop, for any number of threads
std::vector<HeardDrop> hear_drops(const Impacts& impacts, const std::string& ball, const SoundStage& stage,
                                  std::vector<HeardDrop> heard, RunJournal* journal, const Run& run);

/// The parts of all drops one after the other.
Onsets onsets_of(const std::vector<HeardDrop>& drops);
/// The truth as onsets, recordings named as in `onsets_of`.
Onsets true_onsets_of(const std::vector<HeardDrop>& drops, const std::string& ball);
/// The truth with all it has to say.
Table truth_table_of(const std::vector<HeardDrop>& drops, const std::string& ball);

}  // namespace bouncelab::cli
