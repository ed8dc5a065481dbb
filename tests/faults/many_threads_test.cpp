// SPDX-License-Identifier: GPL-3.0-or-later
// Every command on several threads: `tools/check threads` runs this under the thread sanitizer.
#include "fault_test.hpp"

namespace bouncelab::fault_test {
namespace {

class ManyThreads : public FaultTest {};

TEST_F(ManyThreads, ChangeNoByteOfAnyCommand) {
  for (const Job& job : jobs()) {
    SCOPED_TRACE(job.arguments);
    EXPECT_LE(undisturbed(job, {1, 2, 7}).exit_code, 1);  // 1: a fit that is not usable, from so few impacts
  }
  const std::string calibrate = "calibrate --samples 2000 --seeds 4 --json --threads ";
  const Result alone = run(calibrate + "1");
  EXPECT_EQ(alone.exit_code, 0) << alone.err;
  for (const char* n_threads : {"2", "7"}) {
    const Result result = run(calibrate + n_threads);
    EXPECT_EQ(result.exit_code, 0) << result.err;  // the thread sanitizer reports by it
    EXPECT_EQ(result.out, alone.out);
  }
}

}  // namespace
}  // namespace bouncelab::fault_test
