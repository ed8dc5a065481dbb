// SPDX-License-Identifier: GPL-3.0-or-later
// Tables longer than the memory.
#include <iomanip>

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
  const std::string samples = content_of(folder_ / "from_csv.csv");
  EXPECT_EQ(std::count(samples.begin(), samples.end(), '\n'), 300 * 20 * 23 + 1);
  EXPECT_TRUE(content_of(folder_ / "from_jsonl.csv") == samples);
}

TEST_F(LongTables, OfMarksTakeTenTimesTheirSize) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << "limits on memory cannot be tested with " << test::kSanitizer;
  std::ostringstream labels;
  labels << std::fixed << std::setprecision(6);
  constexpr int kMarks = 400'000;
  for (int k = 0; k < kMarks; ++k) {  // drops of 20 impacts
    const double t_s = 100.0 + 0.2 * k + 2.0 * (k / 20);
    labels << t_s << '\t' << t_s << "\tm" << k % 1000 << '\n';
  }
  write("marks.txt", labels.str());
  // and 20 MB for the program itself
  const std::size_t most_kb = 20'000 + 10 * labels.str().size() / 1000;
  const Result result = shell("ulimit -d " + std::to_string(most_kb) + " && \"$B\" restitution marks.txt --out s.csv");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("from " + std::to_string(kMarks) + " onsets"), std::string::npos) << result.out;
}

TEST_F(LongTables, AreTheSameFileAfterEveryWayThroughTheFormats) {
  write("o.csv", long_onsets(40));  // 20,000 rows: more than a piece
  ASSERT_EQ(run("convert o.csv --to a.csv a.jsonl").exit_code, 0);
  ASSERT_EQ(run("convert a.jsonl --to b.csv").exit_code, 0);
  ASSERT_EQ(run("convert a.csv --to b.jsonl").exit_code, 0);
  for (const char* ext : {".csv", ".jsonl"})
    EXPECT_TRUE(content_of(folder_ / (std::string("a") + ext)) == content_of(folder_ / (std::string("b") + ext)))
        << ext;
}

TEST_F(LongTables, AFaultBehindTheFirstPieceLeavesNoFile) {
  write("o.csv", long_onsets(40) + "campaign/take 39.wav,19,25,1,1e-06,\n");  // back in time, on line 20,002
  expect_one_line_error(run("restitution o.csv --out s.jsonl"), 3, {"o.csv", "line 20002", "times must increase"});
  expect_one_line_error(run("convert o.csv --to s.jsonl"), 3, {"o.csv", "line 20002"});
  EXPECT_EQ(files(), std::vector<std::string>{"o.csv"});
}

TEST_F(LongTables, AFullDiskCostsOneLine) {
  const std::string on_disk = "unshare -m sh -c 'mount -t tmpfs -o size='$size' none disk && exec \"$0\" \"$@\"' ";
  fs::create_directory(folder_ / "disk");
  if (shell("size=1m; " + on_disk + "true").exit_code != 0) GTEST_SKIP() << "no file system can be mounted here";
  write("o.csv", long_onsets(40));
  for (const char* size : {"4k", "200k", "700k", "1000k"}) {  // of the 1.1 MB that it takes
    const Result result =
        shell("size=" + std::string(size) + "; " + on_disk + "\"$B\" restitution o.csv --out disk/s.jsonl");
    SCOPED_TRACE(size);
    expect_one_line_error(result, 3, {"disk/s.jsonl", "No space left"});
  }
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
  EXPECT_EQ(content_of(folder_ / "other.csv"), "0.1\n0.2\n");
}

}  // namespace
}  // namespace bouncelab::cli_test
