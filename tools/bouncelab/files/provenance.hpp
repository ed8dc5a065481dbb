// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/fit/error_budget.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// SHA-256 of a file's content, in hexadecimal. @throws FileError
std::string sha256_of_file(const std::filesystem::path& path);

/// What was taken out of coefficients of restitution, and with which values.
struct Corrections {
  bool drag = false, contact_time = false, travel_time = false;
  double wave_speed_mps = 0.0, ball_radius_m = 0.0, ball_density_kgpm3 = 0.0, gravity_mps2 = 0.0;
};

/// Writes OUTPUT.meta.json beside an output: command line, version, commit, seed, inputs with their SHA-256, all
/// parameters as resolved, and the corrections of samples.
void write_provenance(const Run& run, const std::filesystem::path& output,
                      const std::vector<std::filesystem::path>& inputs = {},
                      const std::optional<Corrections>& corrections = {});

/// Sets in `budget` what the provenance beside the samples says of corrections. Samples without provenance count as not
/// corrected. @throws FileError where the provenance is not JSON
void apply_corrections(const std::filesystem::path& samples, fit::BudgetConfig& budget);

}  // namespace bouncelab::cli
