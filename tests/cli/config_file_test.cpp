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
    return content("a.csv");
  }

  void expect_wrong(const std::string& toml, int exit_code, const std::vector<std::string>& words,
                    const std::string& command = "simulate --out a.csv") const {
    SCOPED_TRACE(toml.substr(0, 200));
    write("c.toml", toml);
    expect_refused(command + " --config c.toml", exit_code, words);
  }
};

TEST_F(ConfigFile, ASectionBelongsToItsCommand) {
  const std::string seed5 = simulated("drops = 2\nimpacts = 3\nseed = 5\n");
  EXPECT_EQ(simulated("drops = 2\nimpacts = 3\n[simulate]\nseed = 5\n[synthesize]\nseed = 6\nsnr_db = 20\n"), seed5);
  EXPECT_EQ(simulated("drops = 2\nimpacts = 3\nseed = 5\n[loop]\ndrops = 7\n[fit]\nseed = 9\n"), seed5);
}

TEST_F(ConfigFile, UnknownKeysAndSectionsAreNamedByLineWhoseverTheyAre) {
  expect_wrong("[simulate]\nasperites = 1000\n", 2, {"c.toml: line 2", "'asperites'"});
  expect_wrong("[simulate]\n[fit]\n\ndrops = 7\n", 2, {"c.toml: line 4", "'drops'", "bouncelab fit --help"});
  expect_wrong("drops = 1\n[simulat]\n", 2, {"c.toml: line 2", "[simulat]"});
  expect_wrong("[simulate.ball]\nradius = 1\n", 2, {"c.toml: line 1", "'ball'"});
  expect_wrong("[[simulate]]\nradius = 1\n", 2, {"c.toml: line 1", "simulate"});
  expect_wrong("config = \"d.toml\"\n", 2, {"c.toml: line 1", "'config'"});
}

TEST_F(ConfigFile, AKeyGivenTwiceIsRefused) {
  expect_wrong("radius_law = \"constant:1e-3\"\nradius-law = \"constant:2e-3\"\n", 2, {"line 2", "line 1"});
  expect_wrong("drops = 2\n[simulate]\ndrops = 3\n", 2, {"line 3", "'drops'", "line 1"});
  expect_wrong("[fit]\nlaw_kind = \"series\"\nlaw-kind = \"constant\"\n", 2, {"line 3", "line 2"});
  expect_wrong("drops = 2\ndrops = 3\n", 3, {"line 2"});
}

TEST_F(ConfigFile, OfAStageSetsThatStageAndIsRefusedWhereItCannot) {
  const std::string loop = "loop --out l";
  expect_wrong("[simulate]\nseed = 5\n", 2, {"line 2", "'seed'", "simulate", "[loop]"}, loop);
  expect_wrong("[simulate]\nout = \"i.csv\"\n", 2, {"line 2", "'out'"}, loop);
  expect_wrong("[fit]\nnodes = [0.3]\n", 2, {"line 2", "'nodes'", "fit"}, loop);
  expect_wrong("gravity = 9.8\n[simulate]\ngravity = 9.7\n", 2, {"line 3", "line 1"}, loop);
  write("c.toml",
        "[loop]\nseed = 5\n[simulate]\ndrops = 1\nasperities = 100\nimpacts = 20\n[synthesize]\nrate = 44100\n"
        "[analyze]\ndiagnostics = true\n");
  const Result result = run("loop --config c.toml --out l --quiet");
  EXPECT_LE(result.exit_code, 1) << result.err;
  const std::string meta = content("l/impacts.csv.meta.json");
  for (const char* set : {"\"seed\": \"5\"", "\"drops\": \"1\"", "\"rate\": \"44100\""})
    EXPECT_THAT(meta, testing::HasSubstr(set));
}

TEST_F(ConfigFile, ValuesAreReadAsOnTheCommandLineAndNamedByLine) {
  expect_wrong("drops = 1\nseed = -1\n", 2, {"c.toml: line 2", "--seed", "'-1'", "0 to 18446744073709551615"});
  expect_wrong("drops = 0x10\n", 2, {"line 1", "'drops'", "decimal"});
  expect_wrong("gravity = nan\n", 2, {"line 1", "--gravity", "'nan'"});
  expect_wrong("spin = [1, 2]\n", 2, {"line 1", "--spin", "X,Y,Z"});
  expect_wrong("height = []\n", 2, {"line 1", "'height'", "empty"});
  expect_wrong("drops = [1, 2]\n", 2, {"line 1", "'drops'", "loop"});
}

TEST_F(ConfigFile, TheCommandLineReplacesAWholeList) {
  const std::string at_20cm = simulated("drops = 2\nimpacts = 3\nheight = 0.2\n");
  EXPECT_EQ(simulated("drops = 2\nimpacts = 3\nheight = [0.1, 0.3]\n", "--height 0.2"), at_20cm);
  write("s.csv", "v_mps,eps\n0.5,0.93\n0.6,0.92\n0.7,0.91\n0.8,0.92\n0.9,0.9\n1.0,0.91\n1.1,0.9\n");
  write("f.toml", "nodes = [0.6, 0.8]\n");
  run("fit s.csv --out f.json --config f.toml --law-kind constant --quiet");
  EXPECT_THAT(content("f.json.meta.json"), testing::ContainsRegex("\"nodes\": *\\[\\s*\"0.6\",\\s*\"0.8\""));
  run("fit s.csv --out f.json --config f.toml --nodes 0.7 --law-kind constant --quiet --force");
  EXPECT_THAT(content("f.json.meta.json"), testing::HasSubstr("\"nodes\": \"0.7\""));
}

TEST_F(ConfigFile, WhatIsNoRegularFileOfTomlIsRefused) {
  fs::create_directory(folder_ / "folder");
  const std::string simulate = "simulate --out a.csv --config ";
  expect_one_line_error(run(simulate + "folder"), 3, {"folder", "regular file"});
  expect_one_line_error(run(simulate + "missing.toml"), 3, {"missing.toml"});
  expect_one_line_error(run(simulate + "''"), 3, {"regular file"});
  expect_one_line_error(run(simulate + "/dev/zero"), 3, {"/dev/zero", "regular file"});
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  expect_one_line_error(shell("timeout 60 \"$B\" " + simulate + "pipe"), 3, {"pipe", "regular file"});
  write("large.toml", std::string(1'100'000, '#'));
  expect_one_line_error(run(simulate + "large.toml"), 3, {"large.toml", "at most"});
}

TEST_F(ConfigFile, WrongTomlIsNamedByLine) {
  expect_wrong("drops = 1\ndrag = 3\xc3\xa1\n", 3, {"c.toml", "line 2"});  // a letter where a blank may be
  expect_wrong("height = " + std::string(5000, '['), 3, {"c.toml", "line 1"});
  expect_wrong("drops = 1\n[.2]\n", 3, {"c.toml", "a name is missing"});  // which the library takes for impossible
  expect_wrong(std::string("drops = 1\n\0", 11), 3, {"c.toml"});
  std::string deep = "a";  // a table in a table, 100,000 times, of which the library runs out of stack
  for (int k = 0; k < 100'000; ++k) deep += ".a";
  expect_wrong("drops = 1\n[" + deep + "]\n", 3, {"c.toml", "line 2"});
  expect_wrong(deep + " = 1\n", 3, {"c.toml", "line 1"});
}

}  // namespace
}  // namespace bouncelab::cli_test
