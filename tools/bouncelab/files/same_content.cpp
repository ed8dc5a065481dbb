// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/same_content.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <system_error>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/parallel.hpp"
#include "files/provenance.hpp"

namespace bouncelab::cli {
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

}  // namespace

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

}  // namespace bouncelab::cli
