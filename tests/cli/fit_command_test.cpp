// SPDX-License-Identifier: GPL-3.0-or-later
// `restitution` and `fit` by hand and with bad samples.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "bouncelab/core/random.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

class FitCommand : public ProgramTest {
 protected:
  /// Samples of the paper's law with a scatter that is the same in every run. One speed where lo = hi.
  std::string table(int n, double lo, double hi, double shift = 0.0, const std::string& sigma = "1e-4") const {
    std::string text = "drop,impact,v_mps,eps,sigma_eps\n";
    for (int k = 0; k < n; ++k) {
      const double v = lo * std::pow(hi / lo, (k + 0.5) / n);
      const double u = std::fmod(0.5 + 0.6180339887498949 * (k + 1), 1.0);
      const double scatter = (u < 0.5 ? std::log(2.0 * u) : -std::log(2.0 * (1.0 - u))) * 4e-4 / v;
      const double eps = 1.0 - 1.153448858 * 0.0467 * std::pow(v, 0.2) + 0.798266561 * 0.1339 * std::pow(v, 0.4) -
                         0.2876 * 4.0 / 15.0 * std::sqrt(v);
      text += std::to_string(k / 95) + "," + std::to_string(k % 95) + "," + number(v) + "," +
              number(eps + scatter + shift) + "," + sigma + "\n";
    }
    return text;
  }
  static std::string number(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%.12g", x);
    return text;
  }
  Result fit(const std::string& samples, const std::string& more = "") {
    write("s.csv", samples);
    // these samples remember nothing: the fit with memory, which long drops ask for, would look for it long
    return run("fit s.csv --out f.json --force --goodness-replicates 19 --method asymmetric-laplace " + more);
  }
  Json found() const { return json("f.json"); }
};

TEST_F(FitCommand, OfTwoSamplesCannotTellAChangeAndOfOneSpeedGivesOneValue) {
  Result result = fit(table(2, 0.2, 1.4));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::StartsWith("ε = 0.9"));
  EXPECT_THAT(result.out, testing::HasSubstr("whether ε changes between "));
  EXPECT_EQ(found()["constants"]["status"], "too_few_samples");
  result = fit(table(500, 0.5, 0.5));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr(" at 0.5 m/s"));
  EXPECT_EQ(found()["answer"]["one_value"], true);
  EXPECT_EQ(found()["curve"]["points"].size(), 0U);
  const double truth = 1.0 - 1.153448858 * 0.0467 * std::pow(0.5, 0.2) + 0.798266561 * 0.1339 * std::pow(0.5, 0.4) -
                       0.2876 * 4.0 / 15.0 * std::sqrt(0.5);
  // scatter of 8e-4 sqrt(2), of 500; its square is nothing to the mean's
  EXPECT_NEAR(found()["answer"]["at"]["eps"].number(), truth, 4.0 * 1.13e-3 / std::sqrt(500.0));
}

TEST_F(FitCommand, WhatIsOddInTheSamplesIsSaid) {
  std::string samples = table(2000, 0.2, 1.4, 0.0, "0");
  samples += "99,0,nan,0.98,1e-4\n99,1,0.5,,1e-4\n99,2,0,0.98,1e-4\n";  // a drop of its own
  const Result odd = fit(samples);
  EXPECT_EQ(odd.exit_code, 0) << odd.err;
  EXPECT_THAT(odd.err, testing::HasSubstr("2 samples are left out (a number is not finite); check sample 2001"));
  EXPECT_THAT(odd.err, testing::HasSubstr("1 sample is left out (the speed is below 1e-6 m/s); check sample 2003"));
  EXPECT_THAT(found()["notes"].dump(), testing::HasSubstr("2000 of 2000 samples state no timing error"));
  EXPECT_EQ(found()["n_left_out"]["not_finite"], 2);
  EXPECT_EQ(found()["n_used"], 2000);
  std::string equal = "v_mps,eps\n";
  for (int k = 0; k < 50; ++k) equal += number(0.3 + 0.02 * k) + ",0.9000000000\n";
  EXPECT_EQ(fit(equal).exit_code, 0);
  EXPECT_EQ(found()["n_used"], 50) << "of exactly one coefficient none is an outlier";
  const Result above = fit(table(2000, 0.2, 1.4, 0.1));
  EXPECT_THAT(above.err, testing::HasSubstr("2000 of 2000 samples have ε below 0 or above 1"));
  EXPECT_GT(found()["curve"]["nodes"][0]["eps"].number(), 1.05);
  const Result below = fit(table(2000, 200.0, 1400.0, -5.0));
  EXPECT_THAT(below.err, testing::HasSubstr("2000 of 2000 samples have ε below 0 or above 1"));
  EXPECT_THAT(below.err, testing::HasSubstr("not between 0.005 and 20 m/s"));
}

