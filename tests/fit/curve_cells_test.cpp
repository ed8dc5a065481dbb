// SPDX-License-Identifier: GPL-3.0-or-later
// eps(v) of balls that are named, whatever their law: does the 95 % interval hold the truth in each of many kinds of
// experiment, and how much wider is it than that of somebody who knows the form of the law?
//
//   BOUNCELAB_STATISTICS=20 fit_tests --gtest_filter='*CurveCells*kink'   20 tables of each cell of one law
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "curve/smooth_curve.hpp"
#include "drawn_balls.hpp"
#include "law_oracle.hpp"
#include "support/statistics.hpp"

namespace bouncelab::fit {
namespace {

using testing::AlongDrop;
using testing::Cell;

constexpr std::size_t kNodes = 3;  // below which 10, 50 and 90 % of the speeds lie
constexpr double kReach95 = 1.959963984540054;

/// The estimates that are judged: those of fit_all, without the fits of laws beside them.
std::vector<CurveNode> stated_nodes(const RestitutionSamples& samples) {
  LeftOut left_out;
  const PartOfSamples used = usable_samples(samples, left_out);
  return SmoothCurve(*used, places_of(*used), {}).curve().nodes;
}

/// How many tables a cell has; BOUNCELAB_STATISTICS=N above 1: N.
int tables_of_a_cell(int few, int many) {
  const char* said = std::getenv("BOUNCELAB_STATISTICS");
  const int n = said != nullptr ? std::atoi(said) : 0;
  return n > 1 ? n : test::repetitions(few, many);
}

Cell cell_of(const std::string& law, int n_drops, int most_bounces) {
  Cell cell;
  cell.law = law;
  cell.n_drops = n_drops;
  cell.most_bounces = most_bounces;
  if (law == "step") cell.height_m = {0.15, 0.5};  // or its speed would not be met in the middle
  return cell;
}

Cell with_own_loss(Cell cell) {
  cell.variant = "offset";
  cell.along = AlongDrop::offset;
  cell.along_size = 1.0;
  return cell;
}

Cell with_memory(Cell cell) {
  cell.variant = "ar";
  cell.along = AlongDrop::ar;
  cell.along_size = 0.8;
  return cell;
}

Cell with(Cell cell, double Cell::*member, double value, const std::string& variant) {
  cell.*member = value;
  cell.variant = variant;
  return cell;
}

std::vector<Cell> all_cells() {
  std::vector<Cell> cells;
  for (const testing::DrawnLaw& law : testing::drawn_laws())
    for (const int n_drops : {1, 3, 10, 60}) cells.push_back(cell_of(law.name, n_drops, law.name == "step" ? 20 : 12));
  for (const char* law : {"const90", "kink", "visco", "thornton"}) {
    cells.push_back(cell_of(law, 1, 25));
    cells.push_back(cell_of(law, 10, 4));
    cells.push_back(with(cell_of(law, 10, 12), &Cell::scatter, 0.02, "scatter2"));
  }
  for (const char* law : {"const90", "kink"}) {
    cells.push_back(cell_of(law, 3, 4));
    cells.push_back(cell_of(law, 10, 25));
    for (const int n_drops : {1, 3, 10}) cells.push_back(with_own_loss(cell_of(law, n_drops, 12)));
    const Cell base = cell_of(law, 10, 12);
    cells.push_back(with_memory(base));
    cells.push_back(with(base, &Cell::skew, 2.0, "skewed"));
    cells.push_back(with(base, &Cell::outliers, 0.03, "outliers"));
    cells.push_back(with(base, &Cell::sigma_t_s, 1e-3, "times1ms"));
    cells.push_back(with(base, &Cell::threshold_mps, 0.5, "threshold"));
  }
  return cells;
}

/// What a node's intervals of all tables were.
struct NodeScore {
  int n_held = 0, n_held_by_oracle = 0;
  std::vector<double> widths, oracle_widths, errors;
};

struct CellScore {
  int n_tables = 0, n_without = 0;  ///< tables of more than one speed, and those without an interval at each node
  std::array<NodeScore, kNodes> nodes;
  double pulls2 = 0.0;  ///< sum of their squares
  double fit_s = 0.0;

