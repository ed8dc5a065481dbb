// SPDX-License-Identifier: GPL-3.0-or-later
// Runs that are killed or stopped at random moments.
#include <csignal>

#include "fault_test.hpp"

namespace bouncelab::fault_test {
namespace {

class Killed : public FaultTest {
 protected:
  /// Sends signals at n random moments, every other time SIGKILL, which nobody can wait for. After a kill the run is
  /// repeated and has to end with the bytes of an undisturbed one.
  void disturb_at_random_moments(const Job& job, int n) const {
    const Undisturbed whole = undisturbed(job, {1, 2, 7});
    RandomDisturbance random;
    int n_killed = 0, n_stopped = 0;
    for (int k = 0; k < 2 * n; ++k) {
      const int signal = std::vector{SIGKILL, SIGINT, SIGKILL, SIGTERM, SIGKILL, SIGHUP}[k % 6];
      SCOPED_TRACE(std::string(job.name) + ", BOUNCELAB_FAULT_SEED=" + std::to_string(random.seed()) + ", signal " +
                   std::to_string(signal) + ", run " + std::to_string(k));
      const int n_threads = random.n_threads();
      const double after_s = random.between(0, whole.duration_s.at(n_threads));
      const Ending ending = disturb(job, n_threads, signal, after_s, "--force");
      expect_nothing_half_written(files_in(), whole);
      if (signal == SIGKILL) {
        if (ending.signal == SIGKILL) ++n_killed;
        EXPECT_EQ(run_job(job, random.n_threads(), "--force").exit_code, whole.exit_code);
        EXPECT_THAT(differences(files_in(), whole.files), testing::IsEmpty());
      } else {
        if (ending.exit_code == 130) ++n_stopped;
        // ended before it was stopped; stopped; or not yet so far that it listens to signals
        EXPECT_TRUE(ending.exit_code == whole.exit_code || ending.exit_code == 130 || ending.signal == signal)
            << "exit code " << ending.exit_code << ", ended by signal " << ending.signal;
        EXPECT_THAT(partial_files(files_in()), testing::IsEmpty());
      }
      if (random.coin()) empty_out();
      if (HasFailure()) return;
    }
    EXPECT_GT(n_killed, 0) << "all runs ended before they could be killed";
    EXPECT_TRUE(n_stopped > 0 || n < 10) << "no run was stopped by a signal that it listens to";
  }
};

// 10 moments each: a stretch of a tenth of the run in which something is half-written is met in two of three runs of
// this test, which draws other moments each time
TEST_F(Killed, OrStoppedThePapersLoopRunAgainGivesTheSameBytes) {
  disturb_at_random_moments(job("paper"), n_times(10));
}

TEST_F(Killed, OrStoppedAnalyzeOfManyRecordingsRunAgainGivesTheSameBytes) {
  disturb_at_random_moments(job("analyze"), n_times(10));
}

TEST_F(Killed, OrStoppedSynthesizeRunAgainGivesTheSameBytes) {
  disturb_at_random_moments(job("synthesize"), n_times(10));
}

}  // namespace
}  // namespace bouncelab::fault_test
