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
}

}  // namespace
}  // namespace bouncelab::fault_test
