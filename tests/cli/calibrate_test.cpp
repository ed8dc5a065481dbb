// SPDX-License-Identifier: GPL-3.0-or-later
// `calibrate --memory`: experiments so small that none gives a fit, since a whole one takes seconds; what fits give is
// tested in tests/loop/memory_calibration_test.cpp.

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using CalibrateCommand = ProgramTest;

TEST_F(CalibrateCommand, WithMemoryCountsFailuresWritesARowForEachExperimentAndSaysThatNoneIsUsable) {
  const Result result =
      run("calibrate --memory --experiments 1 --drops 1,2 --impacts 12 --seed 1 --out e.csv --json --quiet");
  expect_one_line_error(result, 1, {"no experiment gave a fit with memory", "60 impacts"});
  const Json json = Json(result.out);
  EXPECT_EQ(json["n_experiments"], 1);
  EXPECT_EQ(json["n_failed"], 1);
  EXPECT_EQ(json["groups"][0]["family"], "test");
  const std::string table = content("e.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2);
  EXPECT_THAT(table, testing::StartsWith("radii,n_asperities,contact,n_drops,release_spin_radps,drag,sound,"));
  EXPECT_THAT(table, testing::HasSubstr("too_few_samples"));
  EXPECT_EQ(files(), (std::vector<std::string>{"e.csv", "e.csv.meta.json"}));
}

TEST_F(CalibrateCommand, RefusesOptionsOfTheOtherStudy) {
  expect_one_line_error(run("calibrate --memory --seeds 3"), 2, {"--memory", "--seeds"});
  expect_one_line_error(run("calibrate --experiments 3"), 2, {"--experiments", "--memory"});
  expect_one_line_error(run("calibrate --memory --drops 9,8"), 2, {"drops 9 to 8", "must rise"});
  expect_one_line_error(run("calibrate --memory --drops 1.5,8"), 2, {"--drops 1.5", "integer"});
  expect_one_line_error(run("calibrate --memory --impacts 11"), 2, {"--impacts", "12"});
}

}  // namespace
}  // namespace bouncelab::cli_test
