// SPDX-License-Identifier: GPL-3.0-or-later
/// Options from TOML files: --config.
#include <sys/stat.h>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

class ConfigFile : public ProgramTest {
 protected:
  /// The table that `simulate` writes with this file.
  std::string simulated(const std::string& toml, const std::string& options = "") const {
    write("c.toml", toml);
    const Result result = run("simulate --asperities 100 --config c.toml --out a.csv --force --quiet " + options);
    EXPECT_EQ(result.exit_code, 0) << toml << ": " << result.err;
    return content_of(folder_ / "a.csv");
  }

  void expect_refused(const std::string& toml, int exit_code, const std::vector<std::string>& words,
                      const std::string& command = "simulate --out a.csv") const {
    SCOPED_TRACE(toml);
    write("c.toml", toml);
    expect_one_line_error(run(command + " --config c.toml"), exit_code, words);
  }
};

TEST_F(ConfigFile, ASectionBelongsToItsCommand) {
  const std::string seed5 = simulated("drops = 2\nimpacts = 3\nseed = 5\n");
  EXPECT_EQ(simulated("drops = 2\nimpacts = 3\n[simulate]\nseed = 5\n[synthesize]\nseed = 6\nsnr_db = 20\n"), seed5);
  EXPECT_EQ(simulated("drops = 2\nimpacts = 3\nseed = 5\n[loop]\ndrops = 7\n[calibrate]\nseed = 9\n"), seed5);
}

TEST_F(ConfigFile, UnknownKeysAndSectionsAreNamedByLineWhoseverTheyAre) {
  expect_refused("[simulate]\nasperites = 1000\n", 2, {"c.toml: line 2", "'asperites'"});
  expect_refused("[simulate]\n[fit]\n\ndrops = 7\n", 2, {"c.toml: line 4", "'drops'", "bouncelab fit --help"});
  expect_refused("drops = 1\n[simulat]\n", 2, {"c.toml: line 2", "[simulat]"});
  expect_refused("[simulate.ball]\nradius = 1\n", 2, {"c.toml: line 1", "'ball'"});
  expect_refused("[[simulate]]\nradius = 1\n", 2, {"c.toml: line 1", "simulate"});
  expect_refused("config = \"d.toml\"\n", 2, {"c.toml: line 1", "'config'"});
}

TEST_F(ConfigFile, AKeyGivenTwiceIsRefused) {
  expect_refused("radius_law = \"constant:1e-3\"\nradius-law = \"constant:2e-3\"\n", 2, {"line 2", "line 1"});
  expect_refused("drops = 2\n[simulate]\ndrops = 3\n", 2, {"line 3", "'drops'", "line 1"});
  expect_refused("[fit]\nlaw_kind = \"series\"\nlaw-kind = \"constant\"\n", 2, {"line 3", "line 2"});
  expect_refused("drops = 2\ndrops = 3\n", 3, {"line 2"});
}

TEST_F(ConfigFile, OfAStageSetsThatStageAndIsRefusedWhereItCannot) {
  const std::string loop = "loop --out l";
  expect_refused("[simulate]\nseed = 5\n", 2, {"line 2", "'seed'", "simulate", "[loop]"}, loop);
  expect_refused("[simulate]\nout = \"i.csv\"\n", 2, {"line 2", "'out'"}, loop);
  expect_refused("[fit]\nnodes = [0.3]\n", 2, {"line 2", "'nodes'", "fit"}, loop);
  expect_refused("gravity = 9.8\n[simulate]\ngravity = 9.7\n", 2, {"line 3", "line 1"}, loop);
  write("c.toml",
        "[loop]\nseed = 5\n[simulate]\ndrops = 1\nasperities = 100\nimpacts = 20\n[synthesize]\nrate = 44100\n"
        "[analyze]\ndiagnostics = true\n");
  const Result result = run("loop --config c.toml --out l --quiet");
  EXPECT_LE(result.exit_code, 1) << result.err;
  const std::string meta = content_of(folder_ / "l" / "impacts.csv.meta.json");
  for (const char* set : {"\"seed\": \"5\"", "\"drops\": \"1\"", "\"rate\": \"44100\""})
    EXPECT_THAT(meta, testing::HasSubstr(set));
}

TEST_F(ConfigFile, ValuesAreReadAsOnTheCommandLineAndNamedByLine) {
  expect_refused("drops = 1\nseed = -1\n", 2, {"c.toml: line 2", "--seed", "'-1'", "0 to 18446744073709551615"});
  expect_refused("drops = 0x10\n", 2, {"line 1", "'drops'", "decimal"});
  expect_refused("drops = 0o17\n", 2, {"line 1", "'drops'", "decimal"});
  expect_refused("gravity = nan\n", 2, {"line 1", "--gravity", "'nan'"});
  expect_refused("max_time = inf\n", 2, {"line 1", "--max-time"});
  expect_refused("spin = [1, 2]\n", 2, {"line 1", "--spin", "X,Y,Z"});
  expect_refused("height = []\n", 2, {"line 1", "'height'", "empty"});
  expect_refused("height = 1979-05-27\n", 2, {"line 1", "'height'"});
  expect_refused("drops = [1, 2]\n", 2, {"line 1", "'drops'", "loop"});
}

