// SPDX-License-Identifier: GPL-3.0-or-later
// Runs that are killed or stopped at random moments.
#include <csignal>

#include "fault_test.hpp"

namespace bouncelab::fault_test {
namespace {

class Killed : public FaultTest {
 protected:
  bool all_but_the_lock(const Files& expected) const {
    Files found = files_in();
    found.erase(".bouncelab.lock");
    return differences(found, expected).empty();
  }

  /// Kills the run at n random moments. After each the run is repeated, or goes on, and has to end with the bytes of
  /// an undisturbed one; one that goes on is killed several times over in between.
  void kill_at_random_moments(const Job& job, int n) const {
    const Undisturbed whole = undisturbed(job, {1, 2, 7});
    const std::string again = job.resumes ? "" : "--force";
    RandomDisturbance random;
    int n_killed = 0;
    for (int k = 0; k < n; ++k) {
      SCOPED_TRACE(std::string(job.name) + ", BOUNCELAB_FAULT_SEED=" + std::to_string(random.seed()) + ", kill " +
                   std::to_string(k));
      const int n_threads = random.n_threads();
      const double after_s = random.between(0, whole.duration_s.at(n_threads));
      const Ending ending = disturb(job, n_threads, SIGKILL, after_s, again);
      if (ending.signal == SIGKILL) ++n_killed;
      expect_nothing_half_written(files_in(), whole);
      if (job.resumes && ending.signal == SIGKILL && k + 1 < n && random.coin()) continue;
      // where it was killed after the last file there is nothing left to go on with, but the folder's lock to delete
      const bool finished = job.resumes && all_but_the_lock(whole.files);
      if (finished) std::filesystem::remove(path("out/.bouncelab.lock"));
      if (!finished) {
        EXPECT_EQ(run_job(job, random.n_threads(), again).exit_code, whole.exit_code);
      }
      EXPECT_THAT(differences(files_in(), whole.files), testing::IsEmpty());
      if (job.resumes || random.coin()) empty_out();
      if (HasFailure()) return;
    }
    EXPECT_GT(n_killed, 0) << "all runs ended before they could be killed";
  }
};

TEST_F(Killed, ThePapersLoopGoesOnAndEndsWithTheSameBytes) { kill_at_random_moments(job("paper"), n_times(30)); }

TEST_F(Killed, DetectOfManyRecordingsRunAgainGivesTheSameBytes) { kill_at_random_moments(job("detect"), n_times(30)); }

TEST_F(Killed, AnalyzeOfManyRecordingsRunAgainGivesTheSameBytes) {
  kill_at_random_moments(job("analyze"), n_times(30));
}

TEST_F(Killed, SynthesizeRunAgainGivesTheSameBytes) { kill_at_random_moments(job("synthesize"), n_times(30)); }

class Stopped : public FaultTest {};

TEST_F(Stopped, BySignalsAtRandomMomentsCommandsSayItByTheirExitCodeAndLeaveNoPartialFile) {
  RandomDisturbance random;
  for (const char* name : {"synthesize", "detect", "analyze", "paper"}) {
    const Undisturbed whole = undisturbed(job(name), {1, 2, 7});
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
      for (int k = 0; k < n_times(6); ++k) {
        SCOPED_TRACE(std::string(name) + ", BOUNCELAB_FAULT_SEED=" + std::to_string(random.seed()) + ", signal " +
                     std::to_string(signal) + ", run " + std::to_string(k));
        const int n_threads = random.n_threads();
        const Ending ending =
            disturb(job(name), n_threads, signal, random.between(0, whole.duration_s.at(n_threads)), "--force");
        // ended before it was stopped; stopped; or not yet so far that it listens to signals
        EXPECT_TRUE(ending.exit_code == whole.exit_code || ending.exit_code == 130 || ending.signal == signal)
            << "exit code " << ending.exit_code << ", ended by signal " << ending.signal;
        EXPECT_THAT(partial_files(files_in()), testing::IsEmpty());
        expect_nothing_half_written(files_in(), whole);
        if (HasFailure()) return;
      }
    empty_out();
  }
}

}  // namespace
}  // namespace bouncelab::fault_test
