// SPDX-License-Identifier: GPL-3.0-or-later
// The answer of `analyze` and `fit` to small inputs that people have: its interval holds what went in.
#include <cmath>
#include <nlohmann/json.hpp>

#include "bouncelab/core/random.hpp"
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

using Json = nlohmann::json;

class Answer : public ProgramTest {
 protected:
  Json answer_to(const std::string& arguments) const {
    const Result result = run(arguments + " --json --force");
    EXPECT_LE(result.exit_code, 1) << arguments << "\n" << result.err;  // 1: few samples identify no constants
    return Json::parse(result.out).at("answer");
  }
  static void expect_value(const Json& answer, double eps, double se_max) {
    const Json& at = answer.at("at");
    EXPECT_LE(at.at("ci95")[0].get<double>(), eps) << answer;
    EXPECT_GE(at.at("ci95")[1].get<double>(), eps) << answer;
    EXPECT_LT(at.at("se").get<double>(), se_max) << answer;
  }
  static std::string first_line(const Json& answer) { return answer.at("sentences")[0]; }
};

TEST_F(Answer, OfASoundWithOneEpsClaimsNoChangeWithTheSpeed) {
  for (const double eps : {0.5, 0.6, 0.75, 0.9}) {
    write("drop.wav", float_wav(bouncing(eps < 0.8 ? 8 : 20, eps, 0.6), 44100));
    const Json answer = answer_to("analyze drop.wav --out out");
    EXPECT_NEAR(answer.at("at").at("eps").get<double>(), eps, 1e-4);
    EXPECT_TRUE(answer.at("elsewhere").empty()) << answer;
    EXPECT_EQ(first_line(answer).find("rises"), std::string::npos);
    // the picture shows the same as the words
    const Json curve = Json::parse(content_of(folder_ / "out" / "fit.json")).at("averaged").at("curve");
    EXPECT_EQ(curve.size(), 25U);
    for (const Json& point : curve) {
      EXPECT_LE(point.at("lo95").get<double>(), eps + 1e-5) << point;  // the detector's own 1e-5
      EXPECT_GE(point.at("hi95").get<double>(), eps - 1e-5) << point;
    }
  }
}

TEST_F(Answer, OfFewSamplesWithOneEpsIsTheirMean) {
  double squares = 0.0;
  constexpr int kTables = 10;
  for (int s = 0; s < kTables; ++s) {
    Random random(3, RandomStream::test, static_cast<std::uint64_t>(s));
    std::string table = "v_mps,eps\n";
    double v = 2.9;
    for (int k = 0; k < 6; ++k, v *= 0.6)
      table += std::to_string(v) + "," + std::to_string(0.6 * (1.0 + 0.003 * random.normal())) + "\n";
    write("s.csv", table);
    const double error = answer_to("fit s.csv --out f.json").at("at").at("eps").get<double>() / 0.6 - 1.0;
    squares += error * error / kTables;
  }
  // .3 % by the root of 6 is .12 %; twice that leaves room for a law that may bend
  EXPECT_LT(std::sqrt(squares), 0.0025);
}

TEST_F(Answer, OfEightDropsFromOneHeightIsOneValue) {
  Random random(2, RandomStream::test, 0);
  std::string table = "v_mps,eps\n";
  for (int k = 0; k < 8; ++k)
    table += std::to_string(2.2 * (1.0 + 0.06 * (random.uniform() - 0.5))) + "," +
             std::to_string(0.8 + 0.008 * random.normal()) + "\n";
  write("s.csv", table);
  expect_value(answer_to("fit s.csv --out f.json"), 0.8, 0.006);  // .008 by the root of 8 is .003
}

TEST_F(Answer, OfValuesRoundedAlikeHasAnErrorOfTheLastDigit) {
  write("s.csv", "v_mps,eps\n3.0,0.80\n2.4,0.80\n1.9,0.80\n");
  const Json answer = answer_to("fit s.csv --out f.json");
  expect_value(answer, 0.8, 0.01);
  EXPECT_GT(answer.at("at").at("se").get<double>(), 0.001);  // a uniform digit of .01 has .003; three of them .0017
}

TEST_F(Answer, WarnsOfAHeightInCentimetresAndKeepsTheSamples) {
  write("drop.wav", float_wav(bouncing(12, 0.85, 0.6), 44100));
  const Result right = run("analyze drop.wav --out right --drop-height 0.611");
  const Result wrong = run("analyze drop.wav --out wrong --drop-height 61.1");
  EXPECT_THAT(wrong.out, testing::HasSubstr("--drop-height"));
  EXPECT_THAT(wrong.out, testing::HasSubstr("61.1 m"));
  EXPECT_THAT(right.out, testing::Not(testing::HasSubstr("--drop-height")));
  const auto eps_of = [&](const char* folder) {
    return Json::parse(content_of(folder_ / folder / "fit.json")).at("answer").at("at").at("eps").get<double>();
  };
  EXPECT_NEAR(eps_of("wrong"), 0.85, 1e-4);
  EXPECT_NEAR(eps_of("right"), 0.85, 1e-3);
}

}  // namespace
}  // namespace bouncelab::cli_test
