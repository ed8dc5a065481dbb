// SPDX-License-Identifier: GPL-3.0-or-later
#include "page.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/report/notes.hpp"
#include "bouncelab/report/page.hpp"
#include "stage_options/options.hpp"

namespace bouncelab::web {
namespace {

using Json = nlohmann::ordered_json;
using Sections = std::vector<options::Section>;

/// The name of the option that is meant: as written, or without a unit at its end.
std::string name_meant(const Sections& sections, std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  for (const std::string unit : {"", "-m", "-s", "-hz", "-mps", "-mps2", "-rad"})
    if (const std::string name = key.substr(0, key.size() - unit.size());
        key.ends_with(unit) && options::option_named(sections, name))
      return name;
  throw InvalidArgument("unknown option '" + key + "'");
}

std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string list;
  for (const Json& item : value) list += (list.empty() ? "" : ",") + text_of(item);
  return list;
}

}  // namespace

Description members_of(const Seed*) {
  static constexpr Member all[]{member<&Seed::seed>("seed", "Seed of all random numbers")};
  return all;
}

void set_options(const Sections& sections, const std::string& json) {
  const Json options = json.empty() ? Json::object() : Json::parse(json, nullptr, false);
  if (!options.is_object()) throw InvalidArgument("the options are not a JSON object");
  for (const auto& [key, value] : options.items()) {
    if (value.is_null() || value == false) continue;
    options::set_option(sections, name_meant(sections, key), {text_of(value)});
  }
}

namespace {

/// Options of an analysis, as people set them.
/// @param more  options of one function alone
loop::AnalyzeConfig config_of(const std::string& options_json, const std::vector<options::Section>& more = {}) {
  static constexpr Member own[]{
      member<&loop::AnalyzeConfig::with_details>("diagnostics", "Details of each drop in the report"),
      member<&loop::AnalyzeConfig::detection, &detection::DetectionConfig::lossy_coding>(
          "lossy_coding", "Coding of the samples that the browser has decoded")};
  loop::AnalyzeConfig config;
  config.n_threads = config.fit.n_threads = 1;
  config.fit.memory = fit::UseMemory::where_long;
  options::RestitutionOptions restitution;
  Seed seed{config.fit.law.seed};
  std::vector<options::Section> sections{{"", own, &config},
                                         options::section_of(config.detection),
                                         ball_section(restitution.world),
                                         options::section_of(restitution.config),
                                         options::section_of(config.fit),
                                         options::section_of(seed)};
  sections.insert(sections.end(), more.begin(), more.end());
  set_options(sections, options_json);
  config.fit.law.seed = seed.seed;
  config.restitution = with_ball(restitution);
  return config;
}

/// @param name  of the recording or the file
Analysis completed(loop::Analysis found, const loop::AnalyzeConfig& config, const std::string& name) {
  if (found.onsets.empty() && !found.recordings.empty())
    throw InvalidArgument(name + ": " + report::in_words(found.recordings.front().found.notes.front()));
  if (found.restitution.samples.empty())
    throw InvalidArgument(name + ": no three successive impacts: no coefficient of restitution");
  Analysis analysis{std::move(found), {}, {}, name, {}};
  const loop::Analysis& all = analysis.found;
  analysis.words = report::in_words(all.fit, all.restitution.samples, config.fit.memory);
  std::vector<Note> notes = report::notes_of(all.restitution.counts, config.restitution);
  for (const auto& more : {analysis.words.notes, report::notes_of(all.recordings, false)})
    notes.insert(notes.end(), more.begin(), more.end());
  report::order(notes);
  take(notes, analysis.words);
  analysis.summary = object_of(all);
  for (const detection::RecordingDetection& recording : all.recordings)
    for (report::Taken& one : report::taken_of(recording)) analysis.words.taken.push_back(std::move(one));
  analysis.summary.emplace_back("taken", value_of(analysis.words.taken));
  analysis.summary.emplace_back("notes", report::values_of(notes));
  return analysis;
}

std::string csv_of(const Table& table) {
  std::ostringstream text;
  write_csv(text, table);
  return text.str();
}

/// The sound as if its impacts had been found in it.
detection::RecordingDetection marked(Onsets onsets, const Sound& sound, const std::string& recording,
                                     const detection::DetectionConfig& config) {
  detection::Detection found;
  found.status = detection::DetectionStatus::ok;
  found.summary.lossy_coding = config.lossy_coding;
  found.summary.rate_hz = sound.rate_hz;
  found.summary.n_channels = sound.n_channels;
  found.summary.channel = std::clamp(config.channel.value_or(0), 0, sound.n_channels - 1);
  found.summary.channel_reason = "as marked";
  found.summary.duration_s =
      static_cast<double>(sound.samples.size()) / static_cast<double>(sound.n_channels) / sound.rate_hz;
  std::set<std::int64_t> drops;
  for (Onset& onset : onsets) {
    onset.recording = recording;
    drops.insert(onset.drop);
  }
  found.summary.n_drops = std::ssize(drops);
  if (!config.lossy_coding.empty()) found.notes.push_back({NoteKind::lossy_coding, {}, config.lossy_coding});
  found.onsets = std::move(onsets);
  return {recording, found.onsets.size(), std::move(found)};
}

std::vector<detection::RecordingDetection> detected(const Sound& sound, const loop::AnalyzeConfig& config) {
  const std::string recording = file_name(sound.name);
  detection::Detection found =
      detection::detect(sound.samples, sound.rate_hz, recording, detection_config(config), {}, sound.n_channels);
  const std::size_t n_onsets = found.onsets.size();
  return {{recording, n_onsets, std::move(found)}};
}

Analysis analyzed(std::vector<detection::RecordingDetection> recordings, const Sound& sound,
                  const loop::AnalyzeConfig& config) {
  const auto sound_of = [&](const detection::RecordingDetection& r) {
    return audio::source_in_memory(sound.samples, sound.rate_hz, sound.n_channels, r.found.summary.channel);
  };
  loop::Analysis found;
  with_threads(1, [&] { found = loop::analyze_found(std::move(recordings), config, sound_of); });
  return completed(std::move(found), config, file_name(sound.name));
}

}  // namespace

