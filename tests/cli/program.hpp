// SPDX-License-Identifier: GPL-3.0-or-later
/// Runs the binary as a user would, in a folder of its own.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "support/places.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::cli_test {

namespace fs = std::filesystem;

struct Result {
  int exit_code = -1;
  std::string out, err;
};

inline std::string content_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Each test gets an empty folder; `run("detect a.wav --out b.csv")` runs there.
class ProgramTest : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return shell("\"$B\" " + arguments); }

  /// A script of the shell in that folder, in which $B is the program.
  Result shell(const std::string& script) const {
    const fs::path out = folder_.path().string() + ".out", err = folder_.path().string() + ".err";
    const std::string line = "cd '" + folder_.path().string() + "' && B='" + test::kProgram + "' && { " + script +
                             "\n} >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
    const int status = std::system(line.c_str());
    Result result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(out), content_of(err)};
    fs::remove(out);
    fs::remove(err);
    return result;
  }

  void write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }

  /// Names of all files in the folder, hidden ones too: nothing half-written may stay.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  test::TemporaryFolder folder_;
};

/// One line on standard error, with this exit code and these words in it: what bad input gets.
inline void expect_one_line_error(const Result& result, int exit_code, const std::vector<std::string>& words) {
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  for (const std::string& word : words) EXPECT_THAT(result.err, testing::HasSubstr(word));
}

}  // namespace bouncelab::cli_test
