// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "support/refusal.hpp"
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
  return test::refusal<FileError>([&] { read_csv(file_with(content), wanted); });
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
  // alone in its row too
  std::ostringstream alone;
  write_csv(alone, Table{{{"x", std::vector<double>{1.0, NAN, 2.0}}}});
  EXPECT_EQ(read_csv(file_with(alone.str()), {{"x"}}).n_rows(), 3U);
}

TEST(Csv, ByteOrderMarkWindowsLineEndsAndForeignColumnsArePassedOver) {
  const Table table = read_csv(file_with("\xEF\xBB\xBFt_s, comment ,n\r\n1.5,\"a, \"\"b\"\"\",7\r\n"),
                               {{"n", ColumnType::integer}, {"t_s"}, {"comment", ColumnType::text}});
  EXPECT_EQ((*table.reals("t_s"))[0], 1.5);
  EXPECT_EQ((*table.integers("n"))[0], 7);
  EXPECT_EQ((*table.texts("comment"))[0], "a, \"b\"");
}

TEST(Csv, WhatIsWrongIsNamedByItsLineAndColumn) {
  for (const auto& [text, wanted, message] : std::vector<std::array<const char*, 3>>{
           {"a,b\n1,2\n", "t_s", "line 1: column 't_s' is missing (found: a,b)"},
           {"a,t_s\n1,2\n1,two\n", "t_s", "line 3, column t_s: 'two' is not a number"},
           {"a,b\n1,2\n3", "a", "line 3: 1 cells where the header names 2"},
           {"a,b\n1,2\n3,\"4\n5,6\n", "a", "row of line 3"},
           {"a,b\n1,\"x\"y\n", "a", "line 2: text follows the closing quote"},
           {"a,b\n1,\"x\" \n", "a", "line 2: text follows the closing quote"},
           {"t_s,x,t_s\n1,2,3\n", "t_s", "line 1: column 't_s' stands there twice"},
           {"t_s,x,x\n1,2,3\n", "t_s", "no error"},
           {"a,b\r1,2\r", "a", "no error"},
           {"a,b\n1,2\r3,4\n", "a", "LF or CRLF"},
           {"", "a", "is empty"}})
    EXPECT_THAT(message_of(text, {{wanted}}), HasSubstr(message)) << text;
  EXPECT_THROW(read_csv("/nonexistent/file.csv", {{"a"}}), FileError);
}

std::string read_back(const std::string& text) {
  std::ostringstream out;
  write_csv(out, Table{{{"recording", std::vector<std::string>{text}}, {"drop", std::vector<std::int64_t>{7}}}});
  std::istringstream in(out.str());
  const Table back = read_csv(in, "a.csv", {{"drop", ColumnType::integer}, {"recording", ColumnType::text}});
  EXPECT_EQ(*back.integers("drop"), std::vector<std::int64_t>{7});
  return back.texts("recording")->front();
}

TEST(Csv, EveryTextReadsBackToTheSameBytes) {
  for (const std::string text :
       {"new\nline.wav", "a\r\nb", "\r", "\n", "\"", "\"\"", ",", " a ", "\ta", "caf\xE9.wav", "<!--<script>.wav",
        "=HYPERLINK(\"x\")", "\x1b[31m", "12\" plate, \"third\"\n.wav", "\xEF\xBB\xBF"})
    EXPECT_EQ(read_back(text), text);
  EXPECT_EQ(read_back(std::string(4096, '"')), std::string(4096, '"'));
}

TEST(Csv, LinesAreCountedThroughQuotedLineBreaks) {
  const std::string text = "name,t_s\n\"a\nb\r\nc\",1\n\nd,2\ne,3\n";
  const Table table = read_csv(file_with(text), {{"t_s"}, {"name", ColumnType::text}});
  EXPECT_EQ(table.texts("name")->front(), "a\nb\r\nc");
  EXPECT_EQ(table.place_of(0), "line 2");
  EXPECT_EQ(table.place_of(1), "line 6");
  EXPECT_EQ(table.place_of(2), "line 7");
  EXPECT_THAT(message_of(text + "f,x\n", {{"t_s"}}), HasSubstr("line 8, column t_s: 'x' is not a number"));
}