TEST_F(ConfigFile, TheCommandLineReplacesAWholeList) {
  const std::string at_20cm = simulated("drops = 2\nimpacts = 3\nheight = 0.2\n");
  EXPECT_EQ(simulated("drops = 2\nimpacts = 3\nheight = [0.1, 0.3]\n", "--height 0.2"), at_20cm);
  write("s.csv", "v_mps,eps\n0.5,0.93\n0.6,0.92\n0.7,0.91\n0.8,0.92\n0.9,0.9\n1.0,0.91\n1.1,0.9\n");
  write("f.toml", "nodes = [0.6, 0.8]\n");
  run("fit s.csv --out f.json --config f.toml --law-kind constant --quiet");
  EXPECT_THAT(content_of(folder_ / "f.json.meta.json"),
              testing::ContainsRegex("\"nodes\": *\\[\\s*\"0.6\",\\s*\"0.8\""));
  run("fit s.csv --out f.json --config f.toml --nodes 0.7 --law-kind constant --quiet --force");
  EXPECT_THAT(content_of(folder_ / "f.json.meta.json"), testing::HasSubstr("\"nodes\": \"0.7\""));
}

TEST_F(ConfigFile, AListOfChannelsGivesAsManyChannels) {
  write("i.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.1,1,0.9\n0,1,0.3,0.9,0.8\n");
  write("c.toml", "channel = [\"0,0\", \"0.1,0.05\"]\nmax_mode = 2000\n");
  ASSERT_EQ(run("synthesize i.csv --config c.toml --out r.wav --quiet").exit_code, 0);
  EXPECT_EQ(content_of(folder_ / "r.wav").at(22), 2);  // the number of channels in a WAV's header
}

TEST_F(ConfigFile, WhatIsNoRegularFileOfTomlIsRefused) {
  fs::create_directory(folder_ / "folder");
  const std::string simulate = "simulate --out a.csv --config ";
  expect_one_line_error(run(simulate + "folder"), 3, {"folder", "regular file"});
  expect_one_line_error(run(simulate + "missing.toml"), 3, {"missing.toml"});
  expect_one_line_error(run(simulate + "''"), 3, {"no such file"});
  expect_one_line_error(run(simulate + "/dev/zero"), 3, {"/dev/zero", "regular file"});
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  expect_one_line_error(shell("timeout 60 \"$B\" " + simulate + "pipe"), 3, {"pipe", "regular file"});
  write("large.toml", std::string(1'100'000, '#'));
  expect_one_line_error(run(simulate + "large.toml"), 3, {"large.toml", "at most"});
}

TEST_F(ConfigFile, WrongTomlIsNamedByLine) {
  expect_refused("drops = 1\ndrag = 3\xc3\xa1\n", 3, {"c.toml", "line 2"});  // a letter where a blank may be
  expect_refused("drops = 1\n[.2]\n", 3, {"c.toml", "line 2"});
  expect_refused("[&", 3, {"c.toml", "line 1"});
  expect_refused("height = " + std::string(5000, '['), 3, {"c.toml", "line 1"});
  expect_refused(std::string("drops = 1\n\0", 11), 3, {"c.toml"});
  std::string deep = "a";  // a table in a table, 100,000 times, of which the library runs out of stack
  for (int k = 0; k < 100'000; ++k) deep += ".a";
  expect_refused("drops = 1\n[" + deep + "]\n", 3, {"c.toml", "line 2"});
  expect_refused(deep + " = 1\n", 3, {"c.toml", "line 1"});
}

TEST_F(ConfigFile, ThatAsksForJsonHasFailuresInItToo) {
  write("json.toml", "json = true\n");
  const Result result = run("restitution nothing.csv --config json.toml --out s.csv");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.out, ::testing::HasSubstr("\"exit_code\": 3"));
}

TEST_F(ConfigFile, ASweepOfTooManyCombinationsIsRefusedBeforeAnythingIsDone) {
  std::string list = "[1";
  for (int k = 2; k <= 1000; ++k) list += "," + std::to_string(k);
  list += "]\n";
  expect_refused("drops = " + list + "seed = " + list + "impacts = " + list, 2, {"1e+09 combinations", "10000"},
                 "loop --out l");
  EXPECT_FALSE(fs::exists(folder_ / "l"));
}

TEST_F(ConfigFile, ListsRunThroughInTheOrderOfTheFile) {
  write("c.toml", "snr_db = [30, 40]\ndrops = [1, 2]\nasperities = 100\nimpacts = 15\nrate = 44100\n");
  const Result result = run("loop --config c.toml --out l --quiet");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(content_of(folder_ / "l" / "sweep.csv").rfind("snr_db,drops,", 0), 0u);
}

}  // namespace
}  // namespace bouncelab::cli_test
