// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/calibration.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "bouncelab/loop/memory_calibration.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/synthesis/synthesize.hpp"

namespace bouncelab::loop {

// Results of single items of a run as one line of text for a RunJournal, and back: bit by bit the same, for the same
// version of the program. Drops of a loop and points of a sweep: drops.hpp, sweep.hpp.
// All that read throw InvalidArgument where the text is no such line.

/// @param with_details  also the learned wave and the spectrum of the noise, ten thousand numbers or so
std::string to_record(const detection::Detection& found, bool with_details);
/// @param recording  as the onsets name it
detection::Detection detection_from_record(std::string_view record, const std::string& recording);

std::string to_record(const sim::DropResult& drop);
sim::DropResult simulated_drop_from_record(std::string_view record);

/// A file of synthesis::synthesize_each_drop: truth, and what was counted of it.
std::string to_record(const synthesis::DropTruth& truth, const synthesis::SynthesisResult& of_file);
struct SynthesizedFile {
  synthesis::DropTruth truth;
  synthesis::SynthesisResult of_file;
};
SynthesizedFile synthesized_file_from_record(std::string_view record, const std::filesystem::path& recording);

/// What a seed of the fit's calibration gave; empty where the fit failed.
std::string to_record(const std::vector<fit::Estimate>& estimates);
std::vector<fit::Estimate> estimates_from_record(std::string_view record);

std::string to_record(const fit::Replicate& replicate);
fit::Replicate replicate_from_record(std::string_view record);

/// Without the conditions, which its number gives.
std::string to_record(const MemoryExperiment& experiment);
MemoryExperiment memory_experiment_from_record(std::string_view record, const MemoryConditions& conditions);

}  // namespace bouncelab::loop
