// SPDX-License-Identifier: GPL-3.0-or-later
/// Results of the stages as JSON text, as --json prints them.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/calibration.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/loop/memory_calibration.hpp"
#include "bouncelab/loop/scatter_theory.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/synthesis/synthesize.hpp"

namespace bouncelab::cli {

/// @param ball, plate  as they were understood
std::string simulate_json(const sim::SimulationResult& result, const Ball& ball);
std::string synthesize_json(const synthesis::SynthesisResult& result, const Ball& ball, const Material& plate);
/// What is kept of each of thousands of recordings; its onsets are in the table.
struct RecordingResult {
  std::string recording;  ///< as it was given
  detection::DetectionStatus status = detection::DetectionStatus::silent;
  std::string message;
  detection::RecordingSummary summary;
  std::vector<detection::DropSummary> drops;
  std::vector<std::string> warnings;
  std::size_t n_onsets = 0;
};

/// @param warnings  that are not of one recording alone
std::string detect_json(const std::vector<RecordingResult>& recordings, const std::vector<std::string>& warnings);
std::string convert_json(std::size_t n_onsets, std::size_t n_by_hand);
std::string restitution_json(const fit::RestitutionCounts& counts, const std::optional<Ball>& ball,
                             const std::optional<Material>& plate);
std::string calibrate_json(const fit::CalibrationResult& result);
/// Of `calibrate --memory`: the groups of experiments with their rows.
std::string memory_calibration_json(const std::vector<loop::MemoryCalibrationGroup>& groups);
std::string report_json(const std::string& report);

/// summary.json of `analyze`.
struct AnalyzeSummary {
  const fit::RestitutionCounts& counts;
  const std::vector<RecordingResult>& recordings;
  const std::vector<std::pair<std::string, double>>& seconds;  ///< by stage
  const std::vector<std::string>& warnings;
};
std::string analyze_json(const AnalyzeSummary& summary);

/// `theory` of a loop's summary.json (docs/formats.md).
nlohmann::ordered_json scatter_json(const loop::ScatterTheory& theory);

}  // namespace bouncelab::cli
