// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/sample_files.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/text.hpp"
#include "files/same_content.hpp"
#include "files/table_file.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

namespace {

struct SampleFile {
  fs::path path;
  RestitutionSamples samples;
};

RestitutionSamples read_one(const fs::path& path) {
  return samples_from_table(read_table(path, sample_columns()), input_name(path));
}

/// The files with each content once.
std::vector<fs::path> each_once(const std::vector<fs::path>& files, int n_threads, std::vector<std::string>& warnings) {
  const std::vector<std::size_t> same = first_of_same_content(files, n_threads);
  std::vector<fs::path> once;
  for (std::size_t k = 0; k < files.size(); ++k)
    if (same[k] == k)
      once.push_back(files[k]);
    else
      warnings.push_back(printable(input_name(files[k])) + ": the same samples as " +
                         printable(input_name(files[same[k]])) + " (by content); counted once");
  return once;
}

std::string short_name(const fs::path& path) { return path == "-" ? input_name(path) : path.filename().string(); }

void name_recordings(std::vector<SampleFile>& files) {
  std::map<std::string, int> uses;
  for (const SampleFile& file : files) ++uses[short_name(file.path)];
  for (SampleFile& file : files) {
    const std::string name = short_name(file.path);
    for (RestitutionSample& s : file.samples)
      if (s.recording.empty()) s.recording = uses[name] > 1 ? input_name(file.path) : name;
  }
}

/// Recordings of which two files have the same drop.
std::set<std::string> ambiguous_recordings(const std::vector<SampleFile>& files) {
  std::map<std::pair<std::string, std::int64_t>, std::size_t> file_of;
  std::set<std::string> ambiguous;
  for (std::size_t k = 0; k < files.size(); ++k)
    for (const RestitutionSample& s : files[k].samples)
      if (file_of.try_emplace({s.recording, s.drop}, k).first->second != k) ambiguous.insert(s.recording);
  return ambiguous;
}

}  // namespace

RestitutionSamples read_sample_files(const std::vector<fs::path>& paths, int n_threads,
                                     std::vector<std::string>& warnings) {
  if (paths.size() == 1) return read_one(paths.front());
  std::vector<SampleFile> files;
  for (const fs::path& path : each_once(paths, n_threads, warnings)) files.push_back({path, read_one(path)});
  if (files.size() > 1) name_recordings(files);
  const std::set<std::string> ambiguous = ambiguous_recordings(files);
  for (const std::string& name : ambiguous)
    warnings.push_back(printable(name) +
                       ": several files have the same drop of this recording: taken as a recording "
                       "for each file; give the drops numbers of their own if it is one");
  RestitutionSamples all;
  for (SampleFile& file : files)
    for (RestitutionSample& s : file.samples) {
      if (ambiguous.count(s.recording) > 0) s.recording += " (" + input_name(file.path) + ")";
      all.push_back(std::move(s));
    }
  return all;
}

}  // namespace bouncelab::cli
