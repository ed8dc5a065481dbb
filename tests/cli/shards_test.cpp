// SPDX-License-Identifier: GPL-3.0-or-later
// A run in parts gives the bytes of the run in one piece, whatever the number of parts and however often they were
// killed.
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using testing::HasSubstr;

class Shards : public ProgramTest {
 protected:
  void must(const std::string& arguments) const {
    const Result result = run(arguments + " --quiet");
    ASSERT_EQ(result.exit_code, 0) << arguments << "\n" << result.err;
  }
  /// All parts of a run, the last one first, and their merge.
  void run_in_parts(const std::string& command, const std::string& out, int n) const {
    for (int k = n; k > 0; --k)
      must(command + " --out " + out + " --shard " + std::to_string(k) + "/" + std::to_string(n));
    must("merge " + out + ".parts");
  }
  void expect_same(const std::string& a, const std::string& b) const {
    ASSERT_TRUE(fs::exists(folder_ / a)) << a;
    ASSERT_TRUE(fs::exists(folder_ / b)) << b;
    EXPECT_EQ(content_of(folder_ / a) == content_of(folder_ / b), true) << a << " and " << b;
  }
  /// Six recordings of one to four bounces' drops, silence, no sound at all, and one that is there twice.
  void write_recordings() const {
    must("simulate --drops 6 --impacts 12 --asperities 20000 --out drops.csv");
    must("synthesize drops.csv --each-drop --rate 44100 --out rec.wav");
    fs::copy_file(folder_ / "rec.0001.wav", folder_ / "again.wav");
    write("text.wav", "this is no sound");
    write("list.txt", "rec.0002.wav\nrec.0003.wav\r\n\nagain.wav\nrec.0004.wav\nrec.0005.wav\n");
  }
};

TEST_F(Shards, OfRecordingsGiveTheBytesOfOneRunForAnyNumberOfThem) {
  write_recordings();
  const std::string recordings = "detect rec.0000.wav rec.0001.wav text.wav --list list.txt";
  const Result plain = run(recordings + " --out plain.csv");
  EXPECT_EQ(plain.exit_code, 3);  // the text is no recording: it costs itself
  for (const int n : {1, 3, 8}) {
    const std::string out = "n" + std::to_string(n) + ".csv";
    for (int k = n; k > 0; --k)
      must(recordings + " --out " + out + " --shard " + std::to_string(k) + "/" + std::to_string(n));
    const Result merged = run("merge " + out + ".parts");
    EXPECT_EQ(merged.exit_code, 3);
    EXPECT_EQ(merged.err, plain.err);
    EXPECT_EQ(merged.out, plain.out);
    expect_same(out, "plain.csv");
  }
}

TEST_F(Shards, OfAnalyzeGiveItsWholeFolder) {
  write_recordings();
  const std::string command = "analyze --list list.txt rec.0000.wav rec.0001.wav --ball steel:6mm --diagnostics";
  must(command + " --out plain");
  run_in_parts(command, "parts", 2);
  for (const char* file : {"onsets.csv", "samples.csv", "fit.json", "wave.json", "diagnostics.json"})
    expect_same(std::string("plain/") + file, std::string("parts/") + file);
}

TEST_F(Shards, OfASimulationGiveImpactsAndSurface) {
  const std::string command = "simulate --drops 7 --impacts 9 --asperities 5000 --state --drag";
  must(command + " --out plain.csv --write-surface plain_surface.csv");
  run_in_parts(command + " --write-surface surface.csv", "parts.csv", 3);
  expect_same("plain.csv", "parts.csv");
  expect_same("plain_surface.csv", "surface.csv");
}

TEST_F(Shards, OfASynthesisWriteTheRecordingsAndTheirTruthInOneTable) {
  must("simulate --drops 5 --impacts 12 --asperities 5000 --out drops.csv");
  const std::string command = "synthesize drops.csv --each-drop --rate 44100 --knocks 2";
  must(command + " --out rec.wav");
  fs::create_directory(folder_ / "plain");
  shell("mv rec.* plain");
  run_in_parts(command, "rec.wav", 2);
  for (const char* file :
       {"rec.0000.wav", "rec.0000.others.csv", "rec.0003.wav", "rec.0004.wav", "rec.0004.others.csv", "rec.truth.csv"})
    expect_same(std::string("plain/") + file, file);
}

