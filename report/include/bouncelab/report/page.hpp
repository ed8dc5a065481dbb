// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/dem_export.hpp"

namespace bouncelab::report {

/// What the report shows. All texts are JSON as the commands leave them in files; an empty text is left out of the
/// report. Pictures and tables show numbers of these files.
struct ReportInput {
  std::string title;
  std::string summary_json;            ///< summary.json of `loop` or `analyze`
  std::string fit_json;                ///< fit.json
  std::string wave_json;               ///< wave.json: the recording's envelope and excerpts with the impacts found
  std::string paper_json;              ///< paper.json of `loop --preset paper`
  std::string fit_simulation_json;     ///< its fit_from_simulation.json
  std::string sweep_json;              ///< sweep.json
  std::string diagnostics_json;        ///< diagnostics.json of `analyze --diagnostics`
  std::string comparison_json;         ///< comparison.json of `compare`
  std::string comparison_points_json;  ///< report::points_json
  std::string validation_json;         ///< of `validate`, with the worst recordings' sound
  std::string samples_json;            ///< {v_mps: [], eps: [], sigma_eps: []}; few samples are shown one by one
};

/// Speeds, coefficients of restitution and their standard errors, for ReportInput::samples_json, at the plate: without
/// the drag and contact time that the fit found. Empty where they are more than would be shown one by one (fit.json has
/// their density).
std::string samples_json(RestitutionSamples samples, const std::string& fit_json);

/// Inputs of discrete-element codes by the numbers of a fit.json; absent where it has nothing for them.
/// @param youngs_modulus_pa  of the simulated balls; absent: as stiff as the measured one
/// @throws InvalidArgument where a number is missing or wrong
std::optional<fit::DemExport> dem_of_fit(const std::string& fit_json, std::optional<double> youngs_modulus_pa = {});

/// One HTML file that carries everything it needs (pictures are drawn by the plotting library inside it; no network).
/// @throws InvalidArgument where a text is not JSON
std::string render(const ReportInput& input);

}  // namespace bouncelab::report
