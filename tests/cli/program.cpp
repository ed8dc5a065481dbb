// SPDX-License-Identifier: GPL-3.0-or-later
#include "program.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace bouncelab::cli_test {
namespace {

using Value = nlohmann::json;

const Value& value_of(const std::shared_ptr<const void>& value) { return *static_cast<const Value*>(value.get()); }

}  // namespace

std::string content_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Json::Json(const std::string& text) : value_(std::make_shared<const Value>(Value::parse(text))) {}
Json Json::operator[](std::size_t k) const {
  return Json(std::shared_ptr<const void>(value_, &value_of(value_).at(k)));
}
Json Json::operator[](const std::string& name) const {
  return Json(std::shared_ptr<const void>(value_, &value_of(value_).at(name)));
}
std::vector<Json> Json::elements() const {
  std::vector<Json> all;
  for (std::size_t k = 0; k < size(); ++k) all.push_back((*this)[k]);
  return all;
}
bool Json::contains(const std::string& name) const { return value_of(value_).contains(name); }
std::size_t Json::size() const { return value_of(value_).size(); }
bool Json::is_null() const { return value_of(value_).is_null(); }
double Json::number() const { return value_of(value_).get<double>(); }
std::string Json::text() const { return value_of(value_).get<std::string>(); }
bool Json::flag() const { return value_of(value_).get<bool>(); }
std::string Json::dump() const { return value_of(value_).dump(); }

Result ProgramTest::shell(const std::string& script) const {
  const fs::path out = folder_.path().string() + ".out", err = folder_.path().string() + ".err";
  const std::string line = "cd '" + folder_.path().string() + "' && B='" + test::kProgram + "' && { " + script +
                           "\n} >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(line.c_str());
  Result result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(out), content_of(err)};
  fs::remove(out);
  fs::remove(err);
  return result;
}

void ProgramTest::write(const std::string& name, const std::string& content) const {
  std::ofstream(folder_ / name, std::ios::binary) << content;
}

std::vector<std::string> ProgramTest::files() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

void ProgramTest::expect_refused(const std::string& arguments, int exit_code,
                                 const std::vector<std::string>& words) const {
  SCOPED_TRACE(arguments);
  const auto all_bytes = [&] {
    std::string bytes;
    for (const std::string& name : files()) bytes += name + "\n" + content(name);
    return bytes;
  };
  const std::string before = all_bytes();
  expect_one_line_error(run(arguments), exit_code, words);
  EXPECT_TRUE(all_bytes() == before) << "a file was made, half-written or changed";
}

void expect_one_line_error(const Result& result, int exit_code, const std::vector<std::string>& words) {
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  for (const std::string& word : words) EXPECT_THAT(result.err, testing::HasSubstr(word));
}

}  // namespace bouncelab::cli_test