TEST_F(Shards, OfASweepGiveItsTable) {
  write("sweep.toml", "drops = 2\nimpacts = 12\nasperities = 5000\nrate = 44100\nsnr_db = [20, 30, 40]\n");
  must("loop --config sweep.toml --out plain");
  run_in_parts("loop --config sweep.toml", "parts", 2);
  expect_same("plain/sweep.csv", "parts/sweep.csv");
  expect_same("plain/sweep.json", "parts/sweep.json");
}

TEST_F(Shards, OfThePapersLoopGiveItsTablesAndFits) {
  const std::string command = "loop --preset paper --drops 42 --impacts 12 --asperities 5000 --rate 44100";
  must(command + " --out plain");
  run_in_parts(command, "parts", 3);
  for (const char* file : {"impacts.csv", "truth.csv", "onsets.csv", "samples.csv", "fit.json", "fit_smooth_ball.json",
                           "fit_from_simulation.json", "paper.json"})
    expect_same(std::string("plain/") + file, std::string("parts/") + file);
}

TEST_F(Shards, OfCalibrationsSayWhatOneRunSays) {
  const std::string seeds = "calibrate --seeds 3 --samples 100 --covariance-intervals";
  const Result plain = run(seeds + " --json --quiet");
  for (const char* shard : {"1/2", "2/2"}) must(seeds + " --shard " + shard);
  EXPECT_EQ(run("merge calibration.parts --json --quiet").out, plain.out);

  const std::string experiments = "calibrate --memory --experiments 2 --drops 5,5 --impacts 12";
  // so few impacts give no fit, which is a result too
  EXPECT_EQ(run(experiments + " --out plain.csv").exit_code, 1);
  for (const char* shard : {"1/2", "2/2"}) must(experiments + " --out parts.csv --shard " + shard);
  EXPECT_EQ(run("merge parts.csv.parts").exit_code, 1);
  expect_same("plain.csv", "parts.csv");
}

TEST_F(Shards, OfABootstrapGiveItsErrors) {
  must("simulate --drops 9 --impacts 12 --asperities 5000 --out drops.csv");
  must("restitution drops.csv --out samples.csv");
  const std::string command = "fit samples.csv --bootstrap 6 --method least-squares --law-kind constant";
  must(command + " --out plain.json");
  run_in_parts(command, "parts.json", 4);
  expect_same("plain.json", "parts.json");
  EXPECT_THAT(content_of(folder_ / "plain.json"), HasSubstr("\"bootstrap\": {"));
  expect_one_line_error(run("fit samples.csv --out a.json --shard 1/2"), 2, {"--shard", "--bootstrap"});
}

