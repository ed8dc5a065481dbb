// SPDX-License-Identifier: GPL-3.0-or-later
/// The loop through memory: the paper's preset with fewer and shorter drops.
#include <map>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::cli_test {
namespace {

using Json = nlohmann::json;

class PaperLoop : public ProgramTest {
 protected:
  /// 23 recordings with the smooth ball's: enough to be killed in between. Too short for the fit with memory.
  static std::string command(const std::string& out, const std::string& more = "") { return loop(22, 10, out, more); }
  static std::string loop(int n_drops, int n_impacts, const std::string& out, const std::string& more) {
    return "loop --preset paper --drops " + std::to_string(n_drops) + " --impacts " + std::to_string(n_impacts) +
           " --asperities 20000 --out " + out + " " + more;
  }

  /// Starts the command and kills it (SIGKILL) once its journal has so many lines.
  void kill_at(const std::string& arguments, const fs::path& journal, int n_lines) const {
    const std::string script =
        "cd '" + folder_.path().string() + "' && ('" BOUNCELAB_PROGRAM "' " + arguments +
        " >/dev/null 2>&1 & pid=$!; while [ \"$(wc -l < '" + journal.string() + "' 2>/dev/null || echo 0)\" -lt " +
        std::to_string(n_lines) +
        " ] && kill -0 $pid 2>/dev/null; do sleep 0.01; done; kill -9 $pid; wait $pid) 2>/dev/null";
    std::system(script.c_str());
  }

  /// Everything in a folder but what tells how long it took.
  std::map<std::string, std::string> results(const std::string& folder) const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::directory_iterator(folder_ / folder)) {
      const std::string name = entry.path().filename().string();
      if (name.ends_with(".meta.json") || entry.is_directory()) continue;  // they hold the command line
      all[name] = content_of(entry.path());
    }
    Json summary = Json::parse(all["summary.json"]);
    for (const char* work : {"seconds", "processor_seconds", "peak_memory_bytes"}) summary.erase(work);
    all["summary.json"] = summary.dump();
    return all;
  }
};

