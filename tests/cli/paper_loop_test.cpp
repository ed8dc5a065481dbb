// SPDX-License-Identifier: GPL-3.0-or-later
/// The loop through memory: the paper's preset with fewer and shorter drops.
#include "program.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::cli_test {
namespace {

class PaperLoop : public ProgramTest {
 protected:
  static std::string loop(int n_drops, int n_impacts, const std::string& out, const std::string& more) {
    return "loop --preset paper --drops " + std::to_string(n_drops) + " --impacts " + std::to_string(n_impacts) +
           " --asperities 20000 --out " + out + " " + more;
  }
};

TEST_F(PaperLoop, TheSoundKeptGivesTheOnsetsOfTheLoop) {
  expect_one_line_error(run(loop(2, 10, "out", "--channel 0,0 --channel 0.1,0")), 2,
                        {"--channel", "one sensor, not 2"});
  ASSERT_EQ(run(loop(3, 40, "out", "--keep-sound --quiet")).exit_code, 0);
  const Json parameters = json("out/onsets.csv.meta.json")["parameters"];
  EXPECT_EQ(parameters["lead-in"].text() + " " + parameters["pause"].text(), "0.1 0.3") << "not 0.5 1";
  ASSERT_EQ(run("detect out/sound/rough.*.flac --out again.csv --quiet").exit_code, 0);
  // but for the recordings' names the tables are the same
  std::string again = content("again.csv");
  for (std::size_t at; (at = again.find("out/sound/")) != std::string::npos;) again.erase(at, 10);
  EXPECT_EQ(again, content("out/onsets.csv"));
  expect_one_line_error(run(loop(3, 40, "out", "")), 3, {"exists", "--force"});
  EXPECT_EQ(run(loop(2, 40, "out", "--quiet --force")).exit_code, 0);
}

TEST_F(PaperLoop, AShortRunFindsItsImpactsAndSaysWhatItConcludes) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  const Result result = run(loop(22, 40, "out", "--json"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = Json(result.out);
  const Json& score = summary["score"];
  EXPECT_EQ(score["n_true"], 22 * 40);
  EXPECT_GE(score["n_found"].number(), 22 * 40 * 999 / 1000);
  EXPECT_LE(score["n_marked"].number(), score["n_found"].number() + 1);
  const Json paper = json("out/paper.json");
  EXPECT_EQ(paper["conclusions"].size(), 5u);
  EXPECT_EQ(paper["energy_shares"]["impact"].size(), 40u);
  EXPECT_EQ(summary["theory"]["n_transforms"], 22 * 40);
  EXPECT_EQ(summary["reservoir"]["law"], "memory");
  EXPECT_EQ(summary["reservoir"]["n_drops"], 22);
  // a smooth ball scatters by the detector's errors alone, far below the asperities' part
  EXPECT_EQ(paper["conclusions"][3]["holds"], true) << paper["conclusions"][3];
}

class Sweep : public ProgramTest {};

TEST_F(Sweep, RunsEveryCombinationOfTheListsAndTheCommandLineWins) {
  write("sweep.toml",
        "drops = 2\nimpacts = 30\nasperities = 5000\n"
        "radius-law = [\"constant:1e-3\", \"uniform:5e-4,1.5e-3\"]\nsnr_db = [20, 40]\n");
  Result result = run("loop --config sweep.toml --out out --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  Json sweep = Json(result.out);
  ASSERT_EQ(sweep["points"].size(), 4u);
  EXPECT_EQ(sweep["points"][1]["settings"]["radius-law"], "constant:1e-3");
  EXPECT_EQ(sweep["points"][1]["settings"]["snr-db"], "40");
  for (const Json& point : sweep["points"].elements()) EXPECT_EQ(point["values"]["n_true"], 60);
  const std::string table = content("out/sweep.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 4);
  EXPECT_TRUE(exists("out/report.html"));

  result = run("loop --config sweep.toml --snr-db 30 --out one_list --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Json(result.out)["points"].size(), 2u);
}

TEST_F(Sweep, WhatIsWrongWithAPointIsSaidBeforeTheWork) {
  write("sweep.toml", "drops = 2\nsnr_db = [20, 400]\n");
  expect_one_line_error(run("loop --config sweep.toml --out out"), 2, {"snr-db 400"});
  EXPECT_FALSE(exists("out"));
}

}  // namespace
}  // namespace bouncelab::cli_test
