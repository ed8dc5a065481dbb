// SPDX-License-Identifier: GPL-3.0-or-later
// Tables longer than the memory.

#include "program.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::cli_test {
namespace {

/// Recordings of 20 drops of 25 impacts, as detect writes them.
std::string long_onsets(int n_recordings) {
  std::ostringstream text;
  text.precision(17);
  text << "recording,drop,impact,t_s,sigma_t_s,flags\n";
  for (int recording = 0; recording < n_recordings; ++recording)
    for (int drop = 0; drop < 20; ++drop) {
      double t_s = 10.0 * drop, interval_s = 0.2 + 1e-4 * drop;
      for (int impact = 0; impact < 25; ++impact, t_s += interval_s, interval_s *= 0.85 + 1e-3 * (recording % 50))
        text << "campaign/take " << recording << ".wav," << drop << ',' << impact << ',' << t_s << ",1e-06,\n";
    }
  return text.str();
}

class LongTables : public ProgramTest {};

TEST_F(LongTables, TakeTheMemoryOfShortOnes) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << "limits on memory cannot be tested with " << test::kSanitizer;
  // 150,000 onsets: held, they took 87 MB to convert and 160 MB to make samples of; of 2,000 as of any number the
  // commands take 20 to 50 MB
  write("o.csv", long_onsets(300));
  const std::string limited = "ulimit -d 75000 && ";
  for (const char* arguments : {"convert o.csv --to o.jsonl", "restitution o.csv --out from_csv.csv",
                                "restitution o.jsonl --out from_jsonl.csv"}) {
    const Result result = shell(limited + "\"$B\" " + arguments);
    ASSERT_EQ(result.exit_code, 0) << arguments << "\n" << result.err;
  }
  const std::string samples = content("from_csv.csv");
  EXPECT_EQ(std::count(samples.begin(), samples.end(), '\n'), 300 * 20 * 23 + 1);
  EXPECT_TRUE(content("from_jsonl.csv") == samples);
}

TEST_F(LongTables, AFaultBehindTheFirstPieceLeavesNoFile) {
  write("o.csv", long_onsets(40) + "campaign/take 39.wav,19,25,1,1e-06,\n");  // back in time, on line 20,002
  expect_one_line_error(run("restitution o.csv --out s.jsonl"), 3, {"o.csv", "line 20002", "times must increase"});
  expect_one_line_error(run("convert o.csv --to s.jsonl"), 3, {"o.csv", "line 20002"});
  EXPECT_EQ(files(), std::vector<std::string>{"o.csv"});
}

TEST_F(LongTables, StatesThatBeginBehindTheFirstPieceAreRefused) {
  std::ostringstream impacts;
  for (int k = 0; k < 17'000; ++k) {
    impacts << "{\"drop\":0,\"impact\":" << k << ",\"t_s\":" << k << ",\"v_mps\":1,\"v_after_mps\":0.9";
    if (k >= 16'384)
      for (const char* state : {"x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "vx_mps", "vy_mps", "vz_mps", "wx_radps",
                                "wy_radps", "wz_radps", "vx_after_mps", "vy_after_mps", "vz_after_mps",
                                "wx_after_radps", "wy_after_radps", "wz_after_radps"})
        impacts << ",\"" << state << "\":0.5";
    impacts << "}\n";
  }
  write("i.jsonl", impacts.str());
  expect_one_line_error(run("synthesize i.jsonl --out s.wav"), 3, {"i.jsonl", "line 16385", "in all rows or in none"});
}

TEST_F(LongTables, ARecordingNamedBehindTheFirstPieceIsNotReplaced) {
  write("o.csv", long_onsets(40) + "other.csv,0,0,1,1e-06,\n");
  write("other.csv", "0.1\n0.2\n");  // a sound as numbers
  expect_one_line_error(run("convert o.csv --to other.csv --force"), 2, {"other.csv", "is the input"});
  EXPECT_EQ(content("other.csv"), "0.1\n0.2\n");
}

}  // namespace
}  // namespace bouncelab::cli_test
