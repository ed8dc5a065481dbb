// SPDX-License-Identifier: GPL-3.0-or-later
// `restitution` and `fit` by hand and with bad samples.
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

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
  nlohmann::json found() const { return nlohmann::json::parse(content_of(folder_ / "f.json")); }
};

TEST_F(FitCommand, OfTwoSamplesGivesOneValueWithoutACurve) {
  const Result result = fit(table(2, 0.2, 1.4));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::StartsWith("ε = 0.9"));
  EXPECT_EQ(found().at("status"), "too_few_samples");
  EXPECT_EQ(found().at("answer").at("one_value"), true);
}

TEST_F(FitCommand, AtOneSpeedGivesTheOneValueThere) {
  const Result result = fit(table(500, 0.5, 0.5));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr(" at 0.5 m/s"));
  const auto at = found().at("answer").at("at");
  const double truth = 1.0 - 1.153448858 * 0.0467 * std::pow(0.5, 0.2) + 0.798266561 * 0.1339 * std::pow(0.5, 0.4) -
                       0.2876 * 4.0 / 15.0 * std::sqrt(0.5);
  // scatter of 8e-4 sqrt(2), of 500
  EXPECT_NEAR(at.at("eps").get<double>(), truth, 4.0 * 1.13e-3 / std::sqrt(500.0));
}

TEST_F(FitCommand, OfOneDropNamesTheConstantsAndKeepsTheCurve) {
  const Result result = fit(table(60, 0.3, 1.2));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"A2, A4, A5", "not identifiable", "60 impacts"})
    EXPECT_THAT(result.err, testing::HasSubstr(part));
  EXPECT_EQ(found().at("status"), "not_identifiable");
  EXPECT_EQ(found().at("law").at("nodes").size(), 3u);
}

TEST_F(FitCommand, RowsThatAreNoNumberOrHaveNoSpeedAreCountedAndNamed) {
  std::string samples = table(2000, 0.2, 1.4);
  samples += "99,0,nan,0.98,1e-4\n99,1,0.5,,1e-4\n99,2,0,0.98,1e-4\n";  // a drop of its own
  const Result result = fit(samples);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, testing::HasSubstr("2 of the samples left out: not finite; the first is number 2001"));
  EXPECT_THAT(result.err,
              testing::HasSubstr("1 of the samples left out: speed not positive; the first is number 2003"));
  EXPECT_EQ(found().at("n_left_out").at("not_finite"), 2);
  EXPECT_EQ(found().at("n_used"), 2000);
}

