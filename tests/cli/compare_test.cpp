// SPDX-License-Identifier: GPL-3.0-or-later
// `compare` on recordings whose truth is known, and on what is no campaign.
#include <cmath>
#include <sstream>

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

constexpr std::size_t kRecordings = 12, kPlates = 3, kBad = 7;
constexpr double kDrift_per_day = 3e-4, kPlate = 8e-4, kBetween = 1.5e-4;

std::string name_of(std::size_t k) {
  return "ball_2026-03-" + std::to_string(10 + k) + "_" + std::to_string(10 + k % 8) + "30.wav";
}

class CompareCommand : public ProgramTest {
 protected:
  /// Twelve recordings of as many days, three drops of 35 impacts each. The scatter is that of the paper, two
  /// exponentials of different slope and mean ~ 1/v convolved with a normal; recordings, and not values of laws, are
  /// what is drawn. One recording is of another ball.
  void write_samples() const {
    std::ostringstream samples, groups;
    samples << "recording,drop,impact,v_mps,eps\n";
    groups << "recording,plate\n";
    samples.precision(9);
    const RestitutionLaw law = SeriesLaw{};
    for (std::size_t k = 0; k < kRecordings; ++k) {
      Random random(5, RandomStream::test, k);
      const double offset = kBetween * random.normal() + kDrift_per_day * (static_cast<double>(k) - 5.5) +
                            (k % kPlates == 1 ? kPlate : 0.0) - (k == kBad ? 8e-3 : 0.0);
      groups << name_of(k) << ",glass " << k % kPlates + 1 << "\n";
      for (int i = 0; i < 105; ++i) {
        const double v = 0.25 * std::pow(1.35 / 0.25, random.uniform());
        const double below = 4e-4 / v, above = 3e-4 / v;
        const double side = random.uniform() < below / (below + above) ? -below : above;
        const double eps = restitution(law, v) + offset + side * random.exponential() + 2e-4 * random.normal();
        samples << name_of(k) << "," << i / 35 << "," << i % 35 + 1 << "," << v << "," << eps << "\n";
      }
    }
    write("s.csv", samples.str());
    write("g.csv", groups.str());
  }
  Json comparison() const { return json("o/comparison.json"); }
};

