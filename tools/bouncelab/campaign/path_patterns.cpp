// SPDX-License-Identifier: GPL-3.0-or-later
#include "campaign/path_patterns.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <system_error>

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

bool is_pattern(const std::string& name) { return name.find_first_of("*?[\\") != std::string::npos; }

/// Names in a folder, sorted; of one that cannot be read none.
std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> all;
  std::error_code unreadable;
  for (auto entry = fs::directory_iterator(folder.empty() ? "." : folder, unreadable);
       !unreadable && entry != fs::directory_iterator(); entry.increment(unreadable))
    all.push_back(entry->path().filename().string());
  std::sort(all.begin(), all.end());
  return all;
}

using Parts = std::vector<std::string>;

/// @param found  path so far, relative to `folder`
void find(const fs::path& folder, const fs::path& found, Parts::const_iterator part, Parts::const_iterator end,
          std::vector<std::string>& files) {
  std::error_code unreadable;
  if (part == end) {
    if (fs::is_regular_file(folder / found, unreadable)) files.push_back(found.string());
    return;
  }
  if (!is_pattern(*part)) {
    find(folder, found / *part, part + 1, end, files);
    return;
  }
  const bool any_depth = *part == "**";
  if (any_depth) find(folder, found, part + 1, end, files);
  for (const std::string& name : names_in(folder / found)) {
    if (any_depth) {
      // links to folders are not followed: they may lead back
      if (name.front() != '.' && fs::is_directory(fs::symlink_status(folder / found / name, unreadable)))
        find(folder, found / name, part, end, files);
    } else if (::fnmatch(part->c_str(), name.c_str(), FNM_PERIOD) == 0) {
      find(folder, found / name, part + 1, end, files);
    }
  }
}

}  // namespace

std::vector<std::string> files_of(const fs::path& folder, const std::string& pattern) {
  const fs::path path(pattern);
  Parts parts;
  for (const fs::path& part : path.relative_path())
    if (!part.empty()) parts.push_back(part.string());
  std::vector<std::string> files;
  if (!parts.empty()) find(folder, path.root_path(), parts.begin(), parts.end(), files);
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

bool names(const std::string& pattern, const std::string& path) {
  return ::fnmatch(pattern.c_str(), path.c_str(), 0) == 0;
}

}  // namespace bouncelab::cli
