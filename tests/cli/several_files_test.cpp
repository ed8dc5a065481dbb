// SPDX-License-Identifier: GPL-3.0-or-later
// `restitution` of several tables of onsets; `fit` and `compare` have tests of their own.
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

/// Rows of a drop of five impacts, as detect writes them.
std::string drop_of(const std::string& recording, int drop, double shrink) {
  std::ostringstream rows;
  rows.precision(17);
  double t_s = 1.0 + 10.0 * drop, interval_s = 0.3;
  for (int impact = 0; impact < 5; ++impact, t_s += interval_s, interval_s *= shrink)
    rows << recording << ',' << drop << ',' << impact << ',' << t_s << '\n';
  return rows.str();
}

const std::string kHeader = "recording,drop,impact,t_s\n";

class SeveralFiles : public ProgramTest {
 protected:
  std::string samples_of(const std::string& onsets, const std::string& warning = "") const {
    const Result result = run("restitution " + onsets + " --out s.csv --force");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err.empty(), warning.empty()) << result.err;
    EXPECT_THAT(result.err, testing::HasSubstr(warning));
    return content("s.csv");
  }
};

TEST_F(SeveralFiles, GiveTheSamplesOfTheirConcatenation) {
  const std::string first = drop_of("x.wav", 0, 0.9) + drop_of("x.wav", 1, 0.91), second = drop_of("y.wav", 0, 0.92);
  write("whole.csv", kHeader + first + second);
  write("1.csv", kHeader + first);
  write("2.csv", kHeader);  // of a recording in which nothing bounces
  write("3.csv", kHeader + second);
  EXPECT_EQ(samples_of("1.csv 2.csv 3.csv"), samples_of("whole.csv"));
}

TEST_F(SeveralFiles, NameTheRecordingsThatHaveNoNameOrThatOfAnother) {
  write("1.csv", kHeader + drop_of("x.wav", 0, 0.9));
  write("2.csv", kHeader + drop_of("x.wav", 0, 0.95));
  write("3.csv", "t_s\n0.1\n0.3\n0.48\n");
  const std::string samples =
      samples_of("1.csv 2.csv 3.csv", "2.csv: the names of 1 recording are in another file too");
  EXPECT_THAT(samples, testing::HasSubstr("\nx.wav,0,"));
  EXPECT_THAT(samples, testing::HasSubstr("\nx.wav (2.csv),0,"));
  EXPECT_THAT(samples, testing::HasSubstr("\n3.csv,0,"));
}

TEST_F(SeveralFiles, OfTheSameContentCountOnce) {
  write("1.csv", kHeader + drop_of("x.wav", 0, 0.9));
  write("copy.csv", kHeader + drop_of("x.wav", 0, 0.9));
  EXPECT_EQ(samples_of("1.csv copy.csv", "copy.csv: the same onsets as 1.csv"), samples_of("1.csv"));
  fs::copy_file(folder_ / "s.csv", folder_ / "t.csv");
  EXPECT_THAT(run("fit s.csv t.csv --out f.json").err,
              testing::HasSubstr("t.csv: the same samples as s.csv (by content)"));
  EXPECT_EQ(json("f.json")["n_used"], 3);
  write("a.wav", float_wav(bouncing(12), 44100));
  fs::copy_file(folder_ / "a.wav", folder_ / "copy.wav");
  write("other.wav", float_wav(bouncing(13), 44100));
  const Result result = run("detect a.wav copy.wav other.wav ./a.wav --out o.csv --json");
  EXPECT_EQ(Json(result.out)["n_onsets"], 25);
  for (const char* copy : {"copy.wav", "./a.wav"})
    EXPECT_THAT(result.err, testing::HasSubstr(std::string(copy) + ": the same recording as a.wav"));
  EXPECT_EQ(json("o.csv.meta.json")["inputs"].size(), 2u);
  EXPECT_EQ(run("analyze a.wav copy.wav other.wav --out out").exit_code, 0);
  EXPECT_EQ(json("out/summary.json")["n_onsets"], 25);
}

TEST_F(SeveralFiles, OfAFolderAreItsRecordingsWithoutTheProvenanceBesideThem) {
  write("a.wav", float_wav(bouncing(12), 44100));
  write("b.wav", float_wav(bouncing(13), 44100));
  write("b.wav.meta.json", "{}");
  const Result result = run("detect a.wav b.wav b.wav.meta.json --out o.csv --json");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Json(result.out)["n_onsets"], 25);
}

TEST_F(SeveralFiles, WithTheSameDropAreSaidToHaveItTwice) {
  for (const int begin_s : {0, 3}) {
    std::string rows = "t_s\n";
    double t_s = begin_s, interval_s = 0.5;
    for (const double eps : {0.85, 0.846, 0.853, 0.849, 0.855, 0.844, 0.851, 0.848, 0.85})
      rows += std::to_string(t_s) + "\n", t_s += interval_s, interval_s *= eps;
    write(begin_s == 0 ? "1.csv" : "2.csv", rows);
  }
  EXPECT_THAT(run("analyze 1.csv --out alone").out, testing::Not(testing::HasSubstr("twice")));
  EXPECT_THAT(run("analyze 1.csv 2.csv --out a").out, testing::HasSubstr("the same drop twice?"));
  ASSERT_EQ(run("restitution 1.csv 2.csv --out s.csv").exit_code, 0);
  EXPECT_THAT(run("compare s.csv --out c").err, testing::HasSubstr("the same drop twice?"));
}

TEST_F(SeveralFiles, OfTwoBallsNeedToBeToldWhichItIs) {
  ASSERT_EQ(run("simulate --drops 1 --impacts 5 --asperities 1000 --out 1.csv").exit_code, 0);
  ASSERT_EQ(run("simulate --drops 1 --impacts 5 --asperities 1000 --ball glass:5mm --out 2.csv").exit_code, 0);
  expect_one_line_error(run("restitution 1.csv 2.csv --out s.csv"), 2, {"2.csv", "--ball", "glass:5mm", "steel:6mm"});
  EXPECT_EQ(run("restitution 1.csv 2.csv --ball steel:6mm --out s.csv").exit_code, 0);
}

}  // namespace
}  // namespace bouncelab::cli_test
