// SPDX-License-Identifier: GPL-3.0-or-later
// The answer of `analyze` and `fit` to small inputs that people have: its interval holds what went in.

#include "bouncelab/core/random.hpp"
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

class Answer : public ProgramTest {
 protected:
  Json answer_to(const std::string& arguments) const {
    const Result result = run(arguments + " --json --force");
    EXPECT_LE(result.exit_code, 1) << arguments << "\n" << result.err;  // 1: few samples identify no constants
    return Json(result.out)["answer"];
  }
  static void expect_value(const Json& answer, double eps, double se_max) {
    const Json& at = answer["at"];
    EXPECT_LE(at["ci95"][0].number(), eps) << answer;
    EXPECT_GE(at["ci95"][1].number(), eps) << answer;
    EXPECT_LT(at["se"].number(), se_max) << answer;
  }
  static std::string first_line(const Json& answer) { return answer["sentences"][0].text(); }
};

TEST_F(Answer, OfASoundWithOneEpsClaimsNoChangeWithTheSpeed) {
  for (const double eps : {0.5, 0.75}) {
    write("drop.wav", float_wav(bouncing(8, eps, 0.6), 44100));
    const Json answer = answer_to("analyze drop.wav --out out");
    EXPECT_NEAR(answer["at"]["eps"].number(), eps, 1e-4);
    EXPECT_EQ(answer["elsewhere"].size(), 0U) << answer;
    EXPECT_EQ(first_line(answer).find("rises"), std::string::npos);
    // the picture shows the same as the words
    const Json curve = json("out/fit.json")["curve"]["points"];
    EXPECT_GE(curve.size(), 13U);
    for (const Json& point : curve.elements()) {
      EXPECT_LE(point["lo95"].number(), eps + 1e-5) << point;  // the detector's own 1e-5
      EXPECT_GE(point["hi95"].number(), eps - 1e-5) << point;
    }
  }
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
  EXPECT_GT(answer["at"]["se"].number(), 0.001);  // a uniform digit of .01 has .003; three of them .0017
}

}  // namespace
}  // namespace bouncelab::cli_test
