// SPDX-License-Identifier: GPL-3.0-or-later
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/stages.hpp"

namespace bouncelab::stages {

std::vector<Section> sections_of(DemOptions& options) {
  using O = DemOptions;
  static constexpr Member own[]{
      member<&O::code>("code", "For which code").one_of("liggghts,lammps,yade,mercurydpm,c++,python,formulas"),
      member<&O::model>("model", "Of the contact; default: constant eps, fluctuating for c++, python and formulas")
          .one_of("constant,viscoelastic,fluctuating,memory"),
      member<&O::youngs_modulus_pa>("youngs_modulus",
                                    "Young's modulus of the simulated balls and plate, softer than the measured ones "
                                    "so that steps may be longer; eps stays what it is, the damping is adapted "
                                    "(default: as stiff as the measured ball) [Pa]")
          .within(1e3, 1e13)};
  return {{"", own, &options}};
}

namespace {

/// Which codes have a model at all.
const char* codes_with(const std::string& model) {
  if (model == "fluctuating") return "c++, python and formulas";
  if (model == "memory") return "c++";
  if (model == "viscoelastic") return "liggghts, lammps and yade";
  return "liggghts, lammps, yade and mercurydpm";
}

/// What the fit warned of.
std::vector<Note> warnings_of(const nlohmann::json& fit, const std::string& file) {
  std::vector<Note> notes;
  for (const auto& note : fit.value("notes", nlohmann::json::array()))
    if (note.is_object() && note.value("severity", "") == to_string(Severity::warning))
      notes.push_back({NoteKind::of_file, {}, note.value("text", ""), file});
  return notes;
}

}  // namespace

Outcome dem_of(const std::string& content, const DemOptions& options) {
  const auto json = nlohmann::json::parse(content, nullptr, false);
  if (!is_fit(content))
    throw FileError(options.fit, "it is no fit.json of this version; make it anew: bouncelab fit samples.csv");
  if (!json.value("is_one_ball", true))
    throw FileError(
        options.fit,
        "its recordings or drops do not agree, one ε for all would belong to no ball: fit each alone, or all "
        "with --pool");
  std::optional<fit::DemExport> dem;
  try {
    dem = report::dem_of_fit(content, options.youngs_modulus_pa);
  } catch (const InvalidArgument& error) {
    throw FileError(options.fit, error.what());
  }
  if (!dem)
    throw FileError(options.fit, "it has nothing for these codes: no law was fitted, or its ε is not between 0 and 1");
  Outcome outcome;
  outcome.notes = warnings_of(json, options.fit);
  std::string has;
  for (const fit::Snippet& snippet : dem->snippets) {
    if (lower_case(snippet.program) != options.code) continue;
    has += (has.empty() ? "it has " : ", ") + snippet.model;
    if (!(options.model.empty() || snippet.model == options.model)) continue;
    outcome.text = snippet.text;
    outcome.result = {{"program", snippet.program}, {"model", snippet.model}, {"text", snippet.text}};
    return outcome;
  }
  std::string why = has;
  const auto add = [&](const std::string& reason) { why += (why.empty() ? "" : "; ") + reason; };
  for (const fit::MissingModel& missing : dem->missing)
    if (lower_case(missing.program) == options.code && (options.model.empty() || missing.model == options.model))
      add(missing.reason);
  if (why == has) add(std::string("that is a model for ") + codes_with(options.model));
  outcome.error = options.fit + ": nothing " + options.model + (options.model.empty() ? "" : " ") + "for " +
                  options.code + ": " + why;
  outcome.exit_code = kNotUsable;
  return outcome;
}

Outcome run_dem(const DemOptions& options, const Run&) { return dem_of(whole_content(options.fit), options); }

}  // namespace bouncelab::stages