TEST_F(FitCommand, SigmasOfZeroAreNeglectedAndSaidSo) {
  const Result result = fit(table(2000, 0.2, 1.4, 0.0, "0"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(found().at("details").dump(), testing::HasSubstr("2000 of 2000 samples state no timing error"));
}

TEST_F(FitCommand, CoefficientsAboveOneOrNegativeAreFittedAsTheyAreWithAWarning) {
  const Result above = fit(table(2000, 0.2, 1.4, 0.1));
  EXPECT_THAT(above.err, testing::HasSubstr("2000 of 2000 samples have ε > 1"));
  EXPECT_GT(found().at("law").at("nodes")[0].at("eps").get<double>(), 1.05);
  const Result below = fit(table(2000, 0.2, 1.4, -1.5));
  EXPECT_THAT(below.err, testing::HasSubstr("2000 of 2000 samples have ε < 0"));
  EXPECT_LT(found().at("law").at("nodes")[0].at("eps").get<double>(), -0.4);
}

TEST_F(FitCommand, SpeedsThatLookLikeOtherUnitsAreWarnedOf) {
  EXPECT_THAT(fit(table(2000, 200.0, 1400.0)).err, testing::HasSubstr("outside 0.005 to 20 m/s"));
}

TEST_F(FitCommand, BootstrapGoodnessAndOtherLawsAreInTheResult) {
  const Result result = fit(table(3000, 0.2, 1.4), "--bootstrap 20 --table law.csv");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const auto j = found();
  EXPECT_EQ(j.at("law").at("anderson_darling").at("n_replicates"), 19);
  EXPECT_GT(j.at("law").at("nodes")[0].at("bootstrap").at("se").get<double>(), 0.0);
  EXPECT_GE(j.at("law_comparison").size(), 4u);
  EXPECT_TRUE(j.at("law_least_absolute").at("A2").at("value").is_number());
  EXPECT_EQ(content_of(folder_ / "law.csv").substr(0, 19), "v_mps,eps,lo95,hi95");
}

TEST_F(FitCommand, FitsTheLawAndByTheMethodAskedFor) {
  EXPECT_EQ(fit(table(2000, 0.2, 1.4), "--law-kind viscoelastic --method least-squares").exit_code, 0);
  EXPECT_EQ(found().at("law").at("law"), "viscoelastic");
  EXPECT_EQ(found().at("law").at("method"), "least_squares");
  expect_one_line_error(fit(table(2000, 0.2, 1.4), "--law-kind magic"), 2, {"--law-kind", "magic"});
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
  EXPECT_EQ(content_of(folder_ / "two.json"), content_of(folder_ / "f.json"));
  EXPECT_THAT(two.out, testing::HasSubstr("the 2 recordings agree (p = "));
  EXPECT_THAT(two.out, testing::HasSubstr("a.csv: 190 samples, ε("));
  EXPECT_EQ(found().at("recordings").at(1).at("recording"), "b.csv");
  EXPECT_EQ(found().at("recordings").at(1).at("n"), 285);
  EXPECT_THAT(content_of(folder_ / "two.json.meta.json"), testing::HasSubstr("b.csv"));
}

TEST_F(FitCommand, OfUnlikeBallsWarnsFirstAndNamesThem) {
  write("a.csv", table(190, 0.2, 1.4));
  write("b.csv", table(190, 0.2, 1.4, -0.02));
  const Result result = run("fit a.csv b.csv --out f.json --goodness-replicates 0");
  EXPECT_THAT(result.err, testing::StartsWith("warning: the 2 recordings do not agree (p = "));
  EXPECT_THAT(result.err, testing::ContainsRegex("ε at 0.53 m/s runs from 0.9[0-9]* .b.csv. to 0.9[0-9]* .a.csv."));
  EXPECT_LT(found().at("recordings_test").at("p_value").get<double>(), 1e-10);
  EXPECT_EQ(found().at("answers").at(0).at("question"), "Do the recordings agree?");
}

TEST_F(FitCommand, OfSeveralFilesOneThatIsFaultyIsNamedAndNothingIsWritten) {
  write("a.csv", table(190, 0.2, 1.4));
  write("b.csv", "v_mps,eps\n0.5,0.98\n0.4,high\n");
  expect_one_line_error(run("fit a.csv b.csv --out f.json"), 3, {"b.csv", "line 3", "eps"});
  expect_one_line_error(run("fit a.csv none.csv --out f.json"), 3, {"none.csv", "no such file"});
  expect_one_line_error(run("fit a.csv b.csv --out b.csv --force"), 2, {"b.csv"});
  EXPECT_THAT(files(), testing::ElementsAre("a.csv", "b.csv"));
}

TEST_F(FitCommand, FilesOfTheSameNameOrWithTheSameDropAreRecordingsOfTheirOwn) {
  fs::create_directories(folder_ / "x");
  fs::create_directories(folder_ / "y");
  write("x/s.csv", table(95, 0.2, 1.4));
  write("y/s.csv", table(96, 0.2, 1.4));
  run("fit x/s.csv y/s.csv --out f.json --quiet --goodness-replicates 0");
  EXPECT_EQ(found().at("recordings").at(0).at("recording"), "x/s.csv");
  EXPECT_EQ(found().at("recordings").at(1).at("recording"), "y/s.csv");
  const auto named = [](std::string rows) {
    std::string text;
    std::istringstream lines(rows);
    for (std::string line; std::getline(lines, line);)
      text += (text.empty() ? "recording," : "drop.wav,") + line + "\n";
    return text;
  };
  write("x/s.csv", named(table(95, 0.2, 1.4)));
  write("y/s.csv", named(table(96, 0.2, 1.4)));
  const Result result = run("fit x/s.csv y/s.csv --out f.json --force --goodness-replicates 0");
  EXPECT_THAT(result.err, testing::HasSubstr("drop.wav: several files have the same drop of this recording"));
  EXPECT_EQ(found().at("recordings").at(1).at("recording"), "drop.wav (y/s.csv)");
}

TEST_F(FitCommand, TheSameSamplesTwiceCountOnce) {
  write("a.csv", table(190, 0.2, 1.4));
  write("b.csv", table(190, 0.2, 1.4));
  const Result result = run("fit a.csv b.csv --out f.json --goodness-replicates 0");
  EXPECT_THAT(result.err, testing::HasSubstr("b.csv: the same samples as a.csv (by content); counted once"));
  EXPECT_EQ(found().at("n_used"), 190);
  EXPECT_TRUE(found().at("recordings").empty());
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
  const auto effects = found().at("budget").at("effects");
  EXPECT_EQ(effects[0].at("state"), "absent");
  EXPECT_EQ(effects[1].at("state"), "absent");
  EXPECT_EQ(found().at("budget").at("ball"), "steel:8mm");
  EXPECT_TRUE(found().at("budget").at("plate").is_null());
}

TEST_F(FitCommand, RecordingsAreKeptFromTheOnsetsToTheFitInEveryFormat) {
  const std::string drop = onsets(90);
  std::string both = "recording,drop,impact,t_s,sigma_t_s\n";
  for (const char* name : {"a.wav", "b.wav"}) {
    std::istringstream lines(drop.substr(drop.find('\n') + 1));
    for (std::string line; std::getline(lines, line);) both += std::string(name) + "," + line + "\n";
  }
  write("o.csv", both);
  for (const std::string format : {"csv", "jsonl"}) {
    EXPECT_EQ(run("restitution o.csv --out s." + format).exit_code, 0);
    run("fit s." + format + " --out f.json --force --quiet --goodness-replicates 0");
    ASSERT_EQ(found().at("recordings").size(), 2u) << format;
    EXPECT_EQ(found().at("recordings").at(0).at("recording"), "a.wav");
    EXPECT_EQ(found().at("recordings").at(1).at("n"), 88);
  }
}

TEST_F(FitCommand, WithMemoryPrintsTheConstantsOfFitJsonAndNamesTheOthersAsTheComparison) {
  ASSERT_EQ(run("simulate --drops 12 --asperities 100000 --out i.csv").exit_code, 0);
  ASSERT_EQ(run("restitution i.csv --ball steel:6mm --plate glass --air 0 --out s.csv").exit_code, 0);
  const Result result = run("fit s.csv --out f.json --table law.csv --goodness-replicates 0");
  const auto memory = found().at("memory");
  ASSERT_EQ(memory.at("holds"), true) << memory.at("message");
  std::istringstream lines(result.out);
  int n_compared = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto printed = [&](const std::string& name, double value, double se) {
      if (line.rfind(name + " = ", 0) != 0) return;
      // as printed, to a digit of a tenth of the standard error or finer
      EXPECT_NEAR(std::stod(line.substr(name.size() + 3)), value, 0.1 * se) << line;
      EXPECT_THAT(line, testing::HasSubstr("; impacts taken as independent: "));
      ++n_compared;
    };
    for (const std::string name : memory.at("parameters"))
      printed(name, memory.at(name).at("value"), memory.at(name).at("se"));
    for (const auto& node : memory.at("nodes")) {
      char name[64];
      std::snprintf(name, sizeof name, "ε(%.3g m/s)", node.at("v_mps").get<double>());
      printed(name, node.at("eps"), node.at("se"));
    }
  }
  EXPECT_GE(n_compared, 3);  // the nodes, and the constants that these drops determine
  // the table is the curve of the same fit
  std::istringstream table(content_of(folder_ / "law.csv"));
  std::string head, first;
  std::getline(table, head);
  std::getline(table, first, ',');
  std::getline(table, first, ',');
  EXPECT_DOUBLE_EQ(std::stod(first), memory.at("curve").at(0).at("eps").get<double>());
}

TEST_F(FitCommand, TableIsTheCurveThatIsQuoted) {
  ASSERT_EQ(fit(table(300, 0.2, 1.4), "--table law.csv").exit_code, 0);
  std::istringstream csv(content_of(folder_ / "law.csv"));
  std::string line;
  std::getline(csv, line);
  const nlohmann::json curve = found().at("averaged").at("curve");
  for (const auto& point : curve) {
    ASSERT_TRUE(std::getline(csv, line));
    EXPECT_DOUBLE_EQ(std::stod(line.substr(line.find(',') + 1)), point.at("eps").get<double>()) << line;
  }
}

TEST_F(FitCommand, TravelTimeIsTakenOutWherePositionsAreKnown) {
  write("o.csv", onsets(30));
  std::string positions = "drop,impact,x_m,y_m\n";
  for (int k = 0; k < 29; ++k) positions += "0," + std::to_string(k) + "," + number(0.01 * (k % 3)) + ",0.02\n";
  write("p.csv", positions);
  const Result result = run("restitution o.csv --out s.csv --positions p.csv --sensor-position 0.1,0 --wave-speed 340");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("corrected for travel time"));
  EXPECT_THAT(result.out, testing::HasSubstr("no_position"));
  write("twice.csv", positions + "0,3,0.5,0.5\n");
  expect_one_line_error(run("restitution o.csv --out t.csv --positions twice.csv"), 2,
                        {"line 31", "impact 3 of drop 0"});
  write("bad.csv", "drop,impact,x_m\n0,0,1\n");
  expect_one_line_error(run("restitution o.csv --out t.csv --positions bad.csv"), 3, {"bad.csv", "line 1", "y_m"});
}

