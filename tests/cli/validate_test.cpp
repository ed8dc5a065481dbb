// SPDX-License-Identifier: GPL-3.0-or-later
// `validate`: synthesized sets, recordings with their truth, marks against truth; and detectors that fail.

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using testing::HasSubstr;

class ValidateCommand : public ProgramTest {
 protected:
  const std::string kSmall = "--drops 1 --impacts 12 --asperities 1000 --rate 22050 --max-mode 10000 ";
  Json result_of(const std::string& arguments) const {
    const Result result = run("validate " + arguments + " --json");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json(result.out);
  }
  /// A recording with its truth, first/recordings/all_else.wav.
  void make_recording() const { ASSERT_EQ(run("validate --detector builtin --out first " + kSmall).exit_code, 0); }
  const std::string kOnIt = "--recordings first/recordings --truth first/recordings --out o --force ";
};

TEST_F(ValidateCommand, ScoresMarksAgainstTruth) {
  write("truth.csv", "drop,impact,t_s\n0,0,1.0\n0,1,1.5\n0,2,1.9\n");
  write("marks.txt", "1.01\n1.51\n2.5\n");
  Json score = result_of("--marks marks.txt --truth truth.csv");
  EXPECT_DOUBLE_EQ(score["recall_50ms"].number(), 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(score["precision_50ms"].number(), 2.0 / 3.0);
  EXPECT_NEAR(score["offset_s"].number(), 0.01, 1e-12);
  EXPECT_TRUE(score["pull"].is_null());
  write("marks.txt", "0.3\n1.02\n1.4\n1.52\n1.92\n2.2\n2.4\n");  // 20 ms late, one within is invented
  EXPECT_EQ(result_of("--marks marks.txt --truth truth.csv")["n_marked"], 7);
  score = result_of("--marks marks.txt --truth truth.csv --annotated-only");
  EXPECT_EQ(score["n_marked"], 4);
  EXPECT_EQ(score["recall_5ms"], 1.0);
}

TEST_F(ValidateCommand, RunsThroughEachListByItself) {
  write("set.toml", "snr_db = [40, 20]\npeak = [0.5, 0.25, 3]\n");
  const Json found = result_of("--config set.toml --detector builtin --out o " + kSmall);
  const Json& one = found["detectors"][0];
  ASSERT_EQ(one["recordings"].size(), 4U);  // 1 + 1 + 2
  EXPECT_EQ(one["recordings"][0]["recording"], "all_else");
  EXPECT_EQ(one["factors"].size(), 5U);
  for (const std::string name : {"all_else", "snr-db_20", "peak_0.25", "peak_3"}) {
    EXPECT_TRUE(exists("o/recordings/" + name + ".wav")) << name;
    EXPECT_TRUE(exists("o/marks/1/" + name + ".csv")) << name;
  }
  // 12 impacts in quiet and at 20 dB are all found; a recording half as loud is the same sound
  for (const Json& recording : one["recordings"].elements()) EXPECT_EQ(recording["score"]["f_1ms"], 1.0) << recording;
  EXPECT_THAT(content("o/report.html"), HasSubstr("Onset detectors"));
  EXPECT_THAT(content("o/scores.csv"), HasSubstr("builtin,snr-db_20,snr-db 20,"));
}

TEST_F(ValidateCommand, TakesTimesFromOutputFilesAndWhatAProgramMakesOfTheirNames) {
  make_recording();
  const std::string truth = "tail -n +2 first/recordings/all_else.truth.csv | cut -d, -f4";
  write("by_output.sh", truth + "\n");
  write("by_file.sh", "echo t_s > \"$2\"; " + truth + " >> \"$2\"\n");
  write("with_errors.sh", truth + " | sed 's/$/ 1e-6/'\n");
  write("by_name.sh", truth + " | sed 's/$/ 1e-6/' > \"$2\"\n");
  const std::vector<Json> found =
      result_of(kOnIt +
                "--detector 'sh by_output.sh {wav}' --detector \"sh 'by_file.sh' {wav} {out}\" "
                "--detector 'sh with_errors.sh {wav}' --detector 'sh by_name.sh {wav} {out}' "
                "--detector 'sh by_name.sh {wav} {out}.csv' --detector 'echo {wav} {out}'")["detectors"]
          .elements();
  ASSERT_EQ(found.size(), 6U);
  for (std::size_t d = 0; d < 5; ++d) {
    EXPECT_EQ(found[d]["recordings"][0]["failure"], "");
    EXPECT_EQ(found[d]["all"]["f_0.1ms"], 1.0) << found[d]["detector"];
    EXPECT_LT(found[d]["all"]["eps_error"].number(), 1e-9);
    EXPECT_TRUE(d < 2 || found[d]["all"]["coverage"] == 1.0) << found[d]["detector"];
  }
  EXPECT_EQ(found[5]["recordings"][0]["failure"], "the program has not written {out}");
}

TEST_F(ValidateCommand, KeepsRecordingsFromDetectorsThatOverwriteThem) {
  make_recording();
  const std::string before = content("first/recordings/all_else.wav");
  const Json found = result_of(kOnIt +
                               "--detector 'rm {wav}' "
                               "--detector \"sh -c 'echo no > \\$0; cat \\$0' {wav}\" --detector builtin");
  EXPECT_EQ(found["detectors"][0]["recordings"][0]["failure"], "");
  EXPECT_EQ(found["detectors"][1]["recordings"][0]["failure"], "'no' is no time in seconds");
  EXPECT_EQ(found["detectors"][2]["all"]["f_1ms"], 1.0);
  EXPECT_EQ(content("first/recordings/all_else.wav"), before);
  EXPECT_EQ(shell("ls -A o").out,
            "marks\nreport.html\nreport.html.meta.json\nscores.csv\nscores.csv.meta.json\n"
            "validation.json\nvalidation.json.meta.json\n");
}

TEST_F(ValidateCommand, LosesOneRecordingToADetectorThatFails) {
  make_recording();
  const auto line_of = [&](const std::string& detector) {
    const Result result = run("validate " + kOnIt + "--time-limit 1 --detector " + detector + " --detector builtin");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_THAT(result.out, HasSubstr("builtin"));
    return result.err;
  };
  EXPECT_THAT(line_of("'sleep 100 {wav}'"), HasSubstr("failed"));
  EXPECT_THAT(line_of("'sh -c \"sleep 100\" {wav}'"), HasSubstr("ended after 1 s"));
  EXPECT_THAT(line_of("'sh -c \"echo no >&2; exit 4\" {wav}'"), HasSubstr("no"));
  EXPECT_THAT(line_of("'nosuchprogram {wav}'"), HasSubstr("nosuchprogram: not found"));
  EXPECT_THAT(line_of("'echo {wav}'"), HasSubstr("is no time in seconds"));
  EXPECT_THAT(line_of("'sh -c \"echo 0,5\" {wav}'"), HasSubstr("is no time in seconds"));
  EXPECT_THAT(line_of("'sh -c \"echo 1e9\" {wav}'"), HasSubstr("1e+09 s is no time of a recording"));
  write("pipe.sh", "rm -f \"$2\"; mkfifo \"$2\"\n");
  write("huge.sh", "truncate -s 100G \"$2\"\n");
  for (const char* script : {"pipe.sh", "huge.sh"})
    EXPECT_THAT(line_of(std::string("'sh ") + script + " {wav} {out}'"), HasSubstr("{out} is no file"));
}

TEST_F(ValidateCommand, GivesAFailedDetectorNeitherSpeedNorSilenceAndEndsWhatItStarted) {
  write("set.toml", "without_ball = [false, true]\n");
  write("fails.sh", "echo 'Traceback (most recent call last):' >&2; echo 'ValueError: empty' >&2; exit 1\n");
  write("starts.sh", "sh -c 'sleep 3; touch outlived' & sleep 100\n");
  const Result result =
      run("validate --config set.toml --time-limit 1 --out o --detector 'sh fails.sh {wav}' "
          "--detector 'sh starts.sh {wav}' " +
          kSmall);
  EXPECT_EQ(result.exit_code, 1);  // none worked anywhere
  EXPECT_THAT(result.err, HasSubstr("the program failed (exit code 1): ValueError: empty"));
  EXPECT_THAT(result.out, HasSubstr("failed in 2 of 2 recordings"));
  const Json found = json("o/validation.json");
  EXPECT_TRUE(found["detectors"][0]["all"]["invented_per_hour"].is_null());
  EXPECT_TRUE(found["detectors"][0]["all"]["times_real_time"].is_null());
  ASSERT_EQ(shell("sleep 3").exit_code, 0);
  EXPECT_FALSE(exists("outlived"));
}

TEST_F(ValidateCommand, TakesSecondsAsSecondsAndMarksOfEditorsAsTruth) {
  write("unsorted.txt", "82\n10\n130\n45\n");  // neither milliseconds nor intervals
  write("labels.txt", "10.0\t10.0\tonset\n45.0\t45.0\tonset\n82.0\t82.0\tonset\n130.0\t130.0\tonset\n");
  const Json score = result_of("--marks unsorted.txt --truth labels.txt");
  EXPECT_EQ(score["f_0.1ms"], 1.0);
  EXPECT_TRUE(score["bound_s"].is_null());  // digits are no bound
}

TEST_F(ValidateCommand, FindsTheTruthOfARecordingAndNothingElse) {
  make_recording();
  ASSERT_EQ(shell("mkdir r; cp first/recordings/all_else.wav r/a.wav; cp r/a.wav r/a.b.wav; "
                  "cp first/recordings/all_else.truth.csv r/a.b.truth.csv; cp r/a.b.truth.csv r/a.others.csv")
                .exit_code,
            0);
  const std::string command = "validate --recordings r/a.wav --truth r --detector builtin --out o --force";
  expect_one_line_error(run(command), 3, {"a.truth.csv"});
  write("r/a.txt", "");  // labels of silence
  Json found = result_of("--recordings r/a.wav --truth r --detector ours=builtin --out o --force");
  EXPECT_EQ(found["detectors"][0]["detector"], "ours");
  EXPECT_EQ(found["detectors"][0]["command"], "builtin");
  EXPECT_GT(found["detectors"][0]["all"]["invented_per_hour"].number(), 0.0);
  for (const char* beyond : {"1\n1000\n", "1\n-2\n"}) {
    write("r/a.txt", beyond);
    expect_one_line_error(run(command), 3, {"a.txt: row 2: ", "not within r/a.wav", "give seconds from its begin"});
  }
  write("r/a.csv", "t_s\n1\n");
  expect_one_line_error(run(command), 3, {"may both be the truth"});
}

TEST_F(ValidateCommand, VariesTheSeedAndWritesEachRecordingsOwnValues) {
  write("set.toml", "seed = [1, 2]\nsnr_db = [40, 30]\n");
  ASSERT_EQ(run("validate --config set.toml --detector builtin --out o " + kSmall).exit_code, 0);
  EXPECT_NE(content("o/recordings/all_else.truth.csv"), content("o/recordings/seed_2.truth.csv"));
  EXPECT_THAT(content("o/recordings/snr-db_30.wav.meta.json"), HasSubstr("\"snr-db\": \"30\""));
}

TEST_F(ValidateCommand, TakesWhatStandsBeforeTheFirstEqualsSignForANameOnlyWhereItIsOne) {
  make_recording();
  write("a.sh", "echo 1\n");
  const std::vector<Json> found =
      result_of(kOnIt +
                "--detector '2nd-try_1.0+=sh a.sh --x=3 {wav}' --detector 'sh a.sh --x=3 {wav}' "
                "--detector 'env X=3 sh a.sh {wav}' --detector 'sh a.sh {wav} x=3'")["detectors"]
          .elements();
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0]["detector"], "2nd-try_1.0+");
  EXPECT_EQ(found[0]["command"], "sh a.sh --x=3 {wav}");
  for (const Json& one : found) EXPECT_EQ(one["recordings"][0]["failure"], "") << one["detector"];
  for (const char* name : {"my own", "it\"s", "Prüfung", "a/b", ""})
    expect_refused("validate " + kOnIt + "--detector '" + name + "=sh a.sh {wav}'", 2, {"a name?", "NAME='COMMAND'"});
  for (const char* word : {"\"{wav}\"", "{wav} \"{out}.csv\""})
    expect_refused("validate " + kOnIt + "--detector 'sh a.sh " + word + "'", 2, {"leave the quotes around {"});
}