TEST_F(PaperLoop, KilledThreeTimesItGoesOnAndEndsWithTheSameBytes) {
  ASSERT_EQ(run(command("whole", "--quiet")).exit_code, 0);
  const fs::path journal = folder_ / "killed" / "unfinished.journal";
  for (const int n_lines : {3, 9, 16}) {
    kill_at(command("killed", "--threads 2"), journal, n_lines);
    ASSERT_TRUE(fs::exists(journal)) << "it was finished before it could be killed";
    // a line torn in the middle, as a crash of the machine leaves it
    std::ofstream(journal, std::ios::app) << "{\"ball\":\"rough\",\"drop\":999,\"sou";
  }
  const Result result = run(command("killed", "--threads 1"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(fs::exists(journal));
  const auto whole = results("whole"), killed = results("killed");
  ASSERT_EQ(whole.size(), 12u);
  for (const auto& [name, content] : whole) EXPECT_EQ(killed.at(name), content) << name;
}

TEST_F(PaperLoop, AnUnfinishedRunWithOtherSettingsIsRefusedByTheirName) {
  kill_at(command("out"), folder_ / "out" / "unfinished.journal", 2);
  const std::string before = content_of(folder_ / "out" / "unfinished.journal");
  expect_one_line_error(run(command("out", "--snr-db 20")), 2,
                        {"unfinished.journal", "snr-db was 30, now 20", "--force"});
  expect_one_line_error(run(command("out", "--seed 2")), 2, {"seed", "was 1, now 2"});
  EXPECT_EQ(content_of(folder_ / "out" / "unfinished.journal"), before);
}

TEST_F(PaperLoop, MoreThanOneSensorIsRefused) {
  expect_one_line_error(run(command("out", "--channel 0,0 --channel 0.1,0")), 2, {"--channel", "one sensor, not 2"});
}

TEST_F(PaperLoop, AFinishedRunIsNotReplacedWithoutForce) {
  ASSERT_EQ(run(loop(2, 40, "out", "--quiet")).exit_code, 0);
  expect_one_line_error(run(loop(2, 40, "out", "")), 3, {"exists", "--force"});
  EXPECT_EQ(run(loop(2, 40, "out", "--quiet --force")).exit_code, 0);
}

TEST_F(PaperLoop, TheSoundKeptGivesTheOnsetsOfTheLoop) {
  ASSERT_EQ(run(loop(3, 40, "out", "--keep-sound --quiet")).exit_code, 0);
  ASSERT_EQ(run("detect out/sound/rough.*.flac --out again.csv --quiet").exit_code, 0);
  // but for the recordings' names the tables are the same
  std::string again = content_of(folder_ / "again.csv");
  for (std::size_t at; (at = again.find("out/sound/")) != std::string::npos;) again.erase(at, 10);
  EXPECT_EQ(again, content_of(folder_ / "out" / "onsets.csv"));
}

TEST_F(PaperLoop, AShortRunFindsItsImpactsAndSaysWhatItConcludes) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  const Result result = run(loop(22, 40, "out", "--json"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = Json::parse(result.out);
  EXPECT_EQ(summary["n_impacts"], 22 * 40);
  EXPECT_GE(summary["n_found"].get<int>(), 22 * 40 * 999 / 1000);
  EXPECT_LE(summary["n_invented"].get<int>(), 1);
  const Json paper = Json::parse(content_of(folder_ / "out" / "paper.json"));
  EXPECT_EQ(paper["conclusions"].size(), 5u);
  EXPECT_EQ(paper["energy_shares"]["impact"].size(), 40u);
  EXPECT_EQ(summary["theory"]["n_transforms"], 22 * 40);
  EXPECT_EQ(summary["reservoir"]["law"], "memory");
  EXPECT_EQ(summary["reservoir"]["n_drops"], 22);
  // a smooth ball scatters by the detector's errors alone, far below the asperities' part
  EXPECT_TRUE(paper["conclusions"][3]["holds"].get<bool>()) << paper["conclusions"][3];
}

class Sweep : public ProgramTest {};

TEST_F(Sweep, RunsEveryCombinationOfTheListsAndTheCommandLineWins) {
  write("sweep.toml",
        "drops = 2\nimpacts = 30\nasperities = 5000\n"
        "radius-law = [\"constant:1e-3\", \"uniform:5e-4,1.5e-3\"]\nsnr_db = [20, 40]\n");
  Result result = run("loop --config sweep.toml --out out --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  Json sweep = Json::parse(result.out);
  ASSERT_EQ(sweep["points"].size(), 4u);
  EXPECT_EQ(sweep["points"][1]["settings"]["radius-law"], "constant:1e-3");
  EXPECT_EQ(sweep["points"][1]["settings"]["snr-db"], "40");
  for (const Json& point : sweep["points"]) EXPECT_EQ(point["values"]["n_impacts"], 60);
  const std::string table = content_of(folder_ / "out" / "sweep.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 4);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "report.html"));

  result = run("loop --config sweep.toml --snr-db 30 --out one_list --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Json::parse(result.out)["points"].size(), 2u);
}

TEST_F(Sweep, WhatIsWrongWithAPointIsSaidBeforeTheWork) {
  write("sweep.toml", "drops = 2\nsnr_db = [20, 400]\n");
  expect_one_line_error(run("loop --config sweep.toml --out out"), 2, {"snr-db 400"});
  write("empty.toml", "snr_db = []\n");
  expect_one_line_error(run("loop --config empty.toml --out out"), 2, {"empty.toml", "line 1", "snr_db"});
  write("simulate.toml", "drops = [1, 2]\n");
  expect_one_line_error(run("simulate --config simulate.toml --out a.csv"), 2, {"drops", "only loop"});
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

}  // namespace
}  // namespace bouncelab::cli_test
