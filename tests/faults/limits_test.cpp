// SPDX-License-Identifier: GPL-3.0-or-later
// Too little of something: memory, descriptors, threads, size of a file. `prlimit` sets the limits.
#include <unistd.h>

#include <cmath>
#include <string_view>

#include "fault_test.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::fault_test {
namespace {

class Limits : public FaultTest {
 protected:
  /// Whether the program can be loaded at all: the dynamic linker's failures are not the program's.
  bool starts(const std::string& before) const { return run_under(before, "--version").exit_code == 0; }

  void expect_whole_or_explained_under(const std::vector<std::string>& limits, int n_threads,
                                       const std::vector<Job>& all = jobs()) const {
    for (const Job& job : all) {
      const Undisturbed whole = undisturbed(job);
      for (const std::string& before : limits) {
        SCOPED_TRACE(before + job.arguments);
        const Result result = run_job(job, n_threads, "", before);
        expect_whole_or_explained(result, files_in(), whole);
        empty_out();
      }
      if (HasFailure()) return;
    }
  }
};

TEST_F(Limits, OfMemoryEndInTheWholeResultOrInOneLine) {
  if (test::kSanitizer != nullptr)
    GTEST_SKIP() << test::kSanitizer << " needs more address space than any limit leaves";
  const auto limit = [](double bytes) { return "prlimit --as=" + std::to_string(static_cast<long>(bytes)) + " "; };
  double too_little = 2e7, enough = 1e9;
  while (enough > 1.003 * too_little) {
    const double bytes = std::sqrt(too_little * enough);
    (starts(limit(bytes)) ? enough : too_little) = bytes;
  }
  // densest above the least that the program can be loaded in, where the smallest requests fail too
  std::vector<std::string> limits;
  const int n = n_times(9);
  for (int k = 0; k < n; ++k) limits.push_back(limit(enough * std::pow(8.0, std::pow(k / (n - 1.0), 2))));
  // without sound kept as FLAC: libsndfile writes into the buffer of its encoder also where it got none
  std::vector<Job> all = jobs();
  all.back().arguments = "loop --preset paper --drops 6 --impacts 20 --asperities 2000 --rate 48000 --out out";
  expect_whole_or_explained_under(limits, 7, all);
}

TEST_F(Limits, OfDescriptorsEndInTheWholeResultOrInOneLine) {
  // it looks at memory through a pipe, and takes an object for none where there is no descriptor left for it
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kSanitizer << " needs descriptors of its own";
  std::vector<std::string> limits;
  for (int n = 3; n < 14; ++n) {
    const std::string before = "prlimit --nofile=" + std::to_string(n) + " ";
    if (starts(before)) limits.push_back(before);
  }
  expect_whole_or_explained_under(limits, 7);
}

TEST_F(Limits, OfFileSizeEndInTheWholeResultOrInOneLine) {
  std::vector<std::string> limits;
  for (const int bytes : {1000, 8192, 70000, 500000})
    limits.push_back("prlimit --fsize=" + std::to_string(bytes) + " ");
  expect_whole_or_explained_under(limits, 2);
}

TEST_F(Limits, OfProcessesCostTimeOnlyOrAreSaidInOneLine) {
  // root has no such limit
  std::string before = ::geteuid() == 0 ? "setpriv --reuid=65534 --regid=65534 --clear-groups " : "";
  if (!starts(before)) GTEST_SKIP() << "a user without rights cannot run the program where it is";
  before += "prlimit --nproc=1 ";
  if (!starts(before)) GTEST_SKIP() << "the limit cannot be set here";
  for (const Job& job : jobs()) {
    SCOPED_TRACE(job.arguments);
    const Undisturbed whole = undisturbed(job);
    const Result result = run_job(job, 7, "", before);
    expect_whole_or_explained(result, files_in(), whole);
    // sound is read in a process of its own, which cannot be done without; threads can
    if (std::string_view("simulate restitution fit report").find(job.name) != std::string_view::npos) {
      EXPECT_EQ(result.exit_code, whole.exit_code) << result.err;
    }
    empty_out();
  }
}

}  // namespace
}  // namespace bouncelab::fault_test
