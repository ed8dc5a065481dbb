// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"
#include "support/refusal.hpp"

namespace bouncelab {
namespace {

using testing::HasSubstr;

TEST(Table, RowsOfAFileKnowTheirLinesAndOthersTheirNumber) {
  Table table;
  EXPECT_EQ(table.place_of(2), "row 3");
  for (const auto& [row, line] : {std::pair{0U, 2U}, {1U, 3U}, {2U, 7U}, {3U, 8U}, {4U, 10U}})
    table.stands_on(row, line);
  EXPECT_EQ(table.lines.size(), 3U) << "memory goes with the rows";
  EXPECT_EQ(table.place_of(1), "line 3");
  EXPECT_EQ(table.place_of(3), "line 8");
  EXPECT_EQ(table.place_of(4), "line 10");
}

template <class Read>
std::string message_of(const std::string& csv, const std::vector<ColumnSpec>& columns, Read read) {
  std::istringstream in(csv);
  return test::refusal<FileError>([&] { read(read_csv(in, "a.csv", columns)); });
}

std::string of_onsets(const std::string& csv) {
  return message_of(csv, onset_columns(), [](const Table& table) { onsets_from_table(table, "a.csv"); });
}
std::string of_samples(const std::string& csv) {
  return message_of(csv, sample_columns(), [](const Table& table) { samples_from_table(table, "a.csv"); });
}
std::string of_impacts(const std::string& row) {
  return message_of("drop,impact,t_s,v_mps,v_after_mps\n" + row + "\n", impact_columns(),
                    [](const Table& table) { impacts_from_table(table, "a.csv"); });
}

TEST(Table, AStandardErrorThatIsNoneIsRefusedByLineAndColumn) {
  EXPECT_THAT(of_onsets("t_s,sigma_t_s\n0.1,0\n"), HasSubstr("line 2, column sigma_t_s: 0 is outside (0, 1e+10]"));
  EXPECT_EQ(of_samples("v_mps,eps,sigma_eps\n1,0.9,0\n"), "no error") << "the fit takes it for not known, and says so";
  for (const char* bad : {"-1e-6", "inf", "-inf"}) {
    EXPECT_THAT(of_onsets("t_s,sigma_t_s\n0.1,1e-6\n\n0.2," + std::string(bad) + "\n"),
                HasSubstr("a.csv: line 4, column sigma_t_s: "))
        << bad;
    EXPECT_THAT(of_samples("v_mps,eps,sigma_eps\n1,0.9," + std::string(bad) + "\n"),
                HasSubstr("a.csv: line 2, column sigma_eps: "))
        << bad;
    EXPECT_THAT(of_samples("v_mps,eps,sigma_v_mps\n1,0.9," + std::string(bad) + "\n"), HasSubstr("sigma_v_mps")) << bad;
  }
  for (const char* unknown : {"", "nan"})
    EXPECT_EQ(of_onsets("t_s,sigma_t_s\n0.1," + std::string(unknown) + "\n"), "no error");
}

TEST(Table, WhatNoBallDoesIsRefusedByItsRow) {
  EXPECT_THAT(of_samples("v_mps,eps\n1,0.9\n1,1e308\n"),
              HasSubstr("line 3, column eps: 1e+308 is outside [-1000, 1000]"));
  EXPECT_THAT(of_samples("v_mps,eps\n1,0.9\n1,-1e9\n"), HasSubstr("line 3, column eps: -1e+09"));
  EXPECT_THAT(of_samples("v_mps,eps\n1e308,0.9\n"), HasSubstr("line 2, column v_mps: 1e+308"));
  EXPECT_THAT(of_impacts("0,0,0.1,1e-151,1000"), HasSubstr("line 2: v_after_mps is more than a million times v_mps"));
  EXPECT_EQ(of_samples("v_mps,eps,flags\n1,1e308,extra_impact\n"), "no error") << "a flagged row is left out anyway";
  EXPECT_EQ(of_samples("v_mps,eps\n1,\n,0.9\n1,inf\n"), "no error") << "flagged not_finite";
  EXPECT_THAT(of_samples("v_mps,eps,gravity_mps2\n1,0.9,-9.81\n"), HasSubstr("line 2, column gravity_mps2"));
  EXPECT_EQ(of_impacts("0,0,0.1,1.4,1.3"), "no error");
  EXPECT_THAT(of_impacts("0,0,0.1,1e308,1.3"), HasSubstr("line 2, column v_mps: 1e+308"));
  EXPECT_THAT(of_impacts("0,0,0.1,-1.4,1.3"), HasSubstr("line 2, column v_mps"));
  EXPECT_THAT(of_impacts("0,0,inf,1.4,1.3"), HasSubstr("line 2, column t_s"));
  EXPECT_THAT(of_impacts("0,0,,1.4,1.3"), HasSubstr("line 2, column t_s: a number is missing"));
  EXPECT_THAT(of_impacts("-1,0,0.1,1.4,1.3"), HasSubstr("line 2, column drop: -1 is outside [0, 1e+15]"));
  EXPECT_THAT(of_onsets("t_s,impact\n0.1,9223372036854775807\n"), HasSubstr("line 2, column impact"));
}

TEST(Table, ALawsTableIsCheckedByLine) {
  const auto of_law = [](const std::string& csv) {
    return message_of(csv, law_columns(), [](const Table& table) { law_from_table(table, "a.csv"); });
  };
  EXPECT_EQ(of_law("v_mps,eps\n0.1,0.9\n0.2,0.8\n"), "no error");
  EXPECT_THAT(of_law("v_mps,eps\n0.1,0.9\n\n0.1,0.8\n"), HasSubstr("line 4, column v_mps: 0.1 follows 0.1"));
  EXPECT_THAT(of_law("v_mps,eps\n0.1,nan\n"), HasSubstr("line 2, column eps"));
  EXPECT_THAT(of_law("v_mps,eps\n"), HasSubstr("holds no rows"));
}

TEST(Table, WithoutARequiredColumnIsRefusedToo) {
  EXPECT_THROW(onsets_from_table(Table{}, "a"), FileError);
  EXPECT_THROW(onsets_from_table(Table{{{"t_s", std::vector<std::string>{"0.1"}}}}, "a"), FileError);
}

TEST(Table, ARecordingThatASpreadsheetTakesForAFormulaIsNamedByItsFolder) {
  for (const std::string name : {"=1+1.wav", "+1.wav", "-a.wav", "@sum.wav", "\ta.wav", "\ra.wav"})
    EXPECT_EQ(*to_table(Onsets{{name, 0, 0, 0.1, {}, {}, {}, {}}}).texts("recording"),
              std::vector<std::string>{"./" + name});
  EXPECT_EQ(recording_cell("a=b.wav"), "a=b.wav");
  EXPECT_EQ(recording_cell(""), "");
}

}  // namespace
}  // namespace bouncelab
