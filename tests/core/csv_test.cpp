// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

using testing::HasSubstr;

std::filesystem::path file_with(const std::string& content) {
  static const test::TemporaryFolder folder;
  const auto path = folder / "a.csv";
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

std::string message_of(const std::string& content, const std::vector<ColumnSpec>& wanted) {
  try {
    read_csv(file_with(content), wanted);
  } catch (const FileError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Csv, EveryDoubleReadsBackToTheSameBits) {
  const std::vector<double> values{0.1, 1.0 / 3.0, 6.02214076e23, 5e-324, -0.0, 12345.678901234567};
  const Table table{{{"x", values}}};
  std::ostringstream out;
  write_csv(out, table);
  const Table back = read_csv(file_with(out.str()), {{"x"}});
  EXPECT_EQ(*back.reals("x"), values);
}

TEST(Csv, AnEmptyRealIsNotKnownAndStaysEmpty) {
  const Table table = read_csv(file_with("a,b\n1,\n2,3\n"), {{"a"}, {"b"}});
  EXPECT_TRUE(std::isnan((*table.reals("b"))[0]));
  std::ostringstream out;
  write_csv(out, table);
  EXPECT_EQ(out.str(), "a,b\n1,\n2,3\n");
}

TEST(Csv, ByteOrderMarkWindowsLineEndsAndForeignColumnsArePassedOver) {
  const Table table = read_csv(file_with("\xEF\xBB\xBFt_s, comment ,n\r\n1.5,\"a, \"\"b\"\"\",7\r\n"),
                               {{"n", ColumnType::integer}, {"t_s"}, {"comment", ColumnType::text}});
  EXPECT_EQ((*table.reals("t_s"))[0], 1.5);
  EXPECT_EQ((*table.integers("n"))[0], 7);
  EXPECT_EQ((*table.texts("comment"))[0], "a, \"b\"");
}

TEST(Csv, TextWithCommasAndQuotesSurvivesTheRoundTrip) {
  const Table table{{{"recording", std::vector<std::string>{"drop, \"third\".wav"}}}};
  std::ostringstream out;
  write_csv(out, table);
  const Table back = read_csv(file_with(out.str()), {{"recording", ColumnType::text}});
  EXPECT_EQ((*back.texts("recording"))[0], "drop, \"third\".wav");
}

TEST(Csv, AMissingColumnIsNamedWithWhatWasFound) {
  EXPECT_THAT(message_of("a,b\n1,2\n", {{"t_s"}}), HasSubstr("line 1: column 't_s' is missing (found: a,b)"));
}

TEST(Csv, AWordForANumberIsNamedByLineAndColumn) {
  EXPECT_THAT(message_of("a,t_s\n1,2\n1,two\n", {{"t_s"}}), HasSubstr("line 3, column t_s: 'two' is not a number"));
}

TEST(Csv, ACutOffLineIsNamed) {
  EXPECT_THAT(message_of("a,b\n1,2\n3", {{"a"}}), HasSubstr("line 3: 1 cells where the header names 2"));
}

TEST(Csv, RowsKnowTheirLineWhereBlankLinesStandBetween) {
  const Table table = read_csv(file_with("a\n\n1\n2\n\n\n3\n\n"), {{"a"}});
  ASSERT_EQ(table.n_rows(), 3U);
  EXPECT_EQ(table.line_of(0), 3U);
  EXPECT_EQ(table.line_of(1), 4U);
  EXPECT_EQ(table.line_of(2), 7U);
}

TEST(Csv, AnEmptyFileSaysSo) { EXPECT_THAT(message_of("", {{"a"}}), HasSubstr("is empty")); }

TEST(Csv, AMissingFileSaysSo) { EXPECT_THROW(read_csv("/nonexistent/file.csv", {{"a"}}), FileError); }

}  // namespace
}  // namespace bouncelab
