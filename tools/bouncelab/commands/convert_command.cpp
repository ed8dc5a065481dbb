// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <set>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

enum class Format { table, audacity, sonic_visualiser, praat, cues };

Format format_of(const fs::path& path) {
  refuse_no_csv(path);
  const std::string extension = lower_case(path.extension().string());
  if (extension == ".csv") return Format::table;
  if (extension.empty() && (path == "-" || path.native().starts_with("/dev/"))) return Format::table;  // no name tells
  if (extension == ".txt") return Format::audacity;
  if (extension == ".svl") return Format::sonic_visualiser;
  if (extension == ".textgrid") return Format::praat;
  if (extension == ".wav" || extension == ".rf64") return Format::cues;
  throw InvalidArgument(path.string() + ": no format has the extension '" + extension +
                        "'; use .csv, .txt (Audacity), .svl, .TextGrid or .wav");
}

/// With --recording those of this recording alone.
Onsets read_onsets(const ConvertOptions& options, std::vector<std::string>& taken_for) {
  const std::string name = input_name(options.input), &recording = options.foreign.recording;
  const Table table =
      open_onsets(options.input, options.foreign, taken_for).next(std::numeric_limits<std::size_t>::max());
  Onsets onsets = onsets_from_table(table, name);
  if (!recording.empty())
    std::erase_if(onsets, [&](const Onset& o) { return !o.recording.empty() && o.recording != recording; });
  for (Onset& onset : onsets)
    if (!recording.empty()) onset.recording = recording;
  if (onsets.empty()) throw FileError(name, "holds no onsets" + (recording.empty() ? "" : " of '" + recording + "'"));
  return onsets;
}

/// Whether the recording of the marks can be read: --recording, or the file that the marks name.
bool has_recording(const audio::Annotations& annotations, const ConvertOptions& options) {
  return annotations.recording == options.foreign.recording || is_unnamed_file(annotations.recording);
}

/// What a format of marks needs of the recording. @throws FileError with the remedy; where a mark lies beyond its end
audio::AudioFormat audio_format(const audio::Annotations& annotations, const std::string& out,
                                const ConvertOptions& options) {
  if (annotations.recording.empty())
    throw InvalidArgument(out +
                          ": this format needs the recording (its rate, or a copy of it); name it with --recording");
  if (!has_recording(annotations, options))
    throw FileError(input_name(annotations.recording),
                    "no such file, and " + out + " needs the recording of the marks; name it with --recording");
  audio::AudioFormat format = audio::AudioReader(annotations.recording).format();
  const double end_s = static_cast<double>(format.n_frames) / format.rate_hz;
  for (const audio::Annotation& point : annotations.points)
    if (point.t_s > end_s)
      throw FileError(input_name(annotations.recording),
                      fmt::format("ends at {:.3f} s, and a mark is at {:.3f} s: the marks are of another recording",
                                  end_s, point.t_s));
  return format;
}

void write_annotations(const fs::path& out, const Onsets& onsets, const ConvertOptions& options, const Run& run) {
  std::vector<fs::path> inputs = with_onsets_beside({options.input});
  const Format format = format_of(out);
  if (format == Format::audacity) return write_label_track(run, out, onsets, inputs);
  const audio::Annotations annotations = audio::annotations_of(onsets);
  if (format == Format::cues) {
    audio_format(annotations, out.string(), options);
    if (annotations.recording != options.input) inputs.emplace_back(annotations.recording);
    OutputFile file(out, run.common.force);
    const auto write = [&](std::string_view bytes) { file.write(bytes); };
    audio::copy_with_cues(annotations.recording, annotations, write, out.string());
    const std::string origin = provenance(run, inputs);
    return commit_with_provenance(file, out, origin);
  }
  std::string text;
  if (format == Format::sonic_visualiser) {
    const audio::AudioFormat audio = audio_format(annotations, out.string(), options);
    text = audio::sonic_visualiser_layer(annotations, static_cast<int>(audio.rate_hz), audio.n_frames);
  }
  if (format == Format::praat) {
    const bool known = !annotations.recording.empty() && has_recording(annotations, options);
    const audio::AudioFormat audio = known ? audio_format(annotations, out.string(), options) : audio::AudioFormat{};
    text = audio::text_grid(annotations, known ? static_cast<double>(audio.n_frames) / audio.rate_hz : 0.0);
  }
  write_text(run, out, text, inputs);
}

std::vector<fs::path> outputs_of(const ConvertOptions& options) {
  std::vector<fs::path> outputs(options.outputs.begin(), options.outputs.end());
  for (const std::string& out : options.outputs)
    if (format_of(out) == Format::audacity) outputs.push_back(onsets_beside(out));
  return outputs;
}

}  // namespace

Outcome run_convert(const ConvertOptions& options, const Run& run) {
  check_files(run, {options.input, options.foreign.recording}, outputs_of(options));
  std::vector<std::string> taken_for;
  const Onsets onsets = read_onsets(options, taken_for);
  // which recordings the marks are of is known only now: none of them may be replaced
  const std::vector<fs::path> inputs = with_onsets_beside({options.input});
  std::set<fs::path> read(inputs.begin(), inputs.end());
  for (const Onset& onset : onsets)
    if (is_unnamed_file(onset.recording)) read.insert(onset.recording);
  check_files(run, {read.begin(), read.end()}, outputs_of(options));
  for (const std::string& out : options.outputs)
    if (format_of(out) == Format::table)
      write_table(run, out, to_table(onsets), inputs);
    else
      write_annotations(out, onsets, options, run);
  const auto n_by_hand =
      std::count_if(onsets.begin(), onsets.end(), [](const Onset& onset) { return onset.flags.has(Flag::by_hand); });
  Outcome outcome;
  outcome.result = {{"n_onsets", value_of(onsets.size())}, {"n_by_hand", value_of(n_by_hand)}};
  outcome.text = lines_of(taken_for) + fmt::format("{} onsets, {} of them placed by hand\n", onsets.size(), n_by_hand);
  return outcome;
}

}  // namespace bouncelab::cli
