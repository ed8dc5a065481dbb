// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/validate/cases.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/stages.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

/// "snr-db_0", and "all_else" for the one that is like the first value of each list.
std::string name_of(const loop::Settings& settings) {
  std::string name = settings.empty() ? "all_else" : "";
  for (const auto& [option, value] : settings) name += (name.empty() ? "" : "_") + option + "_" + value;
  std::replace_if(
      name.begin(), name.end(),
      [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-'; }, '_');
  return name;
}

/// What all recordings have that are not varied: the first value of each list.
loop::Settings first_values(const std::vector<loop::SweepAxis>& lists) {
  loop::Settings settings;
  for (const loop::SweepAxis& list : lists) settings.emplace_back(list.option, list.values.front());
  return settings;
}

/// Does it change the impacts? Options of the simulation, the ball, and the seed do.
bool changes_impacts(const loop::Settings& settings) {
  Scene scene;
  const std::vector<Section> sections = scene_sections(scene, true);
  return std::any_of(settings.begin(), settings.end(), [&](const auto& setting) {
    const std::optional<Option> option = option_named(sections, setting.first);
    return !option || std::ranges::count(option->section->stages, "simulate") > 0;
  });
}

/// The scene and the seed that make a recording.
std::pair<Scene, CommonOptions> with_settings(const ValidateOptions& options, const Run& run,
                                              const loop::Settings& first, const loop::Settings& settings) {
  std::pair<Scene, CommonOptions> changed{options.scene, run.common};
  auto& [scene, common] = changed;
  set_scene(scene, common, first);
  set_scene(scene, common, settings);
  scene.simulate.world = scene.synthesize.world = scene.world;
  return changed;
}

/// The files of a folder that are sound, by their names.
std::vector<fs::path> sounds_of(const std::vector<std::string>& recordings) {
  constexpr std::array kEndings{".wav", ".flac", ".ogg", ".mp3",  ".m4a", ".opus", ".aif", ".aiff",
                                ".au",  ".w64",  ".caf", ".webm", ".mp4", ".mkv",  ".mov", ".rf64"};
  std::vector<fs::path> sounds;
  for (const fs::path path : recordings) {
    if (!fs::is_directory(path)) {
      sounds.push_back(path);
      continue;
    }
    const auto first = static_cast<std::ptrdiff_t>(sounds.size());
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
      const fs::path& file = entry.path();
      if (!entry.is_regular_file() || file.filename().string().starts_with('.')) continue;
      const std::string ending = lower_case(file.extension().string());
      if (std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end()) sounds.push_back(file);
    }
    std::sort(sounds.begin() + first, sounds.end());
  }
  if (sounds.empty()) throw InvalidArgument("--recordings: there is no recording in " + printable(recordings.front()));
  return sounds;
}

/// NAME.truth.csv, else the one NAME.csv, NAME.txt ... that there is.
fs::path truth_of(const fs::path& sound, const fs::path& folder) {
  constexpr std::array kEndings{".csv", ".txt", ".tsv", ".TextGrid", ".svl", ".lab", ".labels"};
  if (!fs::is_directory(folder)) return folder;
  const std::string stem = sound.stem().string();
  if (fs::path ours = folder / (stem + ".truth.csv"); is_unnamed_file(ours)) return ours;
  std::vector<fs::path> found;
  for (const char* ending : kEndings)
    if (fs::path file = folder / (stem + ending); is_unnamed_file(file)) found.push_back(file);
  if (found.size() == 1) return found.front();
  if (found.empty())
    throw FileError((folder / stem).string() + ".truth.csv",
                    "no such file, nor marks of that name (.txt, .TextGrid, .svl ...): where are the true times of " +
                        printable(sound.string()) + "?");
  throw FileError(found[0].string(), "and " + printable(found[1].string()) +
                                         " may both be the truth; call the right one " + printable(stem) +
                                         ".truth.csv");
}

}  // namespace

std::vector<Case> cases_of(const ValidateOptions& options, const Run& run, const fs::path& folder) {
  const loop::Settings first = first_values(run.sweep);
  std::vector<loop::Settings> all{{}};
  for (const loop::SweepAxis& list : run.sweep)
    for (std::size_t k = 1; k < list.values.size(); ++k) all.push_back({{list.option, list.values[k]}});
  std::vector<Case> cases;
  for (const loop::Settings& settings : all) {
    const std::string name = name_of(settings);
    cases.push_back({name, folder / (name + ".wav"), folder / (name + ".truth.csv"), settings});
    try {  // what is wrong with any is said before the work
      const auto [scene, common] = with_settings(options, run, first, settings);
      simulation_config(scene.simulate, common.seed, run.common.n_threads);
      synthesis_config(scene.synthesize, common.seed, run.common.n_threads);
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("recording " + name + ": " + error.what());
    }
  }
  return cases;
}

void make_sound(const ValidateOptions& options, const std::vector<Case>& cases, const fs::path& folder,
                const Run& run) {
  const loop::Settings first_settings = first_values(run.sweep);
  const ProgressCallback progress = progress_line(run, "synthesize", "recordings");
  for (std::size_t k = 0; k < cases.size(); ++k) {
    progress(static_cast<double>(k), static_cast<double>(cases.size()));
    const Case& c = cases[k];
    auto [scene, common] = with_settings(options, run, first_settings, c.settings);
    Run quiet = run;
    quiet.common = common;
    quiet.common.quiet = true;
    for (const loop::Settings& settings : {first_settings, c.settings})
      for (const auto& [name, value] : settings)
        for (Parameter& parameter : quiet.parameters)
          if (parameter.name == name) parameter.values = {value};
    const bool is_own = k == 0 || changes_impacts(c.settings);
    scene.simulate.out = scene.synthesize.impacts = folder / ((is_own ? c : cases.front()).name + ".impacts.csv");
    if (is_own) run_simulate(scene.simulate, quiet);
    scene.synthesize.out = c.sound;
    scene.synthesize.truth = c.truth;
    run_synthesize(scene.synthesize, quiet);
  }
}

std::vector<Case> given_cases(const ValidateOptions& options) {
  if (options.truth.empty()) throw InvalidArgument("--recordings: name the folder of their true times with --truth");
  std::vector<Case> cases;
  std::map<std::string, int> n_called;
  for (const fs::path& sound : sounds_of(options.recordings)) {
    const std::string stem = sound.stem().string();
    const int n = ++n_called[stem];
    cases.push_back({n > 1 ? stem + " (" + std::to_string(n) + ")" : stem, sound, truth_of(sound, options.truth), {}});
  }
  if (cases.size() > 1 && !fs::is_directory(options.truth))
    throw InvalidArgument("--truth " + printable(options.truth) +
                          " is one file, of one recording; give the folder in which each recording has its own");
  return cases;
}

}  // namespace bouncelab::stages
