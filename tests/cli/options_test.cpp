// SPDX-License-Identifier: GPL-3.0-or-later
/// How the values of options are read.
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

class Options : public ProgramTest {
 protected:
  /// Simulates into a.csv; the table without provenance.
  std::string simulated(const std::string& options) const {
    const Result result = run("simulate --asperities 100 --out a.csv --force --quiet " + options);
    EXPECT_EQ(result.exit_code, 0) << options << ": " << result.err;
    return content_of(folder_ / "a.csv");
  }

  void expect_wrong(const std::string& options, const std::vector<std::string>& words) const {
    SCOPED_TRACE(options);
    expect_one_line_error(run("simulate --asperities 100 --out a.csv --force --quiet " + options), 2, words);
  }
};

TEST_F(Options, IntegersAreDecimalWhateverTheyBeginWith) {
  const std::string ten = simulated("--drops 10 --impacts 3 --seed 8");
  EXPECT_EQ(simulated("--drops 010 --impacts 003 --seed 08"), ten);
  expect_wrong("--drops 0x10", {"--drops", "'0x10'", "decimal integer from 1 to 1000000000"});
  expect_wrong("--drops 0b11", {"--drops"});
  expect_wrong("--drops 1e2", {"--drops"});
  expect_wrong("--drops 2.0", {"--drops"});
  expect_wrong("--drops ''", {"--drops"});
}

TEST_F(Options, ASeedIsAnyNumberOf64BitsAndNoOther) {
  EXPECT_NE(simulated("--drops 1 --impacts 3 --seed 18446744073709551615"),
            simulated("--drops 1 --impacts 3 --seed 18446744073709551614"));
  for (const std::string seed : {"-1", "18446744073709551616", "0x1", "1.5", "nan"})
    expect_wrong("--seed " + seed, {"--seed", "'" + seed + "'", "0 to 18446744073709551615"});
}

TEST_F(Options, RealsAreDecimalFiniteAndInTheirRange) {
  expect_wrong("--gravity nan", {"--gravity", "'nan'", "finite decimal number from 0.001 to 1000"});
  expect_wrong("--gravity inf", {"--gravity"});
  expect_wrong("--gravity 0x1p3", {"--gravity"});
  expect_wrong("--ball steel:1e-300m", {"--ball", "'1e-300m'", "from 2 um to 2 m"});
  expect_wrong("--max-time inf", {"--max-time"});
  write("s.csv", "v_mps,eps\n1,0.9\n");
  for (const std::string option : {"--nodes", "--hand-off-speed", "--windows", "--window-width"})
    for (const std::string value : {"nan", "1e300", "-1", "0x1"}) {
      SCOPED_TRACE(option + " " + value);
      expect_one_line_error(run("fit s.csv --out f.json " + option + "=" + value), 2,
                            {option, "'" + value + "'", "to 1000"});
    }
}

TEST_F(Options, ListsOfTheWrongLengthAreRefusedWithTheRightOne) {
  expect_wrong("--height 0.1,0.2,0.3", {"--height", "'0.1,0.2,0.3'", "1 or 2", "LO[,HI]"});
  expect_wrong("--spin 1,2", {"--spin", "3 finite decimal numbers", "X,Y,Z"});
  expect_wrong("--spin 1,2,3,4", {"--spin"});
  expect_wrong("--start 1,2,3", {"--start", "2 finite decimal numbers", "X,Y"});
  expect_wrong("--velocity 1", {"--velocity"});
  expect_wrong("--plate-size 0.1", {"--plate-size"});
  expect_wrong("--plate-size 0.1,", {"--plate-size"});
  expect_wrong("--plate-size 0.1,nan", {"--plate-size"});
  expect_wrong("--height 0.2,-0.1", {"--height", "from 1e-06 to 1000"});
  write("o.csv", "t_s\n0.1\n0.2\n0.3\n");
  expect_one_line_error(run("restitution o.csv --out s.csv --sensor-position 1"), 2, {"--sensor-position", "X,Y"});
  write("i.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.1,1,0.9\n");
  for (const std::string channel : {"1", "1,2,3,4,5", "1,", "0x1,0", "nan,0"}) {
    SCOPED_TRACE(channel);
    expect_one_line_error(run("synthesize i.csv --out r.wav --channel " + channel), 2,
                          {"--channel", "'" + channel + "'"});
  }
}

TEST_F(Options, OfAListGivenTwiceTheLastCountsAsAWhole) {
  const std::string at_20cm = simulated("--drops 2 --impacts 3 --height 0.2");
  EXPECT_EQ(simulated("--drops 2 --impacts 3 --height 0.1 --height 0.2"), at_20cm);
  EXPECT_NE(simulated("--drops 2 --impacts 3 --height 0.1,0.2"), at_20cm);
}

TEST_F(Options, TheProvenanceRecordsTheValuesInForce) {
  simulated("--drops 1 --drops 002 --impacts 3 --height 0.1 --height 0.2");
  const std::string meta = content_of(folder_ / "a.csv.meta.json");
  EXPECT_THAT(meta, testing::HasSubstr("\"drops\": \"2\""));
  EXPECT_THAT(meta, testing::HasSubstr("\"height\": \"0.2\""));
  EXPECT_THAT(meta, testing::HasSubstr("\"spin\": \"0,0,0\""));
}

TEST_F(Options, AreQuotedInPartAndEscaped) {
  const std::string long_word(5000, 'x');
  for (const std::string option : {"--drops", "--gravity", "--height", "--contact", "--law", "--radius-law"}) {
    SCOPED_TRACE(option);
    const Result result = run("simulate --out a.csv " + option + " " + long_word);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_LT(result.err.size(), 1200u);
  }
  const Result result = run("simulate --out a.csv --contact '\x1b[31mred'");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("\x1b")));
}

}  // namespace
}  // namespace bouncelab::cli_test