TEST_F(FitCommand, ASpeedBeyondThoseMeasuredAndABallThatIsAnotherAreSaid) {
  EXPECT_THAT(fit(table(300, 0.3, 1.2), "--nodes 3").err,
              testing::HasSubstr("ε at 3 m/s is the law continued: speeds from 0.3"));
  EXPECT_THAT(fit(table(300, 0.3, 1.2), "--nodes 0.6").err, testing::Not(testing::HasSubstr("continued")));
  write("o.csv", onsets(30));
  ASSERT_EQ(run("restitution o.csv --ball steel:6mm --out s6.csv").exit_code, 0);
  const std::string other = "the samples say that they are of steel:6mm";
  EXPECT_THAT(run("fit s6.csv --ball table-tennis --out f.json --force").err, testing::HasSubstr(other));
  EXPECT_THAT(run("fit s6.csv --ball steel:6mm --out f.json --force").err, testing::Not(testing::HasSubstr(other)));
}

TEST_F(FitCommand, OfExactlyOneCoefficientLeavesNoneOut) {
  std::string samples = "v_mps,eps\n";
  for (int k = 0; k < 50; ++k) samples += number(0.3 + 0.02 * k) + ",0.9000000000\n";
  const Result result = fit(samples);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(found().at("n_used"), 50);
}

TEST_F(FitCommand, AConstantLawThatWasAskedForIsNotExplainedByTooFewBounces) {
  const Result result = fit(table(80, 0.3, 1.2), "--law-kind constant");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(found().at("law").at("law"), "constant");
  for (const std::string& text : {result.out, result.err, found().dump()})
    EXPECT_THAT(text, testing::Not(testing::HasSubstr("too few bounces")));
}

TEST_F(FitCommand, PositionsAreOfOneRecording) {
  std::string onsets = "recording,drop,impact,t_s\n", positions = "drop,impact,x_m,y_m\n";
  for (const char* name : {"r1.wav", "r2.wav"})
    for (int k = 0; k < 5; ++k)
      onsets += std::string(name) + ",0," + std::to_string(k) + "," + std::to_string(0.3 * k - 0.01 * k * k) + "\n";
  for (int k = 0; k < 5; ++k) positions += "0," + std::to_string(k) + ",0.1,0.2\n";
  write("o.csv", onsets);
  write("p.csv", positions);
  expect_one_line_error(run("restitution o.csv --positions p.csv --out x.csv"), 2,
                        {"positions are of one recording", "r1.wav", "r2.wav"});
}

}  // namespace
}  // namespace bouncelab::cli_test