TEST_F(FitCommand, WhatIsAskedForIsInTheResult) {
  const Result result = fit(table(3000, 0.2, 1.4), "--table law.csv");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(found()["goodness"]["anderson_darling"]["n_replicates"], 19);
  std::istringstream csv(content("law.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "v_mps,eps,lo95,hi95");
  for (const Json& point : found()["curve"]["points"].elements()) {
    ASSERT_TRUE(std::getline(csv, line));
    EXPECT_DOUBLE_EQ(std::stod(line.substr(line.find(',') + 1)), point["eps"].number()) << line;
  }
  EXPECT_EQ(fit(table(2000, 0.2, 1.4), "--law-kind viscoelastic").exit_code, 0);
  EXPECT_GT(found()["misfit"]["ln_bayes_factor"].number(), 3.0);  // these bounces follow a series
  // of a constant that was asked for too few bounces are no reason
  const Result constant = fit(table(80, 0.3, 1.2), "--law-kind constant");
  for (const std::string& text : {constant.out, constant.err, found().dump()})
    EXPECT_THAT(text, testing::Not(testing::HasSubstr("too few bounces")));
}

TEST_F(FitCommand, OfTwoFilesIsThatOfOneFileWithAColumnRecording) {
  const std::string a = table(190, 0.2, 1.4), b = table(285, 0.25, 1.3);
  write("a.csv", a);
  write("b.csv", b);
  std::string both = "recording,drop,impact,v_mps,eps,sigma_eps\n";
  for (const auto& [name, rows] : {std::pair{"a.csv", a}, std::pair{"b.csv", b}}) {
    std::istringstream lines(rows.substr(rows.find('\n') + 1));
    for (std::string line; std::getline(lines, line);) both += std::string(name) + "," + line + "\n";
  }
  const Result two = run("fit a.csv b.csv --out two.json --goodness-replicates 0 --method asymmetric-laplace");
  fit(both, "--goodness-replicates 0");
  EXPECT_EQ(content("two.json"), content("f.json"));
  EXPECT_THAT(two.out, testing::HasSubstr("the 2 recordings agree (p = "));
  EXPECT_THAT(two.out, testing::HasSubstr("a.csv: ε = "));
  EXPECT_EQ(found()["recordings"][1]["recording"], "b.csv");
  EXPECT_EQ(found()["recordings"][1]["n"], 285);
  EXPECT_THAT(content("two.json.meta.json"), testing::HasSubstr("b.csv"));
}

/// Lines of what fit prints: how many, and characters of the longest (bytes that begin one).
std::pair<std::ptrdiff_t, std::ptrdiff_t> extent(const std::string& text) {
  std::istringstream lines(text);
  std::ptrdiff_t n = 0, longest = 0;
  for (std::string line; std::getline(lines, line); ++n)
    longest = std::max<std::ptrdiff_t>(longest, std::count_if(line.begin(), line.end(), [](char c) {
                                         return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
                                       }));
  return {n, longest};
}

TEST_F(FitCommand, PrintsTwelveLinesOfAHundredCharactersAtMostAndMakesItsFolder) {
  const auto expect_short = [](const Result& result) {
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const auto [n, longest] = extent(result.out);
    EXPECT_LE(n, 12) << result.out;
    EXPECT_LE(longest, 100) << result.out;
  };
  write("s.csv", table(1500, 0.2, 1.4));
  const Result one = run("fit s.csv --out new/folder/fit.json --goodness-replicates 0 --method asymmetric-laplace");
  expect_short(one);
  EXPECT_TRUE(exists("new/folder/fit.json.meta.json"));
  EXPECT_THAT(one.out, testing::HasSubstr("Constants of the law: A2 = 0."));
  EXPECT_THAT(one.out, testing::HasSubstr("new/folder/fit.json; figures: bouncelab report new/folder\n"));
  write("s.csv", table(20, 0.2, 1.4));
  expect_short(run("fit s.csv --out few.json"));
  std::string files;
  for (int k = 0; k < 9; ++k) {
    const std::string name =
        "a_recording_with_a_name_that_is_long_as_those_of_phones_are_" + std::to_string(k) + ".csv";
    write(name, table(60 + k, 0.2, 1.4, -0.02 * k));
    files += name + " ";
  }
  const Result several = run("fit " + files + "--out several.json --goodness-replicates 0");
  expect_short(several);
  EXPECT_THAT(several.out, testing::HasSubstr("Each alone:\n  a_recording_"));
  expect_one_line_error(run("fit s.csv --out s.csv/f.json"), 3, {"s.csv/f.json", "no folder", "choose another"});
}

TEST_F(FitCommand, ShowsItsProgressOnATerminalWhileAStepIsLong) {
  if (shell("command -v script").exit_code != 0) GTEST_SKIP() << "no script, which runs a program on a terminal";
  write("s.csv", table(3000, 0.2, 1.4));
  const Result shown = shell("script -qec \"$B fit s.csv --out f.json --method asymmetric-laplace\" /dev/null");
  EXPECT_THAT(shown.out, testing::HasSubstr("\r\033[Kfit: "));
  EXPECT_THAT(shown.out, testing::HasSubstr("of 5 fits, "));
  EXPECT_THAT(run("fit s.csv --out f.json --force --goodness-replicates 0 --method asymmetric-laplace").err,
              testing::Not(testing::HasSubstr("fits")));
}

TEST_F(FitCommand, OfPlatesHasConstantsAndSlopesOfEach) {
  std::string samples = "recording,drop,impact,v_mps,eps,sigma_eps\n";
  for (int k = 0; k < 4; ++k) {
    std::istringstream lines(table(450 + k, 0.2, 1.4, k % 2 == 0 ? 0.0 : -0.02));
    std::string line;
    for (std::getline(lines, line); std::getline(lines, line);) samples += "r" + std::to_string(k) + "," + line + "\n";
  }
  write("s.csv", samples);
  write("plates.csv", "recording,plate\nr0,glass\nr1,wood\nr2,glass\nr3,wood\n");
  const std::string fit = "fit s.csv --goodness-replicates 0 --method asymmetric-laplace --out f.json ";
  const Result result = run(fit + "--groups plates.csv --slopes slopes.csv");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::StartsWith("The 2 plates differ by more than chance"));
  const auto rows = found()["recordings"];
  ASSERT_EQ(rows.size(), 2u);
  for (std::size_t p = 0; p < 2; ++p) {
    const auto& row = rows[p];
    EXPECT_EQ(row["recording"], p == 0 ? "glass" : "wood");
    EXPECT_EQ(row["n_drops"], 10);  // of two recordings, each of 4 drops of 95 impacts and of a short one
    EXPECT_TRUE(row.contains("A2"));
    EXPECT_EQ(row["slopes"].size(), 8u);
    // the scatter is 4e-4 / v to both sides
    const auto& slope = row["slopes"][3]["slope_rising"];
    EXPECT_NEAR(slope["value"].number(), row["slopes"][3]["v_mps"].number() / 4e-4, 4.0 * slope["se"].number());
  }
  const std::string table = content("slopes.csv");
  EXPECT_THAT(table, testing::StartsWith("recording,v_mps,v_lo_mps,v_hi_mps,n,peak_eps,sigma_peak_eps,"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 2 * 8);
  EXPECT_THAT(table, testing::HasSubstr("\nwood,0.3,0.25,0.35,"));
  EXPECT_THAT(content("f.json.meta.json"), testing::HasSubstr("plates.csv"));
  // of one ball those of all come first
  ASSERT_EQ(run(fit + "--force --pool --slopes all.csv").exit_code, 0);
  EXPECT_THAT(content("all.csv"), testing::HasSubstr("_hi95\n,0.3,"));
  write("dates.csv", "recording,date\nr0,2026-11-23\n");
  expect_one_line_error(run(fit + "--groups dates.csv --force"), 3, {"dates.csv", "names no plate", "--groups"});
  write("other.csv", "recording,plate\nr0,glass\nr1,glass\nr7,wood\n");
  const Result partly = run(fit + "--groups other.csv --force");
  EXPECT_THAT(partly.err, testing::HasSubstr("2 of the 4 recordings ('r2', 'r3') have no row in other.csv"));
  EXPECT_EQ(found()["recordings"].size(), 3u);
}

TEST_F(FitCommand, RecordingsOfAPlateThatDifferAreSaidAndCount) {
  constexpr double kOfBounces = 1.5e-3, kOfRecordings = 3e-3;
  std::string samples = "recording,drop,v_mps,eps\n", plates = "recording,plate\n";
  for (int k = 0; k < 12; ++k) {  // two equal plates; recordings of one of them differ
    Random random(21, RandomStream::test, static_cast<std::uint64_t>(k));
    const bool differs = k % 2 == 1;
    const double offset = differs ? kOfRecordings * random.normal() : 0.0;
    const std::string name = "r" + std::to_string(k);
    plates += name + (differs ? ",wood\n" : ",glass\n");
    for (int i = 0; i < 80; ++i)
      samples += name + "," + std::to_string(i / 20) + "," + std::to_string(random.uniform(0.3, 2.0)) + "," +
                 std::to_string(0.85 + offset + kOfBounces * random.normal()) + "\n";
  }
  write("s.csv", samples);
  write("plates.csv", plates);
  const Result result = run("fit s.csv --groups plates.csv --out fit.json --goodness-replicates 0");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out + result.err, testing::HasSubstr("wood: the 6 recordings differ by more than chance"));
  EXPECT_THAT(result.out + result.err, testing::Not(testing::HasSubstr("glass: the 6")));
  const auto fit = json("fit.json");
  EXPECT_EQ(fit["recordings_test"]["within"], "recordings");
  EXPECT_GT(fit["recordings_test"]["p_value"].number(), 0.01);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto& row = fit["recordings"][k];
    // 480 samples scatter by 7e-5 together, six recordings of wood by 1.2e-3
    const double expected = row["recording"] == "wood" ? kOfRecordings / std::sqrt(6.0) : kOfBounces / std::sqrt(480.0);
    EXPECT_NEAR(std::log(row["nodes"][row["nodes"].size() / 2]["se"].number() / expected), 0.0, std::log(2.5));
  }
}

