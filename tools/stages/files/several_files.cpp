// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/several_files.hpp"

#include <cstdint>
#include <map>
#include <system_error>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/files/provenance.hpp"

namespace bouncelab::stages {
namespace fs = std::filesystem;

namespace {

/// Empty where the file cannot be read: what is wrong with it is left to its reader.
std::string sum_if_readable(const fs::path& file) {
  try {
    return sha256_of_file(file);
  } catch (const FileError&) {
    return {};
  }
}

std::uintmax_t size_if_readable(const fs::path& file) {
  try {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(readable(file), error);
    return error ? 0 : size;
  } catch (const FileError&) {
    return 0;
  }
}

/// For each file the index of the first one with the same content, which mostly is its own.
std::vector<std::size_t> first_of_same_content(const std::vector<fs::path>& files, int n_threads) {
  std::map<std::uintmax_t, std::vector<std::size_t>> by_size;
  for (std::size_t k = 0; k < files.size(); ++k) by_size[size_if_readable(files[k])].push_back(k);
  std::vector<std::size_t> of_equal_size;
  for (const auto& [size, equal] : by_size)
    if (size > 0 && equal.size() > 1) of_equal_size.insert(of_equal_size.end(), equal.begin(), equal.end());
  std::vector<std::string> sums(files.size());
  parallel_for(of_equal_size.size(), n_threads,
               [&](std::size_t i) { sums[of_equal_size[i]] = sum_if_readable(files[of_equal_size[i]]); });
  std::vector<std::size_t> first(files.size());
  std::map<std::string, std::size_t> known;
  for (std::size_t k = 0; k < files.size(); ++k)
    first[k] = sums[k].empty() ? k : known.emplace(std::move(sums[k]), k).first->second;
  return first;
}

}  // namespace

std::vector<fs::path> each_once(const std::vector<fs::path>& files, int n_threads, const std::string& what,
                                std::vector<std::string>& warnings) {
  const std::vector<std::size_t> same = first_of_same_content(files, n_threads);
  std::vector<fs::path> once;
  for (std::size_t k = 0; k < files.size(); ++k)
    if (same[k] == k)
      once.push_back(files[k]);
    else
      warnings.push_back(printable(input_name(files[k])) + ": the same " + what + " as " +
                         printable(input_name(files[same[k]])) + " (by content); counted once");
  return once;
}

void RecordingNames::begin(const fs::path& file) {
  file_ = input_name(file);
  name_.clear();
  n_renamed_ = 0;
}

const std::string& RecordingNames::name(const std::string& recording) {
  if (!name_.empty() && recording == given_) return name_;
  given_ = recording;
  name_ = recording.empty() ? file_ : recording;
  const bool is_new = of_this_file_.insert(name_).second;
  if (of_earlier_files_.contains(name_)) {
    if (is_new) ++n_renamed_;
    name_ += " (" + file_ + ")";
  }
  return name_;
}

void RecordingNames::end(std::vector<std::string>& warnings) {
  of_earlier_files_.merge(std::exchange(of_this_file_, {}));
  if (n_renamed_ > 0)
    warnings.push_back(printable(file_) + ": " + std::to_string(n_renamed_) +
                       " recordings have the names of recordings in another file: taken as others, with the file's "
                       "name behind");
}

}  // namespace bouncelab::stages
