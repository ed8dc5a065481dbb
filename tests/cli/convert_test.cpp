// SPDX-License-Identifier: GPL-3.0-or-later
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

class Convert : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write("r.wav", float_wav(noise(44100 * 3, 0.01), 44100));
    write("o.csv",
          "recording,drop,impact,t_s,sigma_t_s,amplitude,snr_db,flags,probability\n"
          "r.wav,0,0,0.3000000123456789,1e-07,0.5,40.123456789,,0.999998\n"
          "r.wav,0,1,0.7000000987654321,,0.4,,clipped|doubtful,0.5\n"
          "r.wav,0,2,1.08,2e-07,0.30000000000000004,38,,0\n"
          "r.wav,0,3,1.4412,2e-07,0.2,37,,\n");
  }
};

TEST_F(Convert, ThroughEveryFormatAndBackIsTheSameTable) {
  const Result out = run("convert o.csv --to m.txt m.svl m.TextGrid m.wav");
  ASSERT_EQ(out.exit_code, 0) << out.err;
  const std::string table = content("o.csv");
  for (const std::string name : {"m.txt", "m.svl", "m.TextGrid", "m.wav"}) {
    SCOPED_TRACE(name);
    const Result back = run("convert " + name + " --recording r.wav --to back.csv --force");
    ASSERT_EQ(back.exit_code, 0) << back.err;
    EXPECT_EQ(content("back.csv"), table);
  }
  EXPECT_TRUE(exists("m.wav.meta.json"));
}

TEST_F(Convert, MarksCorrectedByHandGoOnToRestitution) {
  ASSERT_EQ(run("convert o.csv --to m.txt").exit_code, 0);
  std::string labels = content("m.txt");
  EXPECT_THAT(labels, testing::HasSubstr("\t0.1 clipped|doubtful\n"));
  // the doubtful one is moved by 2 ms, one more is found at the end
  const std::string doubtful = "0.7000000987654321\t0.7000000987654321\t";
  labels.replace(labels.find(doubtful), doubtful.size(), "0.698000\t0.698000\t");
  write("m.txt", labels + "1.784000\t1.784000\tI heard one here\n");
  const Result back = run("convert m.txt --recording r.wav --to corrected.csv");
  ASSERT_EQ(back.exit_code, 0) << back.err;
  EXPECT_THAT(back.out, testing::HasSubstr("5 onsets, 2 of them placed by hand"));
  const std::string corrected = content("corrected.csv");
  EXPECT_THAT(corrected, testing::HasSubstr("r.wav,0,1,0.698,,,,by_hand,\n"));
  EXPECT_THAT(corrected, testing::HasSubstr("r.wav,0,4,1.784,,,,by_hand,\n"));
  const Result samples = run("restitution corrected.csv --out s.csv");
  EXPECT_EQ(samples.exit_code, 0) << samples.err;
  const std::string table = content("s.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 3) << "five impacts in one chain";
  EXPECT_EQ(run("restitution o.csv --out before.csv").exit_code, 1) << "the doubtful one had broken it";
}

TEST_F(Convert, BadInputIsNamed) {
  expect_refused("convert none.txt --to x.csv", 3, {"none.txt", "no such file"});
  expect_refused("convert o.csv --to x.mp3", 2, {"x.mp3", ".TextGrid"});
  write("m.txt", "0.5\t0.5\thit\n");
  expect_refused("convert m.txt --to x.svl", 2, {"x.svl", "--recording"});
  expect_refused("convert m.txt --to x.wav", 2, {"x.wav", "--recording"});
  expect_refused("convert m.txt --recording gone.wav --to x.svl", 3, {"gone.wav"});
  expect_refused("convert r.wav --to x.csv", 3, {"r.wav", "no cue points"});
  write("late.txt", "0.5\t0.5\thit\n1000\t1000\thit\n");
  for (const char* out : {"x.svl", "x.TextGrid", "x.wav"})
    expect_refused(std::string("convert late.txt --recording r.wav --to ") + out, 3,
                   {"r.wav", "1000.000 s", "another recording"});
  expect_refused("convert o.csv --recording other.wav --to x.txt", 3, {"o.csv", "other.wav"});
  write("x.txt", "mine");
  expect_refused("convert o.csv --to x.txt", 3, {"x.txt", "--force"});
}

}  // namespace
}  // namespace bouncelab::cli_test