TEST_F(FitCommand, ACurveThatBelongsToNoBallIsNotWrittenAndThatIsSaid) {
  std::string samples = "recording,drop,v_mps,eps\n";
  for (int k = 0; k < 200; ++k)
    samples += std::string(k < 100 ? "a" : "b") + "," + std::to_string(k / 50) + "," +
               std::to_string(0.3 + 0.02 * (k % 50)) + "," +
               std::to_string(0.9 - (k < 100 ? 0.0 : 0.05) + 0.002 * std::fmod(0.618 * k, 1.0)) + "\n";
  write("law.csv", "of an earlier run");
  const Result result = fit(samples, "--table law.csv");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, testing::HasSubstr("law.csv is not written: the recordings or drops differ"));
  EXPECT_FALSE(exists("law.csv"));
  EXPECT_EQ(fit(samples, "--table law.csv --pool").exit_code, 0);
  EXPECT_TRUE(exists("law.csv"));
}

TEST_F(FitCommand, FilesOfTheSameNameOrWithTheSameDropAreRecordingsOfTheirOwn) {
  fs::create_directories(folder_ / "x");
  fs::create_directories(folder_ / "y");
  write("x/s.csv", table(95, 0.2, 1.4));
  write("y/s.csv", table(96, 0.2, 1.4));
  run("fit x/s.csv y/s.csv --out f.json --quiet --goodness-replicates 0");
  EXPECT_EQ(found()["recordings"][0]["recording"], "x/s.csv");
  EXPECT_EQ(found()["recordings"][1]["recording"], "y/s.csv");
  const std::string few = "recording,drop,v_mps,eps\ndrop.wav,0,1,0.9\ndrop.wav,0,0.9,0.9\ndrop.wav,0,0.8,";
  write("x/s.csv", few + "0.91\n");
  write("y/s.csv", few + "0.92\n");
  const Result result = run("fit x/s.csv y/s.csv --out f.json --force --goodness-replicates 0");
  EXPECT_THAT(result.err, testing::HasSubstr("y/s.csv: the names of 1 recording are in another file too"));
  EXPECT_EQ(found()["recordings"][1]["recording"], "drop.wav (y/s.csv)");
}

