// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Json = nlohmann::json;
using Loop = ProgramTest;

TEST_F(Loop, WhatWentInComesOutWithinTheErrorsStated) {
  const Result result = run("loop --drops 6 --asperities 100000 --out out --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = Json::parse(content_of(folder_ / "out" / "summary.json"));
  EXPECT_EQ(Json::parse(result.out), summary);
  const int n_impacts = summary["n_impacts"];
  EXPECT_GE(n_impacts, 6 * 90);  // the paper: 90 to 100 bounces a drop
  EXPECT_GE(summary["n_found"].get<int>(), 0.99 * n_impacts);
  EXPECT_LE(summary["n_invented"].get<int>(), 0.01 * n_impacts);
  for (const Json& node : summary["eps_nodes"]) {
    const Json& found = node["from_sound"];
    // 4 standard errors: three nodes, one fixed seed
    EXPECT_NEAR(found["eps"].get<double>(), node["truth"].get<double>(), 4 * found["se"].get<double>()) << node;
  }
  for (const char* name :
       {"impacts.csv", "truth.csv", "onsets.csv", "samples.csv", "fit.json", "wave.json", "report.html"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;
}

TEST_F(Loop, ResultsDoNotDependOnTheNumberOfThreads) {
  ASSERT_EQ(run("loop --drops 3 --asperities 20000 --impacts 30 --threads 1 --out one").exit_code, 0);
  ASSERT_EQ(run("loop --drops 3 --asperities 20000 --impacts 30 --threads 3 --out three").exit_code, 0);
  for (const char* name : {"impacts.csv", "recording.wav"})
    EXPECT_EQ(content_of(folder_ / "one" / name), content_of(folder_ / "three" / name)) << name;
}

}  // namespace
}  // namespace bouncelab::cli_test
