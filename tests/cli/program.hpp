// SPDX-License-Identifier: GPL-3.0-or-later
/// Runs the binary as a user would, in a folder of its own, and looks at what it wrote.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/places.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::cli_test {

namespace fs = std::filesystem;

struct Result {
  int exit_code = -1;
  std::string out, err;
};

std::string content_of(const fs::path& path);

/// JSON, or a part of it. What is not there, or not of the kind asked for, throws and so fails the test.
class Json {
 public:
  Json() = default;
  explicit Json(const std::string& text);

  /// An element of a list, or a value by its name.
  Json operator[](std::size_t k) const;
  Json operator[](const std::string& name) const;
  std::vector<Json> elements() const;
  bool contains(const std::string& name) const;
  std::size_t size() const;
  bool is_null() const;
  double number() const;
  std::string text() const;
  bool flag() const;
  std::string dump() const;

  template <class T>
  friend bool operator==(const Json& json, const T& value) {
    if constexpr (std::is_same_v<T, Json>)
      return json.dump() == value.dump();
    else if constexpr (std::is_same_v<T, bool>)
      return json.flag() == value;
    else if constexpr (std::is_arithmetic_v<T>)
      return json.number() == static_cast<double>(value);
    else
      return json.text() == value;
  }
  friend std::ostream& operator<<(std::ostream& out, const Json& json) { return out << json.dump(); }

 private:
  explicit Json(std::shared_ptr<const void> value) : value_(std::move(value)) {}
  std::shared_ptr<const void> value_;
};

/// Each test gets an empty folder; `run("detect a.wav --out b.csv")` runs there.
class ProgramTest : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return shell("\"$B\" " + arguments); }
  /// A script of the shell in that folder, in which $B is the program.
  Result shell(const std::string& script) const;

  void write(const std::string& name, const std::string& content) const;
  std::string content(const std::string& name) const { return content_of(folder_ / name); }
  Json json(const std::string& name) const { return Json(content(name)); }
  bool exists(const std::string& name) const { return fs::exists(folder_ / name); }
  /// Names of all files in the folder, hidden ones too: nothing half-written may stay.
  std::vector<std::string> files() const;
  /// As expect_one_line_error, and every file is as it was.
  void expect_refused(const std::string& arguments, int exit_code, const std::vector<std::string>& words) const;
  bool has_ffmpeg() const { return shell("command -v ffmpeg && command -v ffprobe").exit_code == 0; }

  test::TemporaryFolder folder_;
};

/// One line on standard error, with this exit code and these words in it: what bad input gets.
void expect_one_line_error(const Result& result, int exit_code, const std::vector<std::string>& words);

}  // namespace bouncelab::cli_test