/// Onsets of one drop of constant eps.
std::string onsets(int n) {
  std::string text = "drop,impact,t_s,sigma_t_s\n";
  double t = 0.1, interval = 0.27;
  for (int k = 0; k < n; ++k) {
    char line[80];
    std::snprintf(line, sizeof line, "0,%d,%.12f,1e-6\n", k, t);
    text += line;
    t += interval;
    interval *= 0.97;
  }
  return text;
}

TEST_F(FitCommand, SamplesSayWhatIsNotInThemAndTheBudgetBelievesThem) {
  write("o.csv", onsets(90));
  EXPECT_EQ(run("restitution o.csv --out s.csv --air 0 --ball steel:8mm").exit_code, 0);
  // the table says it itself, wherever it is taken
  fs::rename(folder_ / "s.csv", folder_ / "elsewhere.csv");
  fs::remove(folder_ / "s.csv.meta.json");
  run("fit elsewhere.csv --out f.json --quiet");
  const auto row = found()["budget"]["rows"][0];
  EXPECT_EQ(row["shift_drag"], 0.0);
  EXPECT_EQ(row["shift_contact_time"], 0.0);
  EXPECT_EQ(found()["budget"]["ball"], "steel:8mm");
  EXPECT_TRUE(found()["budget"]["plate"].is_null());
}

TEST_F(FitCommand, ASpeedBeyondThoseMeasuredAndABallThatIsAnotherAreSaid) {
  EXPECT_THAT(fit(table(300, 0.3, 1.2), "--nodes 3").err,
              testing::HasSubstr("ε at 3 m/s is extrapolated: the measured speeds are 0.3"));
  EXPECT_THAT(fit(table(300, 0.3, 1.2), "--nodes 0.6").err, testing::Not(testing::HasSubstr("continued")));
  write("o.csv", onsets(30));
  ASSERT_EQ(run("restitution o.csv --ball steel:6mm --out s6.csv").exit_code, 0);
  const std::string other = "the samples are of steel:6mm";
  EXPECT_THAT(run("fit s6.csv --ball table-tennis --out f.json --force").err, testing::HasSubstr(other));
  EXPECT_THAT(run("fit s6.csv --ball steel:6mm --out f.json --force").err, testing::Not(testing::HasSubstr(other)));
}

}  // namespace
}  // namespace bouncelab::cli_test
