// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/label_track.hpp"

#include "bouncelab/core/files.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {

std::filesystem::path onsets_beside(const std::filesystem::path& labels) {
  return std::filesystem::path(labels) += ".onsets.csv";
}

std::vector<std::filesystem::path> with_onsets_beside(std::vector<std::filesystem::path> files) {
  for (std::size_t k = 0, n = files.size(); k < n; ++k)
    if (const std::filesystem::path table = onsets_beside(files[k]);
        files[k].extension() == ".txt" && std::filesystem::exists(table))
      files.push_back(table);
  return files;
}

void write_label_track(const Run& run, const std::filesystem::path& out, const Onsets& onsets,
                       const std::vector<std::filesystem::path>& inputs) {
  write_text(run, out, audio::audacity_labels(audio::shortened(audio::annotations_of(onsets))), inputs);
  if (!is_stream(out)) write_table(run, onsets_beside(out), to_table(onsets), inputs);
}

audio::Annotations read_label_track(const std::filesystem::path& path, const std::string& text) {
  audio::Annotations labels = audio::parse_audacity_labels(text, input_name(path));
  const std::filesystem::path beside = onsets_beside(path);
  if (!std::filesystem::exists(beside)) return labels;
  const Onsets onsets = onsets_from_table(read_table(beside, onset_columns()), beside.string());
  if (labels.recording.empty() && !onsets.empty()) labels.recording = onsets.front().recording;
  return audio::completed(labels, onsets);
}

}  // namespace bouncelab::stages