TEST_F(CompareCommand, FindsDriftPlateAndBadRecording) {
  write_samples();
  std::string samples = content("s.csv");
  for (int i = 0; i < 5; ++i) samples += "short.wav,0," + std::to_string(i + 1) + ",0.5,0.97\n";
  write("s.csv", samples);
  const Result result = run("compare s.csv --groups g.csv --out o");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto c = comparison();
  EXPECT_EQ(c["n_recordings"], kRecordings + 1);
  ASSERT_EQ(c["not_used"].size(), 1u);
  EXPECT_EQ(c["not_used"][0]["recording"], "short.wav");
  EXPECT_THAT(c["not_used"][0]["message"].text(), testing::HasSubstr("at least 8"));
  EXPECT_NEAR(c["n_samples"].number(), 1260, 60);  // 1260 but for lost bounces
  // one seed: each interval leaves the truth out once in 20 of them
  const auto holds = [](const Json& ci, double truth) {
    EXPECT_LT(ci[0].number(), truth);
    EXPECT_GT(ci[1].number(), truth);
  };
  holds(c["drift"]["slope"]["ci95"], kDrift_per_day);
  EXPECT_LT(c["drift"]["p_value"].number(), 1e-3);
  EXPECT_EQ(c["drift"]["per"], "day");
  // the second plate differs: each has its own eps, in the middle of the campaign; the mean of two exponentials is off
  // their peak by the difference of their scales
  EXPECT_TRUE(c["eps"].is_null());
  for (std::size_t p = 0; p < kPlates; ++p) {
    const auto& plate = c["differences"]["groups"][p];
    const double v_mps = plate["v_mps"].number();
    holds(plate["eps"]["ci95"], restitution(SeriesLaw{}, v_mps) - 1e-4 / v_mps + (p == 1 ? kPlate : 0.0));
  }
  ASSERT_EQ(c["outliers"].size(), 1u);
  EXPECT_EQ(c["outliers"][0]["recording"], name_of(kBad));
  EXPECT_EQ(c["plates"]["effect"], "fixed");
  ASSERT_EQ(c["plates"]["rows"].size(), kPlates);
  const auto& second = c["plates"]["rows"][1];
  EXPECT_EQ(second["name"], "glass 2");
  // three standard errors, of the plate's and of the mean's
  EXPECT_NEAR(second["offset"].number(), kPlate * 2.0 / 3.0, 4.0 * second["se"].number());
  EXPECT_THAT(result.out, testing::HasSubstr("rises over the campaign"));
  EXPECT_THAT(result.out, testing::HasSubstr(name_of(kBad)));
  const std::string table = content("o/comparison.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), static_cast<std::ptrdiff_t>(kRecordings) + 2);
  EXPECT_THAT(table, testing::HasSubstr(name_of(0) + ",glass 1,2026-03-10T10:30:00,"));
  const std::string page = content("o/report.html");
  EXPECT_THAT(page, testing::HasSubstr("rises over the campaign"));
  EXPECT_LT(page.size(), 3000000u);  // the plotting library is half of it
  EXPECT_THAT(content("o/comparison.json.meta.json"), testing::HasSubstr("g.csv"));
}

TEST_F(CompareCommand, OfPlatesThatDifferEachHasItsOwnEpsAndOfThoseThatAgreeAllHaveOne) {
  constexpr double kWood = -0.02;
  for (const double wood : {kWood, 0.0}) {
    std::ostringstream samples, groups;
    samples << "recording,drop,impact,v_mps,eps\n";
    groups << "recording,plate\n";
    samples.precision(9);
    for (std::size_t k = 0; k < 16; ++k) {
      Random random(11, RandomStream::test, k);
      const double offset = kBetween * random.normal() + (k % 2 == 1 ? wood : 0.0);
      groups << "r" << k << (k % 2 == 1 ? ",wood\n" : ",glass\n");
      for (int i = 0; i < 90; ++i) {
        const double v = 0.25 * std::pow(1.35 / 0.25, random.uniform());
        const double eps =
            restitution(SeriesLaw{}, v) + offset + 4e-4 / v * (random.exponential() - random.exponential());
        samples << "r" << k << "," << i / 30 << "," << i % 30 + 1 << "," << v << "," << eps << "\n";
      }
    }
    write("s.csv", samples.str());
    write("g.csv", groups.str());
    const Result result = run("compare s.csv --groups g.csv --out o --force");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto c = comparison();
    const std::string table = content("o/comparison.csv");
    const std::string first = table.substr(table.find("r0,glass"), table.find("\nr1,wood") - table.find("r0,glass"));
    if (wood == 0.0) {
      EXPECT_EQ(c["differences"]["differ"], false);
      EXPECT_TRUE(c["eps"].contains("value") && c["nodes"].size() > 4u);
      EXPECT_THAT(result.out, testing::HasSubstr("\nε = 0.9"));
      EXPECT_THAT(first, testing::HasSubstr(",,,,,0,"));
      continue;
    }
    EXPECT_TRUE(c["eps"].is_null() && c["prediction95"].is_null() && c["nodes"].is_null());
    ASSERT_EQ(c["differences"]["groups"].size(), 2u);
    for (std::size_t g = 0; g < 2; ++g) {
      const auto& group = c["differences"]["groups"][g];
      EXPECT_EQ(group["name"], g == 0 ? "glass" : "wood");
      EXPECT_EQ(group["n"], 8);
      const double truth = restitution(SeriesLaw{}, group["v_mps"].number()) + (g == 0 ? 0.0 : wood);
      // one seed, four standard errors; the next recording within five of the standard deviation between recordings
      EXPECT_NEAR(group["eps"]["value"].number(), truth, 4.0 * group["eps"]["se"].number());
      EXPECT_GT(group["prediction95"][0].number(), truth - 8.0 * kBetween);
      EXPECT_LT(group["prediction95"][1].number(), truth + 8.0 * kBetween);
    }
    EXPECT_THAT(result.out, testing::HasSubstr("\nglass: ε = 0.97"));
    EXPECT_THAT(result.out, testing::HasSubstr("\nwood: ε = 0.95"));
    EXPECT_THAT(result.out, testing::HasSubstr("; one more recording would have 0.95"));
    EXPECT_THAT(result.out, testing::Not(testing::HasSubstr("\nε = ")));
    EXPECT_THAT(table, testing::HasSubstr(",group_eps,group_sigma_eps,group_lo95,group_hi95,"));
    EXPECT_THAT(first, testing::Not(testing::HasSubstr(",,,,,")));
  }
}

/// Drops of `bouncing` one behind the other.
std::string sound_of(int n_drops, double eps) {
  std::vector<float> all;
  for (int d = 0; d < n_drops; ++d) {
    const std::vector<float> one = bouncing(14, eps + 0.001 * (d % 2));
    all.insert(all.end(), one.begin(), one.end());
    all.insert(all.end(), 22050, 0.0F);
  }
  return float_wav(all, 44100);
}

TEST_F(CompareCommand, TwoSoundsOnTwoPlatesAreAnalysedAndToldApartIfTheyHaveSeveralDrops) {
  write("glass.wav", sound_of(3, 0.90));
  write("wood.wav", sound_of(3, 0.80));
  const Result result = run("compare glass.wav wood.wav --ball marble --out o");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::StartsWith("glass.wav and wood.wav differ by more than drops of one recording do"));
  const auto d = comparison()["differences"];
  EXPECT_EQ(d["unit"], "drops");
  EXPECT_EQ(d["rows"][0]["ndf"], 4.0);
  const auto& row = d["rows"][0];
  EXPECT_NEAR(row["eps"]["value"].number(), -0.1, 2e-3);  // drops differ by 1e-3
  EXPECT_LT(row["p_value"].number(), 1e-4);
  EXPECT_GE(row["nodes"].size(), 3u);
  EXPECT_THAT(content("o/report.html"), testing::HasSubstr("differ by more than drops"));
  write("cut.wav", "RIFF");
  EXPECT_EQ(run("compare glass.wav wood.wav cut.wav --out cut").exit_code, 3);
  EXPECT_TRUE(exists("cut/comparison.json"));
  write("glass.wav", sound_of(1, 0.90));
  write("wood.wav", sound_of(1, 0.80));
  EXPECT_THAT(run("compare glass.wav wood.wav --out o --force").out,
              testing::HasSubstr("there is one each; drop the ball several times"));
  EXPECT_TRUE(comparison()["differences"]["rows"][0]["p_value"].is_null());
}

