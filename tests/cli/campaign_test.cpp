// SPDX-License-Identifier: GPL-3.0-or-later
// Campaigns without a cluster: what they read, write, say and run on this machine. On a Slurm: tests/slurm.
#include "cli/program.hpp"

namespace bouncelab::cli_test {
namespace {

using testing::HasSubstr;
using testing::Not;

class Campaign : public ProgramTest {
 protected:
  /// Two recordings of different sound, in folders that a shell would take apart.
  void make_recordings() const {
    const Result made = shell(R"(
      mkdir -p "it's" 'b $HOME/deep/er'
      "$B" simulate --drops 1 --impacts 8 --asperities 2000 --out i.csv --quiet &&
      "$B" synthesize i.csv --rate 48000 --snr-db 40 --out "it's/a b.wav" --quiet 2>/dev/null &&
      "$B" synthesize i.csv --rate 48000 --snr-db 35 --seed 2 --out 'b $HOME/deep/er/c.wav' --quiet 2>/dev/null &&
      rm i.csv*)");
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
};

TEST_F(Campaign, DryRunShowsAllThatIsRunAndWritesNothing) {
  make_recordings();
  write("c.toml",
        "command = 'detect'\nout = 'my out'\nrecordings = ['it*/*.wav', '**/c.wav']\n"
        "[plates]\n\"it's/*\" = 'granite'\n"
        "[jobs]\nshards = 2\nmax_jobs = 7\npartition = 'long'\naccount = 'p1'\ntime = '1:00:00'\nmemory = '2G'\n"
        "cpus = 3\nsbatch = ['--qos=low']\n[detect]\nmin_impacts = 4\n[restitution]\nball = 'steel:6mm'\n");
  const Result shown = run("campaign c.toml --on local --dry-run");
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  for (const char* line :
       {"#SBATCH --partition=long\n", "#SBATCH --account=p1\n", "#SBATCH --time=1:00:00\n", "#SBATCH --mem=2G\n",
        "#SBATCH --cpus-per-task=3\n", "#SBATCH --qos=low\n", "#SBATCH --requeue\n", "#SBATCH --open-mode=append\n",
        "detect --config 'my out/onsets.h5.parts/run.toml' --shard \"$SLURM_ARRAY_TASK_ID/2\"\n",
        "merge 'my out/onsets.h5.parts'", "[detect]\nout = \"my out/onsets.h5\"\n", "threads = 3\nmin-impacts = 4\n",
        "[restitution]\nball = \"steel:6mm\"\n", "--max-procs=7"})
    EXPECT_THAT(shown.out, HasSubstr(line));
  EXPECT_FALSE(fs::exists(folder_ / "my out"));
}

TEST_F(Campaign, OnThisMachineGivesTheBytesOfThePlainRun) {
  make_recordings();
  write("c.toml",
        "command = 'detect'\nout = 'my out'\nrecordings = ['it*/*.wav', 'b*/**/*.wav']\n[jobs]\nshards = 2\n");
  const Result result = run("campaign c.toml --on local");
  EXPECT_THAT(result.out, HasSubstr("2 of 2 recordings done"));
  const Result plain = shell(R"("$B" detect "it's/a b.wav" 'b $HOME/deep/er/c.wav' --out plain.h5 --quiet)");
  EXPECT_EQ(plain.exit_code, 0) << plain.err;
  EXPECT_FALSE(content_of(folder_ / "plain.h5").empty());
  EXPECT_EQ(content_of(folder_ / "my out/onsets.h5"), content_of(folder_ / "plain.h5"))
      << result.out << result.err << content_of(folder_ / "my out/onsets.h5.parts/logs/merge.log");
  expect_one_line_error(run("campaign c.toml --on local"), 3,
                        {"my out/onsets.h5.parts", "submitted already", "resume"});
}

TEST_F(Campaign, ARecordingThatGivesNothingIsNamedAndTheOthersAreCompared) {
  ASSERT_EQ(shell("\"$B\" simulate --drops 2 --impacts 12 --asperities 1000 --out i.csv --quiet && "
                  "\"$B\" synthesize i.csv --each-drop --rate 22050 --out ball.wav --quiet")
                .exit_code,
            0);
  write("cut.wav", content_of(folder_ / "ball.0000.wav").substr(0, 60));
  write("c.toml", "command = 'detect'\nout = 'o'\nrecordings = '*.wav'\n[jobs]\nshards = 2\n");
  const Result result = run("campaign c.toml --on local");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string note = "1 of the 3 recordings of groups.csv has no samples: 'cut.wav'";
  EXPECT_THAT(result.err, HasSubstr(note));
  EXPECT_THAT(run("campaign status c.toml").err, HasSubstr(note));
  EXPECT_THAT(content_of(folder_ / "o/compare/report.html"), HasSubstr(note));
}

TEST_F(Campaign, ShardsThatFailAreNamedWithTheirLastLineAndResumedAlone) {
  write("c.toml",
        "command = 'loop'\nout = 'sweep'\n[jobs]\nshards = 3\n"
        "[loop]\ndrops = 2\nimpacts = 5\nasperities = 1000\nrate = 16000\nsnr-db = [20, 30, 40]\n");
  // a folder where the part is to be written
  const Result failed = shell("mkdir -p sweep.parts/shard-2-of-3.unfinished && \"$B\" campaign c.toml --on local");
  EXPECT_EQ(failed.exit_code, 1) << failed.err;
  EXPECT_THAT(failed.out, HasSubstr("3 shards: 2 complete, 1 failed"));
  EXPECT_THAT(failed.out, HasSubstr("shard 2 failed: bouncelab: "));
  EXPECT_THAT(failed.out, HasSubstr("sweep.parts/logs/shard-2.log"));
  EXPECT_THAT(failed.err, HasSubstr("1 of 3 shards have failed; bouncelab campaign resume c.toml"));
  const Result resumed = shell(
      "rmdir sweep.parts/shard-2-of-3.unfinished && \"$B\" campaign resume c.toml --dry-run && \"$B\" campaign resume "
      "c.toml");
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err << content_of(folder_ / "sweep.parts/logs/merge.log");
  EXPECT_THAT(resumed.out, HasSubstr("shards to submit: 2\n"));
  EXPECT_THAT(resumed.out, HasSubstr("the results are in sweep"));
  EXPECT_TRUE(fs::exists(folder_ / "sweep/sweep.csv"));
  const Result status = run("campaign status c.toml --json");
  EXPECT_EQ(status.exit_code, 0) << status.err;
  EXPECT_THAT(status.out, HasSubstr("\"n_done\": 3"));
}

TEST_F(Campaign, ShardsAreChosenByMeasuredCost) {
  write("c.toml",
        "command = 'loop'\nout = 'sweep'\n[jobs]\nseconds-per-shard = 1e6\n"
        "[loop]\ndrops = 2\nimpacts = 5\nasperities = 1000\nrate = 16000\nsnr-db = [20, 30, 40]\n");
  const Result shown = run("campaign c.toml --on local --dry-run");
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("of 3 points took"));
  // three points last far less than 1e6 s on any machine
  EXPECT_THAT(shown.out, HasSubstr("$SLURM_ARRAY_TASK_ID/1\""));
}

TEST_F(Campaign, MistakesAreNamedWithTheirLine) {
  write("a.wav", "no sound");
  const std::string head = "command = 'detect'\nout = 'o'\nrecordings = '*.wav'\n";
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases{
      {"out = 'o'\n", {"'command' is missing"}},
      {"command = 'report'\nout = 'o'\n", {"line 1", "'report'", "detect, analyze, loop"}},
      {"command = 'detect'\nout = 'o'\n", {"'recordings' is missing"}},
      {"command = 'detect'\nout = 'o.csv'\nrecordings = '*.wav'\n", {"o.csv", "folder"}},
      {"command = 'detect'\nout = 'o'\nrecordings = ['*.flac']\n", {"line 3", "'*.flac'"}},
      {"command = 'loop'\nout = 'o'\nrecordings = '*.wav'\n", {"line 3", "takes no recordings"}},
      {"command = 'loop'\nout = 'o'\nshards = 3\n", {"line 3", "unknown key 'shards'"}},
      {head + "[plates]\n'b/*' = 'x'\n", {"line 5", "'b/*'"}},
      {head + "[jobs]\nshard = 3\n", {"line 5", "did you mean 'shards'"}},
      {head + "[jobs]\nshards = 0\n", {"line 5", "shards", "from 1"}},
      {head + "[jobs]\nmemory = '2 G'\n", {"line 5", "without blanks"}},
      {head + "[jobs]\nsbatch = ['qos']\n", {"line 5", "begin with --"}},
      {head + "[jobs]\nshards = 1\n[detect]\nout = 'p'\n", {"line 7", "'out'"}},
      {head + "[jobs]\nshards = 1\n[detect]\nmin-impact = 4\n", {"line 7", "min-impact"}},
      {head + "[jobs]\nshards = 1\n[detect]\nmin-impacts = 1\n", {"line 7", "min-impacts"}},
      {head + "[jobs]\nshards = 1\n[detct]\n", {"line 6", "[detct]"}},
      {"command = 'simulate'\nout = 'o.h5'\n", {"[jobs] needs shards"}},
  };
  for (const auto& [toml, words] : cases) {
    SCOPED_TRACE(toml);
    write("c.toml", toml);
    std::vector<std::string> all = words;
    all.emplace_back("c.toml");
    expect_one_line_error(run("campaign c.toml --on local --dry-run"), 2, all);
  }
}

TEST_F(Campaign, WhereThereIsNoSlurmItSaysSo) {
  write("a.wav", "no sound");
  write("c.toml", "command = 'detect'\nout = 'o'\nrecordings = '*.wav'\n[jobs]\nshards = 1\n");
  expect_one_line_error(shell("PATH=/nowhere \"$B\" campaign c.toml --on slurm"), 3,
                        {"sbatch", "login node", "--on local"});
  expect_one_line_error(run("campaign c.toml"), 2, {"--on slurm", "--on local"});
  expect_one_line_error(run("campaign status c.toml"), 3, {"c.toml", "not submitted"});
  expect_one_line_error(run("campaign stats c.toml"), 2, {"'stats'", "start, status, resume, cancel"});
  expect_one_line_error(run("campaign resume"), 2, {"which campaign"});
  expect_one_line_error(run("campaign none.toml --on local"), 3, {"none.toml"});
  EXPECT_FALSE(fs::exists(folder_ / "o"));
}

}  // namespace
}  // namespace bouncelab::cli_test
