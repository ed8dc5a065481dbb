// SPDX-License-Identifier: GPL-3.0-or-later
/// Runs commands that are disturbed, and compares what they leave with an undisturbed run.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "cli/program.hpp"

namespace bouncelab::fault_test {

namespace fs = std::filesystem;
using cli_test::Result;

/// A command line without --threads, --force and --quiet. It writes into the folder `out` and nowhere else.
struct Job {
  const char* name;
  const char* arguments;
};

/// Files by their names below `out`.
using Files = std::map<std::string, std::string>;

/// What an undisturbed run leaves, and how long it takes.
struct Undisturbed {
  int exit_code = -1;
  Files files;
  std::map<int, double> duration_s;  ///< by number of threads
};

/// How a process ended.
struct Ending {
  int exit_code = -1;  ///< -1: by a signal
  int signal = 0;
};

class FaultTest : public cli_test::ProgramTest {
 protected:
  void SetUp() override;

  static const std::vector<Job>& jobs();  ///< one for each command that computes
  static const Job& job(const std::string& name);

  /// Runs on each number of threads, compares what they leave, and empties `out`.
  Undisturbed undisturbed(const Job& job, const std::vector<int>& n_threads_each = {2}) const;
  /// @param before  a command that runs the program, with a blank behind it ("prlimit --nofile=9 ")
  Result run_under(const std::string& before, const std::string& arguments) const {
    return shell(before + "\"$B\" " + arguments);
  }
  Result run_job(const Job& job, int n_threads, const std::string& more = "", const std::string& before = "") const;
  /// Sends the signal after that time, unless the program ended before.
  Ending disturb(const Job& job, int n_threads, int signal, double after_s, const std::string& more = "") const;

  void empty_out() const;
  /// Files below a folder of the test, without what differs from run to run: command line, threads, times.
  Files files_in(const std::string& folder = "out") const;

  fs::path path(const std::string& name) const { return folder_ / name; }
};

/// Names of files that a stopped or killed run may not leave to its successor.
std::vector<std::string> partial_files(const Files& files);
/// Names whose contents differ, or that one of them lacks. Files are too long to be printed.
std::vector<std::string> differences(const Files& found, const Files& expected);
/// Whole files only: whatever stands under a final name is what an undisturbed run writes there.
void expect_nothing_half_written(const Files& found, const Undisturbed& expected);
/// Either the whole result, or one line that says why not with exit code 3 and nothing half-written.
void expect_whole_or_explained(const Result& result, const Files& found, const Undisturbed& expected);

/// Random moments and numbers of threads. The seed is BOUNCELAB_FAULT_SEED, or drawn; it is printed with each failure.
class RandomDisturbance {
 public:
  RandomDisturbance();
  double between(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  int n_threads() { return std::vector{1, 2, 7}[std::uniform_int_distribution<std::size_t>(0, 2)(random_)]; }
  bool coin() { return std::bernoulli_distribution()(random_); }
  std::uint64_t seed() const { return seed_; }

 private:
  std::uint64_t seed_;
  std::mt19937_64 random_;
};

/// How often something is done: n times, BOUNCELAB_FAULT_FACTOR times as often where that is set, less often under
/// a sanitizer, where everything takes ten times as long.
int n_times(int n);

}  // namespace bouncelab::fault_test