TEST_F(CompareCommand, NamesRowsWithoutARecordingAndRecordingsWithoutARow) {
  write("glass.wav", sound_of(2, 0.90));
  write("wood.wav", sound_of(2, 0.80));
  write("other.wav", sound_of(2, 0.85));
  write("g.csv", "recording,plate\nglass.wav,window\nwood.wav,table\nlost.wav,table\n");
  const Result result = run("compare ./glass.wav wood.wav g.csv.meta.json other.wav --groups g.csv --out o");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, testing::HasSubstr("1 of the 3 recordings ('lost.wav') of g.csv has no samples"));
  EXPECT_THAT(result.err, testing::HasSubstr("1 of the 3 recordings ('other.wav') has no row in g.csv"));
  const auto row = comparison()["differences"]["rows"][0];
  EXPECT_EQ(row["reference"], "window");  // in the order of the recordings
  EXPECT_EQ(row["group"], "table");
}

TEST_F(CompareCommand, BadInputGetsOneLine) {
  write_samples();
  expect_one_line_error(run("compare none.csv --out o"), 3, {"none.csv", "no such file"});
  expect_one_line_error(run("compare s.csv"), 2, {"--out"});
  for (const char* fit : {R"({"averaged":{},"law":{}})", R"({"curve":{},"law":{}})"}) {  // of 0.2 and of today
    write("fit.json", fit);
    expect_one_line_error(run("compare fit.json s.csv --out o"), 3, {"fit.json", "is a result", "give the samples"});
  }
  write("few.csv", "recording,v_mps,eps\na,0.5,0.97\nb,0.5,0.98\n");
  expect_one_line_error(run("compare few.csv --out few --quiet"), 1, {"a has 1 usable sample:", "at least 3"});
  write("mixed.csv", "recording,v_mps,eps\na,0.5,0.97\nb,0.5,0.98\na,0.5,0.97\n");
  expect_one_line_error(run("compare mixed.csv --out o"), 3, {"mixed.csv", "'a'", "sort"});
  write("dates.csv", "recording,date\n" + name_of(0) + ",2026-02-30\n");
  expect_one_line_error(run("compare s.csv --groups dates.csv --out o"), 3, {"dates.csv", "line 2", "2026-02-30"});
  write("twice.csv", "recording,plate\na,x\na,y\n");
  expect_one_line_error(run("compare s.csv --groups twice.csv --out o"), 3, {"twice.csv", "line 3", "'a'", "twice"});
  write("same.csv", "recording,v_mps,eps\ngranite/1/a,0.5,0.97\nsteel/1/a,0.5,0.98\nsteel/2/b,0.5,0.98\n");
  write("g.csv", "recording,plate\n1/a,x\nb,y\n");
  for (const std::string command : {"compare", "fit"})
    expect_one_line_error(run(command + " same.csv --groups g.csv --out o.json"), 3,
                          {"g.csv", "'1/a'", "'granite/1/a' and of 'steel/1/a'", "write the path"});
  write("neither.csv", "recording,colour\na,x\n");
  expect_one_line_error(run("compare s.csv --groups neither.csv --out o"), 3, {"neither.csv", "plate", "date"});
}

TEST_F(CompareCommand, SaysWhereBallGravityOrCorrectionsDiffer) {
  const std::string simulate = "simulate --drops 4 --impacts 30 --asperities 99 --seed ";
  ASSERT_EQ(run(simulate + "1 --out a.csv").exit_code, 0);
  ASSERT_EQ(run(simulate + "2 --out b.csv").exit_code, 0);
  ASSERT_EQ(run(simulate + "3 --ball glass:5mm --gravity 5 --out c.csv").exit_code, 0);
  for (const std::string name : {"a", "b", "c"})
    ASSERT_EQ(run("restitution " + name + ".csv --out " + name + "s.csv").exit_code, 0);
  EXPECT_THAT(run("compare as.csv bs.csv --out same").err, testing::Not(testing::HasSubstr("of another ball")));
  const Result result = run("compare as.csv bs.csv cs.csv --out o");
  // of so few there is no model of all, whose columns from eps to p_value are empty and not 0
  const std::string table = content("o/comparison.csv");
  EXPECT_THAT(table.substr(table.find('\n', table.find("recording,"))), testing::Not(testing::HasSubstr(",0,0,0,")));
  EXPECT_THAT(table, testing::HasSubstr(",,,,,,"));
  EXPECT_THAT(result.err + result.out,
              testing::HasSubstr("of another ball, plate, gravity or correction than the first"));
}

}  // namespace
}  // namespace bouncelab::cli_test
