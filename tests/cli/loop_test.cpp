// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Loop = ProgramTest;

TEST_F(Loop, WhatWentInComesOutWithinTheErrorsStated) {
  const Result result = run("loop --drops 6 --asperities 100000 --out out --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = json("out/summary.json");
  EXPECT_EQ(Json(result.out), summary);
  const Json& score = summary["score"];
  const double n_impacts = score["n_true"].number();
  EXPECT_GE(n_impacts, 6 * 90);  // the paper: 90 to 100 bounces a drop
  EXPECT_GE(score["n_found"].number(), 0.99 * n_impacts);
  EXPECT_GE(score["n_found"].number(), 0.99 * score["n_marked"].number());
  for (const Json& node : summary["eps_nodes"].elements()) {
    const Json& found = node["from_sound"];
    // 4 standard errors: three nodes, one fixed seed
    EXPECT_NEAR(found["eps"].number(), node["truth"].number(), 4 * found["se"].number()) << node;
  }
  // the closed form beside it: of the impacts simulated, whether or not they were found
  const Json& theory = summary["theory"];
  EXPECT_EQ(theory["n_transforms"], n_impacts);
  // uniform radii of width 1e-3: s2 = (1/2) sqrt(pi w/N), stated to three digits
  EXPECT_NEAR(theory["offset_variance"].number(), 0.5 * std::sqrt(3.14159 * 1e-3 / 1e5), 1e-7);
  EXPECT_THAT(content("out/report.html"), testing::HasSubstr("\"transform_counts\":["));
  // the reservoir through files, where the table of impacts has no states
  EXPECT_EQ(content("out/impacts.csv").find("wx_radps"), std::string::npos);
  const Json& reservoir = summary["reservoir"];
  EXPECT_EQ(reservoir["law"], "independent");
  EXPECT_EQ(reservoir["n_drops"], 6);
  EXPECT_NEAR(reservoir["spin_share"].number(), 2.0 / 7.0, 0.01);  // rolling, to first order in offsets of 1e-2
  EXPECT_THAT(content("out/report.html"), testing::HasSubstr("\"sound_m2ps2\":["));
  for (const char* name : {"impacts.csv", "truth.csv", "onsets.csv", "samples.csv", "fit.json", "histograms.csv",
                           "wave.json", "report.html"})
    EXPECT_TRUE(exists(std::string("out/") + name)) << name;
}

}  // namespace
}  // namespace bouncelab::cli_test