TEST_F(ValidateCommand, AsksForSecondsWhereTimesAreOfAnotherUnit) {
  write("truth.csv", "t_s\n1\n1.5\n1.9\n");
  write("ms.txt", "1001\n1501\n1901\n");
  write("samples.txt", "48000\n72000\n");
  expect_one_line_error(run("validate --marks ms.txt --truth truth.csv"), 2, {"ms.txt", "1 to 1.9 s; milliseconds?"});
  expect_one_line_error(run("validate --marks truth.csv --truth ms.txt"), 2, {"ms.txt", "which are milliseconds?"});
  const Result result = run("validate --marks samples.txt --truth truth.csv");
  expect_one_line_error(result, 2, {"samples.txt", "1 to 1.9 s"});
  EXPECT_THAT(result.err, Not(HasSubstr("milliseconds")));
  make_recording();
  write("ms.sh", "echo 1000; echo 1500\n");
  const Json found = result_of(kOnIt + "--detector 'sh ms.sh {wav}' --detector builtin");
  EXPECT_THAT(found["detectors"][0]["recordings"][0]["failure"].text(), HasSubstr("; milliseconds?"));
}

TEST_F(ValidateCommand, WarnsOfStandardErrorsThatAreNone) {
  write("truth.csv", "t_s\n1\n1.5\n1.9\n");
  write("marks.txt", "1 1e-6\n1.5 0\n1.9 -1\n");
  const Result result = run("validate --marks marks.txt --truth truth.csv");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("marks.txt: 2 of 3 standard errors are not above 0; they are not scored"));
  EXPECT_THAT(result.out, AllOf(HasSubstr("3/3"), HasSubstr("CPU s\n"), HasSubstr("-\n")));
}

