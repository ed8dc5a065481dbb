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
  // 150,000 onsets: held, they took 160 MB to make samples of; of 2,000 as of any number the command takes 20 to 50 MB
  write("o.csv", long_onsets(300));
  const std::string limited = "ulimit -d 75000 && ";
  const Result result = shell(limited + "\"$B\" restitution o.csv --out samples.csv");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ASSERT_EQ(run("convert o.csv --to copy.csv").exit_code, 0);
  const auto n_lines = [&](const std::string& name) {
    const std::string text = content(name);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(n_lines("samples.csv"), 300 * 20 * 23 + 1);
  EXPECT_EQ(n_lines("copy.csv"), n_lines("o.csv"));
}

TEST_F(LongTables, AFaultBehindTheFirstPieceLeavesNoFile) {
  write("o.csv", long_onsets(40) + "campaign/take 39.wav,19,25,1,1e-06,\n");  // back in time, on line 20,002
  expect_one_line_error(run("restitution o.csv --out s.csv"), 3, {"o.csv", "line 20002", "times must increase"});
  expect_one_line_error(run("convert o.csv --to s.csv"), 3, {"o.csv", "line 20002"});
  EXPECT_EQ(files(), std::vector<std::string>{"o.csv"});
}

TEST_F(LongTables, ARecordingNamedBehindTheFirstPieceIsNotReplaced) {
  write("o.csv", long_onsets(40) + "other.csv,0,0,1,1e-06,\n");
  write("other.csv", "0.1\n0.2\n");  // a sound as numbers
  expect_one_line_error(run("convert o.csv --to other.csv --force"), 2, {"other.csv", "is the input"});
  EXPECT_EQ(content("other.csv"), "0.1\n0.2\n");
}

}  // namespace
}  // namespace bouncelab::cli_test
