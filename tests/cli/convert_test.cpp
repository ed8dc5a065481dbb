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
  void expect_refused(const std::string& arguments, int exit_code, const std::vector<std::string>& words) {
    const auto before = files();
    SCOPED_TRACE(arguments);
    expect_one_line_error(run("convert " + arguments), exit_code, words);
    EXPECT_EQ(files(), before) << "something half-written was left";
  }
};

TEST_F(Convert, ThroughEveryFormatAndBackIsTheSameTable) {
  const Result out = run("convert o.csv --to m.txt m.svl m.TextGrid m.wav m.jsonl");
  ASSERT_EQ(out.exit_code, 0) << out.err;
  const std::string table = content_of(folder_ / "o.csv");
  for (const std::string name : {"m.txt", "m.svl", "m.TextGrid", "m.wav", "m.jsonl"}) {
    SCOPED_TRACE(name);
    const Result back = run("convert " + name + " --recording r.wav --to back.csv --force");
    ASSERT_EQ(back.exit_code, 0) << back.err;
    EXPECT_EQ(content_of(folder_ / "back.csv"), table);
  }
  EXPECT_TRUE(fs::exists(folder_ / "m.wav.meta.json"));
}

TEST_F(Convert, HighDropsAndFlagsOfOtherProgramsPassThroughMarks) {
  write("high.csv", "drop,t_s,flags\n99999999999,0.1,bad bounce\n99999999999,0.5,x=y\n99999999999,0.8,\n");
  ASSERT_EQ(run("convert high.csv --to high.txt").exit_code, 0);
  ASSERT_EQ(run("convert high.txt --to back.csv").exit_code, 0);
  const std::string back = content_of(folder_ / "back.csv");
  for (const char* part : {"99999999999,0,0.1,", "bad_bounce", "99999999999,1,0.5,", "x_y", "99999999999,2,0.8,"})
    EXPECT_THAT(back, testing::HasSubstr(part));
  EXPECT_THAT(back, testing::Not(testing::HasSubstr("by_hand")));
}

TEST_F(Convert, MarksCorrectedByHandGoOnToRestitution) {
  ASSERT_EQ(run("convert o.csv --to m.txt").exit_code, 0);
  std::string labels = content_of(folder_ / "m.txt");
  EXPECT_THAT(labels, testing::HasSubstr("\t0.1 clipped|doubtful\n"));
  // the doubtful one is moved by 2 ms, one more is found at the end
  const std::string doubtful = "0.7000000987654321\t0.7000000987654321\t";
  labels.replace(labels.find(doubtful), doubtful.size(), "0.698000\t0.698000\t");
  write("m.txt", labels + "1.784000\t1.784000\tI heard one here\n");
  const Result back = run("convert m.txt --recording r.wav --to corrected.csv");
  ASSERT_EQ(back.exit_code, 0) << back.err;
  EXPECT_THAT(back.out, testing::HasSubstr("5 onsets, 2 of them placed by hand"));
  const std::string corrected = content_of(folder_ / "corrected.csv");
  EXPECT_THAT(corrected, testing::HasSubstr("r.wav,0,1,0.698,,,,by_hand,\n"));
  EXPECT_THAT(corrected, testing::HasSubstr("r.wav,0,4,1.784,,,,by_hand,\n"));
  const Result samples = run("restitution corrected.csv --out s.csv");
  EXPECT_EQ(samples.exit_code, 0) << samples.err;
  const std::string table = content_of(folder_ / "s.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 3) << "five impacts in one chain";
  EXPECT_EQ(run("restitution o.csv --out before.csv").exit_code, 1) << "the doubtful one had broken it";
}

TEST_F(Convert, BadInputIsNamed) {
  expect_refused("none.txt --to x.csv", 3, {"none.txt", "no such file"});
  expect_refused("o.csv --to x.mp3", 2, {"x.mp3", ".TextGrid"});
  write("notes.txt", "dropped it twice\n");
  expect_refused("notes.txt --to x.csv", 3, {"notes.txt", "line 1"});
  write("empty.txt", "");
  expect_refused("empty.txt --to x.csv", 3, {"empty.txt", "empty"});
  write("m.txt", "0.5\t0.5\thit\n");
  expect_refused("m.txt --to x.svl", 2, {"x.svl", "--recording"});
  expect_refused("m.txt --to x.wav", 2, {"x.wav", "--recording"});
  expect_refused("m.txt --recording gone.wav --to x.svl", 3, {"gone.wav"});
  expect_refused("r.wav --to x.csv", 3, {"r.wav", "no cue points"});
  write("late.txt", "0.5\t0.5\thit\n1000\t1000\thit\n");
  for (const char* out : {"x.svl", "x.TextGrid", "x.wav"})
    expect_refused(std::string("late.txt --recording r.wav --to ") + out, 3,
                   {"r.wav", "1000.000 s", "another recording"});
  write("bad.jsonl", "{\"t_s\": 0.1}\n{\"t_s\": \"soon\"}\n");
  expect_refused("bad.jsonl --to x.csv", 3, {"bad.jsonl", "line 2", "t_s"});
  write("list.jsonl", "[1, 2]\n");
  expect_refused("list.jsonl --to x.csv", 3, {"list.jsonl", "line 1"});
  expect_refused("o.csv --recording other.wav --to x.txt", 3, {"o.csv", "other.wav"});
  write("x.txt", "mine");
  expect_refused("o.csv --to x.txt", 3, {"x.txt", "--force"});
}

}  // namespace
}  // namespace bouncelab::cli_test
