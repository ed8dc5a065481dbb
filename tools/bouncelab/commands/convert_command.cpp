// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/convert_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/output_file.hpp"
#include "files/provenance.hpp"
#include "files/table_file.hpp"
#include "json/stage_json.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

enum class Format { table, audacity, sonic_visualiser, praat, cues };

Format format_of(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".csv" || is_hdf5(path) || is_json_lines(path)) return Format::table;
  if (extension.empty() && (path == "-" || path.native().starts_with("/dev/"))) return Format::table;  // no name tells
  if (extension == ".txt") return Format::audacity;
  if (extension == ".svl") return Format::sonic_visualiser;
  if (extension == ".textgrid") return Format::praat;
  if (extension == ".wav" || extension == ".rf64") return Format::cues;
  throw InvalidArgument(path.string() + ": no format has the extension '" + extension +
                        "'; use .csv, .jsonl, .h5, .txt (Audacity), .svl, .TextGrid or .wav");
}

std::string content_of(const fs::path& path) {
  std::ifstream in(readable(path), std::ios::binary);
  if (!in) throw FileError(input_name(path), "cannot be opened for reading; check its permissions");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

audio::Annotations read_annotations(const fs::path& path, Format format) {
  const std::string name = input_name(path);
  if (format == Format::cues) return audio::read_cues(path);
  const std::string text = content_of(path);
  if (format == Format::sonic_visualiser) return audio::parse_sonic_visualiser_layer(text, name);
  return format == Format::praat ? audio::parse_text_grid(text, name) : audio::parse_audacity_labels(text, name);
}

Onsets read_onsets(const ConvertOptions& options) {
  const Format format = format_of(options.input);
  if (format != Format::table) {
    audio::Annotations annotations = read_annotations(options.input, format);
    if (annotations.points.empty()) throw FileError(input_name(options.input), "holds no marks");
    if (!options.recording.empty()) annotations.recording = options.recording;
    return audio::onsets_of(annotations, options.renumber);
  }
  Onsets onsets = onsets_from_table(read_table(options.input, onset_columns()), input_name(options.input));
  if (!options.recording.empty()) {
    std::erase_if(onsets,
                  [&](const Onset& onset) { return !onset.recording.empty() && onset.recording != options.recording; });
    for (Onset& onset : onsets) onset.recording = options.recording;
  }
  if (onsets.empty())
    throw FileError(
        input_name(options.input),
        "holds no onsets" + (options.recording.empty() ? std::string() : " of '" + options.recording + "'"));
  return onsets;
}

/// What a format of marks needs of the recording. @throws FileError with the remedy
audio::AudioFormat audio_format(const audio::Annotations& annotations, const std::string& out) {
  if (annotations.recording.empty())
    throw InvalidArgument(out +
                          ": this format needs the recording (its rate, or a copy of it); name it with --recording");
  return audio::AudioReader(annotations.recording).format();
}

void write_annotations(const fs::path& out, const audio::Annotations& annotations, const ConvertOptions& options,
                       const Run& run) {
  std::vector<fs::path> inputs{options.input};
  const Format format = format_of(out);
  if (format == Format::cues) {
    if (annotations.recording.empty()) audio_format(annotations, out.string());
    if (annotations.recording != options.input) inputs.emplace_back(annotations.recording);
    OutputFile file(out, run.common.force);
    audio::copy_with_cues(annotations.recording, annotations, file.temporary_path(), out.string());
    file.commit();
    write_provenance(run, out, inputs);
    return;
  }
  std::string text;
  if (format == Format::audacity) text = audio::audacity_labels(annotations);
  if (format == Format::sonic_visualiser) {
    const audio::AudioFormat audio = audio_format(annotations, out.string());
    text = audio::sonic_visualiser_layer(annotations, static_cast<int>(audio.rate_hz), audio.n_frames);
  }
  if (format == Format::praat) {
    const bool known = !annotations.recording.empty() && fs::exists(annotations.recording);
    const audio::AudioFormat audio = known ? audio_format(annotations, out.string()) : audio::AudioFormat{};
    text = audio::text_grid(annotations, known ? static_cast<double>(audio.n_frames) / audio.rate_hz : 0.0);
  }
  write_text(run, out, text, inputs);
}

}  // namespace

Outcome run_convert(const ConvertOptions& options, const Run& run) {
  for (const std::string& out : options.outputs) format_of(out);
  check_files(run, {options.input, options.recording}, {options.outputs.begin(), options.outputs.end()});
  const Onsets onsets = read_onsets(options);
  std::set<fs::path> inputs{options.input};  // which recordings the marks are of is known only now
  for (const Onset& onset : onsets) inputs.insert(onset.recording);
  check_files(run, {inputs.begin(), inputs.end()}, {options.outputs.begin(), options.outputs.end()});
  for (const std::string& out : options.outputs) {
    if (format_of(out) == Format::table)
      write_table(run, out, to_table(onsets), {options.input});
    else
      write_annotations(out, audio::annotations_of(onsets), options, run);
  }
  const auto n_by_hand =
      std::count_if(onsets.begin(), onsets.end(), [](const Onset& onset) { return onset.flags.has(Flag::by_hand); });
  Outcome outcome;
  outcome.json = convert_json(onsets.size(), static_cast<std::size_t>(n_by_hand));
  outcome.text = fmt::format("{} onsets, {} of them placed by hand\n", onsets.size(), n_by_hand);
  return outcome;
}

}  // namespace bouncelab::cli
