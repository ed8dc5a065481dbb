// SPDX-License-Identifier: GPL-3.0-or-later
/// The page's file system, which lies in memory: the commands of the command line read and write there.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace bouncelab::web {

/// An empty folder that is the working folder while this lives, and is removed with all in it.
class WorkingFolder {
 public:
  WorkingFolder();
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;
  ~WorkingFolder();
};

/// The last part of a recording's name, which is its name in the working folder; "recording" where there is none.
std::string file_name(const std::string& name);

/// @throws FileError
void write_file(const std::filesystem::path& path, std::string_view bytes);
/// Empty where there is no such file.
std::string read_file(const std::filesystem::path& path);

}  // namespace bouncelab::web