std::vector<detection::RecordingDetection> detect(const Sound& sound, const std::string& options_json) {
  return detected(sound, config_of(options_json));
}

Analysis analyze(const Sound& sound, const std::string& options_json) {
  const loop::AnalyzeConfig config = config_of(options_json);
  return analyzed(detected(sound, config), sound, config);
}

Analysis analyze_onsets(Onsets onsets, const Sound& sound, const std::string& options_json) {
  if (onsets.empty()) throw InvalidArgument("no impact is marked; mark at least three");
  const loop::AnalyzeConfig config = config_of(options_json);
  return analyzed({marked(std::move(onsets), sound, file_name(sound.name), config.detection)}, sound, config);
}

bool holds_times(const std::string& bytes) {
  const std::string_view head = std::string_view(bytes).substr(0, audio::kHeadOfTimes_bytes);
  return bytes.size() <= audio::kLongestOfTimes_bytes && audio::holds_times(head, head.size() == bytes.size());
}

namespace {

/// Speeds that others measured; absent where the file holds something else, or what the reader of times refuses.
std::optional<TakenTable> speeds_in(const std::string& bytes, const std::string& name, const ForeignOptions& how) {
  if (audio::is_own_table(bytes)) return std::nullopt;
  std::optional<ForeignTable> table;
  try {
    table = read_foreign_table(decoded_text(bytes, name), name, how);
  } catch (const Error&) {
    if (how.tells_speeds()) throw;
  }
  if (!table || !holds_speeds(*table)) return std::nullopt;
  return samples_from_foreign(*table);
}

}  // namespace

Analysis analyze_times(const std::string& bytes, const std::string& name, const std::string& options_json) {
  options::ForeignFileOptions how;
  const loop::AnalyzeConfig config = config_of(options_json, {options::section_of(how)});
  std::string taken_for;
  if (std::optional<TakenTable> speeds = speeds_in(bytes, name, how.table)) {
    RestitutionSamples samples = samples_from_table(speeds->table, name);
    name_ball(samples, config.restitution.ball, config.restitution.plate);
    loop::Analysis found;
    with_threads(1, [&] { found = loop::analyze_samples(std::move(samples), config); });
    Analysis analysis = completed(std::move(found), config, name);
    analysis.taken_for = std::move(speeds->taken_for);
    return analysis;
  }
  Onsets onsets = audio::onsets_of_file(bytes, name, how.table, how.tier, taken_for);
  for (Onset& onset : onsets)
    if (onset.recording.empty()) onset.recording = name;
  loop::Analysis found;
  with_threads(1, [&] { found = loop::analyze_times(std::move(onsets), config); });
  Analysis analysis = completed(std::move(found), config, name);
  analysis.taken_for = std::move(taken_for);
  return analysis;
}

std::string Analysis::file(const std::string& name) const {
  if (name == "onsets.csv") return csv_of(to_table(found.onsets));
  if (name == "samples.csv") return csv_of(to_table(found.restitution.samples));
  if (name == "fit.json") return json_text(report::object_of(found.fit, words), 1) + "\n";
  if (name == "wave.json") return json_text(value_of(*found.wave)) + "\n";
  if (name == "labels.txt") return audio::audacity_labels(audio::shortened(audio::annotations_of(found.onsets)));
  if (name != "report.html") throw InvalidArgument("no file '" + name + "'");
  report::ReportInput input;
  input.title = "Restitution from " + name_of_file;
  input.fit_json = file("fit.json");
  if (found.wave) input.wave_json = file("wave.json");
  input.summary_json = json_text(summary);
  if (!found.details.empty()) input.diagnostics_json = json_text(Object{{"recordings", value_of(found.details)}});
  input.samples_json = report::samples_json(found.restitution.samples, input.fit_json);
  return report::render(input);
}

}  // namespace bouncelab::web