  double coverage(std::size_t i) const { return static_cast<double>(nodes[i].n_held) / n_tables; }
  double mean_coverage() const { return (coverage(0) + coverage(1) + coverage(2)) / 3.0; }
  double width_over_oracle() const { return median(nodes[1].widths) / median(nodes[1].oracle_widths); }
};

void take_in(CellScore& score, const Cell& cell, int number) {
  const testing::DrawnTable table = testing::draw(cell, static_cast<std::uint64_t>(number));
  RestitutionConfig config;
  config.ball = ball_from_text(cell.its_ball().name);
  config.plate = kGlass;
  const auto start = std::chrono::steady_clock::now();
  const std::vector<CurveNode> stated = stated_nodes(restitution_samples(table.onsets, config).samples);
  score.fit_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (stated.size() == 1) return;  // drops of nearly one height and few bounces: one speed
  ++score.n_tables;
  if (stated.size() != kNodes || !std::ranges::all_of(stated, [](const auto& n) { return n.eps.ci95.has_value(); })) {
    ++score.n_without;
    return;
  }
  std::vector<double> speeds_mps;
  for (const CurveNode& node : stated) speeds_mps.push_back(node.v_mps);
  const std::vector<testing::OracleEstimate> oracle = testing::oracle_estimates(cell, table, speeds_mps);
  for (std::size_t i = 0; i < kNodes; ++i) {
    NodeScore& node = score.nodes[i];
    const Interval interval = *stated[i].eps.ci95;
    const double truth = testing::rms_eps(cell, table, speeds_mps[i]), width = interval.hi - interval.lo;
    node.n_held += truth >= interval.lo && truth <= interval.hi;
    node.widths.push_back(width);
    node.errors.push_back(stated[i].eps.value - truth);
    const double pull = node.errors.back() / stated[i].eps.se.value_or(0.5 * width / kReach95);
    score.pulls2 += pull * pull;
    node.oracle_widths.push_back(2.0 * kReach95 * oracle[i].se);
    const double oracle_error = oracle[i].eps - testing::mean_eps(cell, table, speeds_mps[i]);
    node.n_held_by_oracle += std::abs(oracle_error) <= kReach95 * oracle[i].se;
  }
}

void print_heading() {
  std::printf("%-24s %4s  %-14s %5s  %-17s %-16s %5s  %-17s %6s  %-14s %8s %5s\n", "cell", "n", "coverage", "mean",
              "width 1e-3", "oracle's", "ratio", "median error", "pulls", "oracle held", "s/table", "none");
}

/// Three numbers with their decimals.
template <class Of>
std::string three(int decimals, Of of) {
  std::string text;
  for (std::size_t i = 0; i < kNodes; ++i) {
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), "%s%.*f", i > 0 ? "/" : "", decimals, of(i));
    text += number.data();
  }
  return text;
}

void print(const Cell& cell, const CellScore& score) {
  const auto& nodes = score.nodes;
  const int n_with = score.n_tables - score.n_without;
  if (n_with == 0) return;
  std::printf("%-24s %4d  %-14s %5.3f  %-17s %-16s %5.2f  %-17s %6.2f  %-14s %8.3f %5d\n", cell.name().c_str(),
              score.n_tables, three(2, [&](auto i) { return score.coverage(i); }).c_str(), score.mean_coverage(),
              three(1, [&](auto i) { return 1e3 * median(nodes[i].widths); }).c_str(),
              three(1, [&](auto i) { return 1e3 * median(nodes[i].oracle_widths); }).c_str(), score.width_over_oracle(),
              three(2, [&](auto i) { return 1e3 * median(nodes[i].errors); }).c_str(),
              std::sqrt(score.pulls2 / (static_cast<double>(kNodes) * n_with)),
              three(2, [&](auto i) { return static_cast<double>(nodes[i].n_held_by_oracle) / n_with; }).c_str(),
              score.fit_s / score.n_tables, score.n_without);
  std::fflush(stdout);
}

CellScore score_of(const Cell& cell, int n_tables) {
  CellScore score;
  for (int number = 0; number < n_tables; ++number) take_in(score, cell, number);
  return score;
}

class CurveCells : public ::testing::TestWithParam<std::string> {};

TEST_P(CurveCells, OfOneLawHoldTheTruthInIntervalsNotMuchWiderThanNeeded) {
  print_heading();
  for (const Cell& cell : all_cells()) {
    if (cell.law != GetParam()) continue;
    // what is broken is seen in two cells, one of a law that is simple and one that is not
    const bool is_one_of_two = cell.name() == "const90_d3b12" || cell.name() == "kink_d10b12";
    const int n_tables = tables_of_a_cell(is_one_of_two ? 8 : 0, 100);
    if (n_tables == 0) continue;
    const CellScore score = score_of(cell, n_tables);
    print(cell, score);
    EXPECT_EQ(score.n_without, 0) << cell.name();
    // pointwise intervals of a smooth curve hold the truth in 95 % on average over a curve, not at each place of it
    EXPECT_GE(score.mean_coverage() * score.n_tables, test::fewest_of(score.n_tables, 0.88)) << cell.name();
    constexpr int kEnoughForAMedian = 20;  // which is then known to 10 % or so
    if (n_tables < kEnoughForAMedian || score.n_without > 0) continue;
    // who does not know that the law bends once, or that it does so as a whole, pays for it everywhere: the more the
    // better the oracle knows the rest
    const double most = cell.law == "step" ? 3.5 : cell.law == "kink" || cell.law == "thornton1" ? 3.0 : 2.5;
    EXPECT_LE(score.width_over_oracle(), most) << cell.name();
  }
}
INSTANTIATE_TEST_SUITE_P(Fit, CurveCells,
                         ::testing::Values("const75", "const90", "visco", "linear", "johnson", "thornton", "thornton1",
                                           "kink", "bump", "step"),
                         [](const auto& of) { return of.param; });

TEST(CurveCellsTogether, HoldTheTruthAsOftenAsTheySay) {
  const int n_tables = test::repetitions(0, 20);
  if (n_tables == 0) GTEST_SKIP() << "tools/check statistics";
  double n = 0.0, held = 0.0;
  for (const Cell& cell : all_cells()) {
    const CellScore score = score_of(cell, n_tables);
    n += score.n_tables;
    held += score.mean_coverage() * score.n_tables;
  }
  std::printf("together %.4f of %.0f tables\n", held / n, n);
  // the three intervals of a table are counted as one
  EXPECT_GE(held, test::fewest_of(n, 0.93));
  EXPECT_LE(held, test::most_of(n, 0.98));
}

}  // namespace
}  // namespace bouncelab::fit
