// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

enum class Format { table, audacity, sonic_visualiser, praat, cues };

Format format_of(const fs::path& path) {
  refuse_no_csv(path);
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".csv") return Format::table;
  if (extension.empty() && (path == "-" || path.native().starts_with("/dev/"))) return Format::table;  // no name tells
  if (extension == ".txt") return Format::audacity;
  if (extension == ".svl") return Format::sonic_visualiser;
  if (extension == ".textgrid") return Format::praat;
  if (extension == ".wav" || extension == ".rf64") return Format::cues;
  throw InvalidArgument(path.string() + ": no format has the extension '" + extension +
                        "'; use .csv, .txt (Audacity), .svl, .TextGrid or .wav");
}

/// The onsets of a table, in pieces; with --recording those of this recording alone.
template <class Take>
void for_each_piece(const ConvertOptions& options, std::vector<std::string>& taken_for, Take take) {
  const std::string name = input_name(options.input);
  TableReader reader = open_onsets(options.input, options.foreign, taken_for);
  std::optional<Onset> before;
  bool is_empty = true;
  for (bool at_end = false; !at_end;) {
    throw_if_stop_requested();
    const Table table = reader.next(kPiece_rows);
    at_end = table.n_rows() < kPiece_rows;
    Onsets onsets = onsets_from_table(table, name, before ? &*before : nullptr);
    if (!onsets.empty()) before = onsets.back();
    if (!options.foreign.recording.empty()) {
      std::erase_if(onsets, [&](const Onset& onset) {
        return !onset.recording.empty() && onset.recording != options.foreign.recording;
      });
      for (Onset& onset : onsets) onset.recording = options.foreign.recording;
    }
    is_empty = is_empty && onsets.empty();
    if (!onsets.empty()) take(std::move(onsets));
  }
  if (is_empty)
    throw FileError(
        name, "holds no onsets" + (options.foreign.recording.empty() ? "" : " of '" + options.foreign.recording + "'"));
}

Onsets read_onsets(const ConvertOptions& options, std::vector<std::string>& taken_for) {
  Onsets all;
  for_each_piece(options, taken_for,
                 [&](Onsets onsets) { std::move(onsets.begin(), onsets.end(), std::back_inserter(all)); });
  return all;
}

/// What a format of marks needs of the recording. @throws FileError with the remedy; where a mark lies beyond its end
audio::AudioFormat audio_format(const audio::Annotations& annotations, const std::string& out) {
  if (annotations.recording.empty())
    throw InvalidArgument(out +
                          ": this format needs the recording (its rate, or a copy of it); name it with --recording");
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
    audio_format(annotations, out.string());
    if (annotations.recording != options.input) inputs.emplace_back(annotations.recording);
    OutputFile file(out, run.common.force);
    const auto write = [&](std::string_view bytes) { file.write(bytes); };
    audio::copy_with_cues(annotations.recording, annotations, write, out.string());
    const std::string origin = provenance(run, inputs);
    return commit_with_provenance(file, out, origin);
  }
  std::string text;
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

/// Files that are read, with the onsets beside labels.
std::set<fs::path> inputs_of(const ConvertOptions& options) {
  const std::vector<fs::path> inputs = with_onsets_beside({options.input});
  return {inputs.begin(), inputs.end()};
}

std::vector<fs::path> outputs_of(const ConvertOptions& options) {
  std::vector<fs::path> outputs(options.outputs.begin(), options.outputs.end());
  for (const std::string& out : options.outputs)
    if (format_of(out) == Format::audacity) outputs.push_back(onsets_beside(out));
  return outputs;
}

/// What was converted.
struct Converted {
  std::size_t n_onsets = 0, n_by_hand = 0;
  std::vector<std::string> taken_for;

  void count(const Onsets& onsets) {
    n_onsets += onsets.size();
    n_by_hand += static_cast<std::size_t>(
        std::count_if(onsets.begin(), onsets.end(), [](const Onset& onset) { return onset.flags.has(Flag::by_hand); }));
  }
};

/// Which recordings the marks are of is known only now: none of them may be replaced.
void check_recordings(const ConvertOptions& options, std::set<fs::path> recordings, const Run& run) {
  recordings.merge(inputs_of(options));
  check_files(run, {recordings.begin(), recordings.end()}, outputs_of(options));
}

/// From table to tables: as long as they like.
Converted convert_table(const ConvertOptions& options, const Run& run) {
  std::vector<std::unique_ptr<TableWriter>> tables;
  for (const std::string& out : options.outputs) tables.push_back(std::make_unique<TableWriter>(run, out));
  Converted converted;
  std::set<fs::path> recordings;
  for_each_piece(options, converted.taken_for, [&](const Onsets& onsets) {
    for (std::size_t k = 0; k < onsets.size(); ++k)
      if (k == 0 || onsets[k].recording != onsets[k - 1].recording) recordings.insert(onsets[k].recording);
    converted.count(onsets);
    const Table rows = to_table(onsets);
    for (const auto& table : tables) table->add(rows);
  });
  check_recordings(options, std::move(recordings), run);
  for (const auto& table : tables) table->finish(with_onsets_beside({options.input}));
  return converted;
}

Converted convert_marks(const ConvertOptions& options, const Run& run) {
  Converted converted;
  const Onsets onsets = read_onsets(options, converted.taken_for);
  std::set<fs::path> recordings;
  for (const Onset& onset : onsets) recordings.insert(onset.recording);
  check_recordings(options, std::move(recordings), run);
  for (const std::string& out : options.outputs) {
    if (format_of(out) == Format::table)
      write_table(run, out, to_table(onsets), with_onsets_beside({options.input}));
    else
      write_annotations(out, onsets, options, run);
  }
  converted.count(onsets);
  return converted;
}

bool is_table(const std::string& path) { return format_of(path) == Format::table; }

}  // namespace

Outcome run_convert(const ConvertOptions& options, const Run& run) {
  check_files(run, {options.input, options.foreign.recording}, outputs_of(options));
  const bool tables_only = std::all_of(options.outputs.begin(), options.outputs.end(), is_table);
  const Converted converted = tables_only ? convert_table(options, run) : convert_marks(options, run);
  Outcome outcome;
  outcome.result = {{"n_onsets", value_of(converted.n_onsets)}, {"n_by_hand", value_of(converted.n_by_hand)}};
  outcome.text = lines_of(converted.taken_for) +
                 fmt::format("{} onsets, {} of them placed by hand\n", converted.n_onsets, converted.n_by_hand);
  return outcome;
}

}  // namespace bouncelab::cli