TEST(Csv, LinesAreCountedOnInTheNextPiece) {
  std::istringstream in("a\n1\n\n\"2\"\n\n3\n");
  TableReader reader(in, "a.csv", {{"a"}});
  EXPECT_EQ(reader.next(1).place_of(0), "line 2");
  EXPECT_EQ(reader.next(1).place_of(0), "line 4");
  EXPECT_EQ(reader.next(5).place_of(0), "line 6");
  EXPECT_EQ(reader.next(5).n_rows(), 0U);
}

TEST(Csv, IntegersAreWholeDecimalAndInRange) {
  const auto integer = [](const std::string& cell) {
    return message_of("n\n" + cell + "\n", {{"n", ColumnType::integer}});
  };
  for (const char* good : {"0", "-1", "+7", " 3 ", "3.0", "2e3", "9223372036854775807", "-9223372036854775808"})
    EXPECT_EQ(integer(good), "no error") << good;
  EXPECT_THAT(integer("1.5"), HasSubstr("is not an integer"));
  EXPECT_THAT(integer("nan"), HasSubstr("is not an integer"));
  for (const char* large : {"9223372036854775808", "18446744073709551615"})
    EXPECT_THAT(integer(large), HasSubstr("beyond the range of a 64-bit integer"));
  EXPECT_THAT(integer("1e18"), HasSubstr("is not an integer"));
  for (const char* word : {"\"\"", "0x10", "1_000", "++1", "+-1", "1 2", "inf"})
    EXPECT_NE(integer(word), "no error") << word;
}

TEST(Csv, RealsAreDecimalAndInRange) {
  const auto real = [](const std::string& cell) { return message_of("x\n" + cell + "\n", {{"x"}}); };
  for (const char* good : {"1", "+.5", "-1e-3", "nan", "NaN", "inf", "5e-324"})
    EXPECT_EQ(real(good), "no error") << good;
  for (const char* word : {"0x1p3", "1e400", "-1e400", "+-1", "1d5", "1.2.3", "--1"})
    EXPECT_NE(real(word), "no error") << word;
}

TEST(Csv, WhatIsNoTableIsRefusedAtOnceInAShortLine) {
  EXPECT_THAT(message_of(std::string("RIFF\x24\0\0\0WAVE", 12), {{"a"}}), HasSubstr("line 1 holds a byte 0"));
  EXPECT_THAT(message_of(std::string("\xFF\xFE"
                                     "a\0\n",
                                     5),
                         {{"a"}}),
              HasSubstr("cut off within a character of UTF-16"));
  EXPECT_EQ(message_of(std::string("\xFF\xFE"
                                   "a\0\n\0",
                                   6),
                       {{"a"}}),
            "no error");
  EXPECT_EQ(message_of(std::string("\xFF\xFE\0\0a\0\0\0\n\0\0\0", 12), {{"a"}}), "no error");
  EXPECT_THAT(message_of("PK\x03\x04", {{"a"}}), HasSubstr("is a ZIP archive"));
  EXPECT_THAT(message_of(std::string(100'000'000, ','), {{"a"}}), HasSubstr("line 1 is longer than 1048576 bytes"));
  EXPECT_THAT(message_of("a\n1\n\"" + std::string(3'000'000, '\n'), {{"a"}}), HasSubstr("longer than 1048576 bytes"));
  EXPECT_THAT(message_of("a\n" + std::string(100'000'000, 'x'), {{"a"}}), HasSubstr("line 2 is longer"));
  const std::string cell = message_of("a\n" + std::string(1'000'000, '\x1b'), {{"a"}});
  EXPECT_LT(cell.size(), 500U);
  EXPECT_THAT(cell, HasSubstr("\\x1b"));
  EXPECT_THAT(cell, testing::Not(HasSubstr("\x1b")));
  EXPECT_LT(message_of(std::string(1'000'000, ','), {{"a"}}).size(), 500U);
  std::ifstream zeros("/dev/zero", std::ios::binary);
  EXPECT_THROW(read_csv(zeros, "/dev/zero", {{"a"}}), FileError);
}

}  // namespace
}  // namespace bouncelab
