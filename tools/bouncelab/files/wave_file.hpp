// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/detection/detect.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// Writes wave.json, what the report draws of a recording: its envelope, the impacts found, excerpts around some.
void write_wave(const Run& run, const std::filesystem::path& recording, int channel, const Onsets& onsets,
                const std::filesystem::path& out);

/// A look inside: for each recording the wave learned with its spread and the noise's spectrum, and for each drop (the
/// first 30) its sound, its marks with their errors, and the intervals found against those that the fitted law expects.
/// @param samples  from the onsets of `found`
/// @param law      fitted to them; absent: nothing is expected
void write_diagnostics(const Run& run, const std::vector<std::string>& recordings,
                       const std::vector<detection::Detection>& found, const RestitutionSamples& samples,
                       const std::optional<RestitutionLaw>& law, double gravity_mps2, const std::filesystem::path& out);

}  // namespace bouncelab::cli
