// SPDX-License-Identifier: GPL-3.0-or-later
#include "fault_test.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "support/places.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::fault_test {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Anything that is not JSON stays as it is, and so differs from every whole file.
std::string without_what_varies(const std::string& name, const std::string& content) {
  if (!name.ends_with(".meta.json")) return content;
  Json json = Json::parse(content, nullptr, false);
  if (!json.is_object()) return content;
  json.erase("command_line");
  if (json.contains("parameters"))
    for (const char* key : {"threads", "force"}) json["parameters"].erase(key);
  return json.dump();
}

}  // namespace

const std::vector<Job>& FaultTest::jobs() {
  static const std::vector<Job> all{
      {"simulate", "simulate --drops 30 --impacts 40 --asperities 5000 --out out/i.csv"},
      {"synthesize", "synthesize i.csv --rate 22050 --max-mode 10000 --out out/r.wav"},
      {"detect", "detect r.*.wav --out out/o.csv"},
      {"restitution", "restitution o.csv --out out/s.csv"},
      {"fit", "fit s.csv --out out/f.json"},
      {"report", "report fitted --out out/r.html"},
      {"analyze", "analyze r.*.wav --out out"},
      {"loop", "loop --drops 6 --impacts 20 --asperities 2000 --rate 48000 --out out"},
      {"paper", "loop --preset paper --drops 6 --impacts 10 --asperities 2000 --rate 48000 --keep-sound --out out"},
  };
  return all;
}

const Job& FaultTest::job(const std::string& name) {
  for (const Job& job : jobs())
    if (job.name == name) return job;
  throw std::invalid_argument("no job " + name);
}

void FaultTest::SetUp() {
  fs::permissions(folder_.path(), fs::perms::all);  // for commands that run as another user
  fs::create_directory(path("fitted"));
  empty_out();
  for (const char* input : {"simulate --drops 40 --impacts 8 --asperities 2000 --out i.csv",
                            "synthesize i.csv --rate 22050 --max-mode 10000 --lead-in 0.05 --pause 0.1 --each-drop "
                            "--out r.wav",
                            "detect r.*.wav --out o.csv", "restitution o.csv --out s.csv"})
    ASSERT_EQ(run(std::string(input) + " --quiet").exit_code, 0) << input;
  run("fit s.csv --out fitted/fit.json --quiet");
  ASSERT_TRUE(fs::exists(path("fitted/fit.json")));
}

void FaultTest::empty_out() const {
  fs::remove_all(path("out"));
  fs::create_directory(path("out"));
  fs::permissions(path("out"), fs::perms::all);
}

Result FaultTest::run_job(const Job& job, int n_threads, const std::string& more, const std::string& before) const {
  return run_under(before, job.arguments + (" --quiet --threads " + std::to_string(n_threads)) + " " + more);
}

Undisturbed FaultTest::undisturbed(const Job& job, const std::vector<int>& n_threads_each) const {
  Undisturbed result;
  for (const int n_threads : n_threads_each) {
    empty_out();
    const auto start = Clock::now();
    const int exit_code = run_job(job, n_threads).exit_code;
    result.duration_s[n_threads] = seconds_since(start);
    Files files = files_in();
    EXPECT_FALSE(files.empty());
    if (!result.files.empty()) {
      EXPECT_EQ(exit_code, result.exit_code);
      EXPECT_THAT(differences(files, result.files), testing::IsEmpty()) << n_threads << " threads";
    }
    result.exit_code = exit_code;
    result.files = std::move(files);
  }
  empty_out();
  return result;
}

Ending FaultTest::disturb(const Job& job, int n_threads, int signal, double after_s, const std::string& more) const {
  const std::string line = "cd '" + folder_.path().string() + "' && exec '" + test::kProgram + "' " + job.arguments +
                           " --quiet --threads " + std::to_string(n_threads) + " " + more +
                           " </dev/null >/dev/null 2>&1";
  const pid_t child = ::fork();
  if (child == 0) {
    ::execl("/bin/sh", "sh", "-c", line.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
  ::kill(child, signal);  // one that has ended is there until it is waited for
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) return {-1, WTERMSIG(status)};
  return {WEXITSTATUS(status), 0};
}

Files FaultTest::files_in(const std::string& folder) const {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(path(folder)))
    if (!entry.is_directory()) {
      const std::string name = fs::relative(entry.path(), path(folder)).string();
      files[name] = without_what_varies(name, cli_test::content_of(entry.path()));
    }
  return files;
}

std::vector<std::string> partial_files(const Files& files) {
  std::vector<std::string> names;
  for (const auto& [name, content] : files)
    if (fs::path(name).filename().string().starts_with(".")) names.push_back(name);
  return names;
}

std::vector<std::string> differences(const Files& found, const Files& expected) {
  std::set<std::string> names;
  for (const auto& [name, content] : expected)
    if (!found.contains(name))
      names.insert(name + " is missing");
    else if (found.at(name) != content)
      names.insert(name + " differs");
  for (const auto& [name, content] : found)
    if (!expected.contains(name)) names.insert(name + " is too much");
  return {names.begin(), names.end()};
}

void expect_nothing_half_written(const Files& found, const Undisturbed& expected) {
  const std::vector<std::string> partial = partial_files(found);
  for (const auto& [name, content] : found) {
    if (std::find(partial.begin(), partial.end(), name) != partial.end()) continue;
    const auto whole = expected.files.find(name);
    EXPECT_TRUE(whole != expected.files.end() && whole->second == content)
        << name << ", " << content.size() << " bytes";
  }
}

void expect_whole_or_explained(const Result& result, const Files& found, const Undisturbed& expected) {
  EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("unexpected error")));
  // some of many recordings could not be opened: the results are those of the others, and said to be
  if (result.err.find("the results are those of") != std::string::npos) return;
  if (result.exit_code == expected.exit_code) {
    EXPECT_THAT(differences(found, expected.files), testing::IsEmpty());
    return;
  }
  cli_test::expect_one_line_error(result, 3, {"bouncelab: "});
  EXPECT_THAT(partial_files(found), testing::IsEmpty());
  expect_nothing_half_written(found, expected);
}

RandomDisturbance::RandomDisturbance() {
  const char* seed = std::getenv("BOUNCELAB_FAULT_SEED");
  seed_ = seed != nullptr ? std::stoull(seed) : std::random_device{}();
  random_.seed(seed_);
}

int n_times(int n) {
  const char* factor = std::getenv("BOUNCELAB_FAULT_FACTOR");
  if (factor != nullptr) return n * std::stoi(factor);
  return test::kSanitizer != nullptr ? (n + 5) / 6 : n;
}

}  // namespace bouncelab::fault_test