TEST_F(Shards, KilledAnywhereGoOnWithWhatIsMissing) {
  const std::string command = "simulate --drops 4 --impacts 9 --asperities 5000";
  must(command + " --out plain.csv");
  must(command + " --out parts.csv --shard 1/1");
  const fs::path part = folder_ / "parts.csv.parts/shard-1-of-1.part";
  const fs::path unfinished = folder_ / "parts.csv.parts/shard-1-of-1.unfinished";
  const std::string whole = content_of(part);
  for (const double share : {0.0, 0.3, 0.7, 0.99}) {  // as if it had been killed there
    fs::remove(part);
    write("parts.csv.parts/shard-1-of-1.unfinished",
          whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
    must(command + " --out parts.csv --shard 1/1");
    EXPECT_FALSE(fs::exists(unfinished));
    must("merge parts.csv.parts --force");
    expect_same("plain.csv", "parts.csv");
  }
}

TEST_F(Shards, DoAgainOnlyWhatChanged) {
  write_recordings();
  const std::string command = "detect rec.0000.wav rec.0001.wav rec.0002.wav --out onsets.csv --shard 1/1";
  must(command);
  const auto done_before = [&] { return nlohmann::json::parse(run(command + " --json").out)["n_done_before"]; };
  EXPECT_EQ(done_before(), 3);
  fs::last_write_time(folder_ / "rec.0001.wav", fs::file_time_type::clock::now());
  EXPECT_EQ(done_before(), 3);  // another time, the same content
  fs::copy_file(folder_ / "rec.0003.wav", folder_ / "rec.0001.wav", fs::copy_options::overwrite_existing);
  expect_one_line_error(run("merge onsets.csv.parts"), 2, {"rec.0001.wav", "changed", "again"});
  EXPECT_EQ(done_before(), 2);
  must("merge onsets.csv.parts");
  must("detect rec.0000.wav rec.0001.wav rec.0002.wav --out plain.csv");
  expect_same("plain.csv", "onsets.csv");
}

TEST_F(Shards, TakeOverWhatOthersDidWhereTheRecordingsAreOthersThanBefore) {
  write_recordings();
  write("names.txt", "rec.0000.wav\nrec.0001.wav\nrec.0002.wav\nrec.0003.wav\n");
  const std::string command = "detect --list names.txt --out onsets.csv --shard ";
  for (const char* shard : {"1/2", "2/2"}) must(command + shard);
  // the first went, one came: every recording but the new one has a record, in the part of the other shard
  write("names.txt", "rec.0001.wav\nrec.0002.wav\nrec.0003.wav\nrec.0004.wav\n");
  const auto n_done_before = [&](const char* shard) {
    return nlohmann::json::parse(run(command + shard + " --json").out)["n_done_before"];
  };
  EXPECT_EQ(n_done_before("1/2"), 2);
  EXPECT_EQ(n_done_before("2/2"), 1);
  must("merge onsets.csv.parts");
  must("detect --list names.txt --out plain.csv");
  expect_same("plain.csv", "onsets.csv");
}

TEST_F(Shards, ThatAreMissingAreNamed) {
  const std::string command = "simulate --drops 9 --impacts 3 --asperities 1000 --out parts.csv --shard ";
  for (const char* shard : {"1/4", "4/4"}) must(command + shard);
  expect_one_line_error(run("merge parts.csv.parts"), 2, {"4 of 9 items", "shards 2, 3 of 4", "again"});
  EXPECT_FALSE(fs::exists(folder_ / "parts.csv"));
}

TEST_F(Shards, OfAnotherRunAreRefusedByWhatDiffers) {
  const std::string command = "simulate --drops 2 --impacts 3 --asperities 1000 --out parts.csv --shard ";
  must(command + "1/2");
  must(command + "2/2 --out others.csv --seed 7");
  expect_one_line_error(run("merge parts.csv.parts others.csv.parts"), 2, {"another run", "seed was 1, now 7"});
  expect_one_line_error(run(command + "1/2 --seed 3"), 2, {"seed was 1, now 3", "--force"});
}

TEST_F(Shards, AreMergedFromAnyFolder) {
  must("simulate --drops 2 --impacts 3 --asperities 1000 --out parts.csv --shard 1/1");
  const Result merged =
      shell("mkdir elsewhere && cd elsewhere && \"$B\" merge ../parts.csv.parts --out here.csv --quiet");
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  must("simulate --drops 2 --impacts 3 --asperities 1000 --out plain.csv");
  expect_same("plain.csv", "elsewhere/here.csv");
}

TEST_F(Shards, AreNumbersWithinTheirNumber) {
  for (const char* shard : {"0/3", "4/3", "3", "1/0", "a/b", "1/3x", "-1/3", "1/99999999999"})
    expect_one_line_error(run(std::string("simulate --out a.csv --shard ") + shard), 2, {"--shard", "3/8"});
  expect_one_line_error(run("merge nothing"), 3, {"nothing"});
  write("no.part", "no part");
  expect_one_line_error(run("merge no.part"), 3, {"no.part", "not a part of a run"});
  expect_one_line_error(run("loop --out a --shard 1/2"), 2, {"--shard", "paper"});
  expect_one_line_error(shell("\"$B\" detect - --out a.csv --shard 1/2 < /dev/null"), 2, {"standard input"});
}

}  // namespace
}  // namespace bouncelab::cli_test