TEST_F(ValidateCommand, NamesACommandThatCanBeTypedWhereATableDoesNotProveWhatItHolds) {
  write("truth.csv", "t_s\n.4\n1\n1.51\n");
  write("t.csv", "time,e\n400,1\n1000,1\n1510,2\n");
  const Result asked = run("validate --marks t.csv --truth truth.csv");
  EXPECT_EQ(asked.exit_code, 2);
  const std::string remedy = "convert t.csv --as times --unit ms --columns t=time --to t.csv.times.csv";
  EXPECT_THAT(asked.err, HasSubstr(": bouncelab " + remedy + "\n"));
  EXPECT_EQ(run(remedy).exit_code, 0);
  EXPECT_EQ(result_of("--marks t.csv.times.csv --truth truth.csv")["f_0.1ms"], 1.0);
}

TEST_F(ValidateCommand, RefusesWhatCannotWork) {
  write("truth.csv", "t_s\n1\n");
  write("list.toml", "time_limit = [1, 2]\n");
  write("far.toml", "snr_db = [40, 1000]\n");
  for (const auto& [arguments, word] : std::vector<std::pair<std::string, std::string>>{
           {"--out o --detector 'sh it'", "{wav}"},
           {"--out o --detector it=builtin --detector 'it=sh it {wav}'", "another one has this name"},
           {"--out o --shell --detector 'sh {wav}'", "the shell runs all detectors"},
           {"--out o", "--detector"},
           {"--marks truth.csv", "--truth"},
           {"--marks truth.csv --truth truth.csv --drops 3", "--drops has no effect"},
           {"--truth truth.csv --detector builtin --out o", "--truth belongs"},
           {"--annotated-only --detector builtin --out o", "--annotated-only belongs"},
           {"--config list.toml --detector builtin --out o", "not a list"},
           {"--config far.toml --detector builtin --out o", "snr-db"}})
    expect_refused("validate " + arguments, 2, {word});
}

}  // namespace
}  // namespace bouncelab::cli_test
