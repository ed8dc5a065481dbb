// SPDX-License-Identifier: GPL-3.0-or-later
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using SimulateCommand = ProgramTest;

TEST_F(SimulateCommand, TakesTheSurfaceThatItWrote) {
  ASSERT_EQ(run("simulate --drops 2 --impacts 3 --asperities 2000 --out a.csv --write-surface s.csv").exit_code, 0);
  ASSERT_EQ(run("simulate --drops 2 --impacts 3 --surface s.csv --out b.csv").exit_code, 0);
  // normalised once more on reading: the last digits of a direction change, and a bounce or two makes little of them
  const std::vector<double> drawn = *read_csv(folder_ / "a.csv", {{"t_s"}}).reals("t_s");
  EXPECT_THAT(*read_csv(folder_ / "b.csv", {{"t_s"}}).reals("t_s"),
              testing::Pointwise(testing::DoubleNear(1e-9), drawn));
}

TEST_F(SimulateCommand, GivesTablesOfPartsThatConcatenateToTheTableOfTheWhole) {
  ASSERT_EQ(run("simulate --drops 7 --asperities 5000 --state --out all.csv").exit_code, 0);
  for (const std::string part :
       {"--drops 4 --out 1.csv", "--first-drop 4 --drops 1 --out 2.csv", "--first-drop 5 --drops 2 --out 3.csv"})
    ASSERT_EQ(run("simulate --asperities 5000 --state " + part).exit_code, 0);
  const Result concatenated = shell("awk 'FNR > 1 || NR == 1' 1.csv 2.csv 3.csv");
  EXPECT_EQ(concatenated.out, content("all.csv"));
}

TEST_F(SimulateCommand, NamesTheBadRowOfASurface) {
  write("s.csv", "ux,uy,uz,radius_m\n0,0,1,3e-6\n0,0,0,3e-6\n");
  expect_one_line_error(run("simulate --surface s.csv --out a.csv"), 3, {"s.csv", "line 3", "ux"});
  write("s.csv", "ux,uy,uz,radius_m\n0,0,1,-3e-6\n");
  expect_one_line_error(run("simulate --surface s.csv --out a.csv"), 3, {"s.csv", "line 2", "radius_m"});
  write("s.csv", "ux,uy,uz,radius_m\n\n0,0,1,3e-6\n\n\n0,0,1,nan\n");  // blank lines count
  expect_one_line_error(run("simulate --surface s.csv --out a.csv"), 3, {"s.csv", "line 6", "radius_m"});
  EXPECT_THAT(files(), testing::Not(testing::Contains("a.csv")));
}

TEST_F(SimulateCommand, RefusesWhatCannotBeWithTheQuantityAndItsRange) {
  expect_one_line_error(run("simulate --height 1e-6 --asperities 1000 --out a.csv"), 2,
                        {"drop height", "inside the plate"});
  expect_one_line_error(run("simulate --law series:A2=5 --out a.csv"), 2, {"coefficient of restitution", "A2 = 5"});
  expect_one_line_error(run("simulate --spin 1e6,1e6,1e6 --drops 1 --impacts 3 --asperities 100 --out a.csv"), 2,
                        {"coefficient of restitution", "which this experiment reaches"});
  // dust: 24 s and 5 GB for the sinking of one ball
  expect_one_line_error(run("simulate --ball steel:2um --drag --height 1 --out a.csv"), 2, {"drop height", "in air"});
  write("eps.csv", "v_mps,eps\n0.2,0.9\n0.1,0.8\n");
  expect_one_line_error(run("simulate --law table:eps.csv --out a.csv"), 3, {"line 3"});
  EXPECT_EQ(files(), std::vector<std::string>{"eps.csv"});
}

}  // namespace
}  // namespace bouncelab::cli_test
