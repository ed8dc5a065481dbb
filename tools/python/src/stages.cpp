// SPDX-License-Identifier: GPL-3.0-or-later

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <optional>
#include <utility>

#include "arguments.hpp"
#include "arrays.hpp"
#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/loop/analyze.hpp"
#include "bouncelab/report/notes.hpp"
#include "bouncelab/synthesis/synthesize.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/run.hpp"

namespace bouncelab::python {
namespace {

namespace fs = std::filesystem;

Impacts impacts_of(const py::dict& columns) {
  const Table table = table_of(columns, impact_columns(), "impacts");
  return read_in_memory([&] { return impacts_from_table(table, "impacts"); });
}

/// What `read` reads; where times do not increase, what is said has the remedy of Python for intervals.
template <class Read>
auto read_times(const std::string& remedy, const Read& read) {
  try {
    return read();
  } catch (const FileError& error) {
    const std::string of_command = "--as intervals";
    const std::size_t at = error.reason().find(of_command);
    if (at == std::string::npos) throw;
    throw FileError(error.path(), std::string(error.reason()).replace(at, of_command.size(), remedy));
  }
}

Onsets onsets_of(const py::dict& columns) {
  const Table table = table_of(columns, onset_columns(), "onsets");
  return read_in_memory([&] {
    DropsInTurn().check(table, "onsets");
    return read_times("numpy.cumsum([0, *intervals]) makes times of them",
                      [&] { return onsets_from_table(table, "onsets"); });
  });
}

py::dict detected(const stages::Recordings& recordings, std::vector<Note> notes) {
  Onsets onsets;
  for (const detection::RecordingDetection& r : recordings)
    onsets.insert(onsets.end(), r.found.onsets.begin(), r.found.onsets.end());
  py::dict result;
  notes = stages::joined(std::move(notes), report::notes_of(recordings, true));
  report::order(notes);
  result["summary"] = json_text(stages::summary_of(recordings, notes), 2);
  result["columns"] = columns_of(to_table(onsets));
  result["warnings"] = report::texts_of(notes, Severity::warning);
  return result;
}

py::dict dict_of(const stages::World& world) {
  py::dict result;
  for (const auto& [option, value] : world) result[option.c_str()] = value;
  return result;
}

stages::World world_of(const py::dict& said) {
  stages::World world;
  for (const auto& [option, value] : said) world[py::str(option)] = py::str(value);
  return world;
}

/// @return {columns, world, summary, warnings}
py::dict simulate(const Arguments& arguments, const py::object& progress) {
  auto [options, run] = parse<stages::SimulateOptions>(arguments);
  const sim::SimulationConfig config = stages::simulation_config(options, run.common.seed, run.common.n_threads);
  sim::SimulationResult simulated;
  Table table;
  python::run(run, progress, [&, &options = options, &run = run] {
    simulated = sim::simulate(config, stages::surface_of(options, config, run),
                              stages::progress_line(run, "simulate", "drops"));
    table = to_table(simulated.impacts);
  });
  if (simulated.impacts.rows.empty())
    throw InvalidArgument("no drop had an impact; see plate_size, min_speed and max_time");
  py::dict result;
  result["columns"] = columns_of(std::move(table));
  result["world"] = dict_of(stages::world_of(run.parameters));
  result["summary"] = json_text(stages::summary_of(simulated, config.ball), 2);
  result["warnings"] = report::texts_of(simulated.notes, Severity::warning);
  return result;
}

/// @param of_impacts  their world. @return {samples (frames x channels, float32), rate, truth, world, others}
py::dict synthesize(const py::dict& columns, const py::dict& of_impacts, const std::string& recording,
                    const Arguments& arguments, const py::object& progress) {
  const stages::World world = world_of(of_impacts);
  stages::SynthesizeOptions unnamed;
  unnamed.world = {};
  auto [options, run] = read_in_memory([&] {
    return parse(arguments, unnamed, [&](stages::SynthesizeOptions& o, const stages::Given&) {
      o = stages::in_world(world, std::move(o), "impacts");
    });
  });
  stages::keep_world(world, run.parameters);
  const synthesis::SynthesisConfig config = stages::synthesis_config(options, run.common.seed, run.common.n_threads);
  const Impacts impacts = impacts_of(columns);
  std::vector<float> samples;
  Table truth, others;
  python::run(run, progress, [&, &run = run] {
    const ProgressCallback done = stages::progress_line(run, "synthesize", "segments");
    const synthesis::SyntheticRecording sound(impacts, config);
    samples.reserve(static_cast<std::size_t>(sound.n_frames()) * config.channels.size());
    for (std::int64_t k = 0; k < sound.n_segments(); ++k) {
      const std::vector<float> read = audio::as_read_back(sound.segment(k), config.encoding);
      samples.insert(samples.end(), read.begin(), read.end());
      done(static_cast<double>(k + 1), static_cast<double>(sound.n_segments()));
    }
    truth = synthesis::truth_table(sound.truth(), recording);
    others = synthesis::others_table(sound.others());
  });
  py::dict result;
  const auto n_channels = static_cast<py::ssize_t>(config.channels.size());
  const auto n_frames = static_cast<py::ssize_t>(samples.size()) / n_channels;
  result["samples"] =
      n_channels == 1 ? array_of(std::move(samples)) : array_of(std::move(samples), {n_frames, n_channels});
  result["rate"] = config.rate_hz;
  result["truth"] = columns_of(std::move(truth));
  result["world"] = dict_of(stages::world_of(run.parameters));
  result["others"] = columns_of(std::move(others));
  return result;
}

/// Why the system does not let a file be read, as errno; 0: it does.
int error_of_file(const std::string& name) {
  if (fs::is_directory(name)) return EISDIR;
  return ::access(name.c_str(), R_OK) == 0 ? 0 : errno;
}

/// @return {columns, world, summary, warnings}
py::dict detect_files(const std::vector<std::string>& names, const Arguments& arguments, const py::object& progress) {
  auto [options, run] = parse<stages::DetectOptions>(arguments);
  if (names.empty()) throw InvalidArgument("no recording is given");
  std::vector<Note> notes;
  stages::Recordings found;
  stages::World world;
  python::run(run, progress, [&, &options = options, &run = run] {
    world = stages::world_of(std::vector<fs::path>(names.begin(), names.end()));
    const std::vector<fs::path> once =
        stages::each_once({names.begin(), names.end()}, run.common.n_threads, "recording", notes);
    found = loop::detect_all(once, options.config, run.common.n_threads, true,
                             stages::progress_line(run, "detect", once.size() == 1 ? "s of sound" : "recordings"));
  });
  if (stages::readable_of(found).empty())
    throw FileError(found.front().recording,
                    "none of the " + std::to_string(found.size()) +
                        " recordings can be read: " + found.front().found.notes.front().subject,
                    error_of_file(found.front().recording));
  py::dict result = detected(found, std::move(notes));
  result["world"] = dict_of(world);
  return result;
}

/// @return the same, without the world
py::dict detect_samples(const py::array& array, double rate_hz, const std::string& recording,
                        const Arguments& arguments, const py::object& progress) {
  auto [options, run] = parse<stages::DetectOptions>(arguments);
  const SoundArray sound(array);
  detection::DetectionConfig config = options.config;
  config.rate_hz.reset();  // that of numbers in files
  detection::Detection found;
  python::run(run, progress, [&, &run = run] {
    const ProgressCallback done = stages::progress_line(run, "detect", "s of sound");
    found = detection::detect(sound.samples(), rate_hz, recording, config, done, sound.n_channels());
  });
  const std::size_t n_onsets = found.onsets.size();
  return detected({{recording, n_onsets, std::move(found)}}, {});
}

/// @param of_onsets  their world. @return {columns, world, summary}
py::dict restitution(const py::dict& columns, const py::dict& of_onsets, const Arguments& arguments) {
  const stages::World world = world_of(of_onsets);
  auto [options, run] = read_in_memory([&] {
    return parse(arguments, stages::RestitutionOptions{},
                 [&](stages::RestitutionOptions& o, const stages::Given& given) {
                   o = stages::in_world(world, std::move(o), given, "onsets");
                 });
  });
  const fit::RestitutionConfig config = stages::with_ball(options);
  fit::Restitution found = fit::restitution_samples(onsets_of(columns), config);
  if (found.samples.empty()) throw InvalidArgument("no three successive impacts: no coefficient of restitution");
  py::dict result;
  result["columns"] = columns_of(to_table(found.samples));
  result["world"] = dict_of(stages::world_of(run.parameters));
  result["summary"] = json_text(stages::summary_of(found.counts, config), 2);
  return result;
}

/// The onsets of heights in this unit, a list for each drop. @param drops  as people write them: their digits count
py::dict onsets_of_heights(const std::vector<std::vector<std::string>>& drops, const std::string& unit) {
  std::string text = "drop,h\n";
  for (std::size_t drop = 0; drop < drops.size(); ++drop)
    for (const std::string& height : drops[drop]) text += std::to_string(drop) + "," + height + "\n";
  const std::string name = "heights";
  return read_in_memory([&] {
    const ForeignOptions options{"heights", unit, "h=h"};
    const TakenTable taken = onsets_from_foreign(read_foreign_table(text, name, options));
    return columns_of(to_table(onsets_from_table(taken.table, name)));
  });
}

/// wave.json of a recording.
std::string wave_of_file(const std::string& recording, int channel, const py::dict& onsets, double rate_hz, int track) {
  return json_text(value_of(detection::wave_preview(fs::path(recording), channel, onsets_of(onsets),
                                                    rate_hz > 0.0 ? std::optional(rate_hz) : std::nullopt, track)));
}

std::string wave_of_samples(const py::array& array, double rate_hz, const std::string& recording, int channel,
                            const py::dict& onsets) {
  const SoundArray sound(array);
  if (channel < 0 || channel >= sound.n_channels())
    throw InvalidArgument("channel " + std::to_string(channel) + ": the sound has " +
                          std::to_string(sound.n_channels()));
  const audio::AudioSource source = audio::source_in_memory(sound.samples(), rate_hz, sound.n_channels(), channel);
  return json_text(value_of(detection::wave_preview(source, recording, channel, onsets_of(onsets))));
}

/// Of outputs that no command writes. @param world  of what is written
stages::Run writing_of(const py::dict& world, bool force) {
  stages::Run run = writing(force);
  stages::keep_world(world_of(world), run.parameters);
  return run;
}

/// Writes sound with the encoding that `bits` names: 16, 24, 32 or float; its provenance beside it.
void write_sound(const std::string& path, const py::array& array, int rate_hz, const std::string& bits,
                 const py::dict& world, bool force) {
  stages::SynthesizeOptions how;
  stages::set_option({stages::section_of(how)}, "bits", {bits});
  const SoundArray sound(array);
  const auto samples = sound.samples();
  audio::AudioWriter writer(path, {rate_hz, sound.n_channels(), stages::encoding_of(how.bits)},
                            static_cast<std::int64_t>(samples.size()) / sound.n_channels(), force);
  writer.write(samples);
  writer.commit();
  stages::write_provenance(path, stages::provenance(writing_of(world, force), {}, stages::sha256_of_file(path)));
}

/// Writes a table as the command line does. @param kind  impacts, onsets or samples
void write_columns(const std::string& path, const py::dict& columns, const std::string& kind, const py::dict& world,
                   bool force) {
  const Table table = kind == "impacts"  ? to_table(impacts_of(columns))
                      : kind == "onsets" ? to_table(onsets_of(columns))
                                         : to_table(samples_of(columns));
  stages::write_table(writing_of(world, force), path, table);
}

/// Reads one. @return columns, what it was taken for, its world
py::tuple read_columns(const std::string& path, const std::string& kind, const std::string& as, const std::string& unit,
                       const std::string& columns, const std::string& tier) {
  const py::dict world = dict_of(stages::world_of(std::vector<fs::path>{path}));
  if (kind == "impacts")
    return py::make_tuple(columns_of(to_table(impacts_from_table(stages::read_table(path, impact_columns()), path))),
                          py::list(), world);
  options::ForeignFileOptions how;
  for (const auto& [name, text] : {std::pair{"as", as}, {"unit", unit}, {"columns", columns}, {"tier", tier}})
    for (const Member& member : members_of(&how))
      if (member.name == name && !text.empty()) member.set(&how, value_from_text(member, text));
  std::vector<std::string> taken_for;
  try {
    Table table =
        kind == "onsets"
            ? to_table(read_times("Onsets.from_csv(path, taken_as='intervals')",
                                  [&] { return stages::read_onsets(path, how, taken_for); }))
            : to_table(samples_from_table(
                  stages::open_samples(path, how.table, taken_for).next(std::numeric_limits<std::size_t>::max()),
                  path));
    return py::make_tuple(columns_of(std::move(table)), taken_for, world);
  } catch (const AmbiguousTable& table) {
    throw InvalidArgument(with_keywords(table, kind == "onsets" ? "Onsets.from_csv(path" : "Samples.from_csv(path"));
  }
}

}  // namespace

stages::Run writing(bool force) {
  stages::Run run;
  run.common.force = force;
  run.common.quiet = true;
  run.command_line = {"bouncelab (Python)"};
  return run;
}

std::string with_keywords(const AmbiguousTable& table, const std::string& call) {
  std::string text = table.question(), before = "; say ";
  for (const auto& [meaning, told] : table.readings()) {
    text += std::exchange(before, " or ") + call;
    for (const auto& [name, value] : {std::pair{"taken_as", told.as}, {"unit", told.unit}, {"columns", told.columns}})
      if (value != "auto" && !value.empty())
        text += std::string(", ") + name + "=" + std::string(py::repr(py::str(value)));
    text += ") (" + meaning + ")";
  }
  return text;
}

RestitutionSamples samples_of(const py::dict& columns) {
  const Table table = table_of(columns, sample_columns(), "samples");
  return read_in_memory([&] {
    DropsInTurn().check(table, "samples");
    return samples_from_table(table, "samples");
  });
}

void bind_stages(py::module_& m) {
  m.def("simulate", &simulate);
  m.def("synthesize", &synthesize);
  m.def("detect_files", &detect_files);
  m.def("detect_samples", &detect_samples);
  m.def("restitution", &restitution);
  m.def("onsets_of_heights", &onsets_of_heights);
  m.def("wave_of_file", &wave_of_file);
  m.def("wave_of_samples", &wave_of_samples);
  m.def("write_sound", &write_sound);
  m.def("write_columns", &write_columns);
  m.def("read_columns", &read_columns);
}

}  // namespace bouncelab::python
