// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/table_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "support/refusal.hpp"

namespace bouncelab::stages {
namespace {

using testing::HasSubstr;

const std::vector<ColumnSpec> kWanted{{"drop", ColumnType::integer, false},
                                      {"t_s"},
                                      {"sigma_t_s", ColumnType::real, false},
                                      {"recording", ColumnType::text, false}};

Table read(const std::string& text) {
  std::istringstream in(text);
  return json_lines_reader(in, "a.jsonl", kWanted)->next(SIZE_MAX);
}

std::string message_of(const std::string& text) {
  return test::refusal<FileError>([&] { read(text); });
}

TEST(JsonLines, AColumnThatAppearsInALaterRowIsThere) {
  const Table table = read("{\"t_s\":1}\n\n{\"t_s\":2,\"sigma_t_s\":0.5,\"recording\":\"a\"}\n{\"t_s\":null}\n");
  EXPECT_EQ(table.columns.size(), 3U);
  EXPECT_TRUE(std::isnan(table.reals("sigma_t_s")->at(0)));
  EXPECT_EQ(table.reals("sigma_t_s")->at(1), 0.5);
  EXPECT_EQ(*table.texts("recording"), (std::vector<std::string>{"", "a", ""}));
  EXPECT_TRUE(std::isnan(table.reals("t_s")->at(2)));
  EXPECT_EQ(table.place_of(0), "line 1");
  EXPECT_EQ(table.place_of(1), "line 3");
}

TEST(JsonLines, InPiecesAColumnIsThereFromTheFirstRowThatHasIt) {
  std::istringstream in("{\"t_s\":1}\n\n{\"t_s\":2,\"sigma_t_s\":0.5}\n{\"t_s\":3}\n");
  const auto reader = json_lines_reader(in, "a.jsonl", kWanted);
  const Table first = reader->next(1), second = reader->next(1), third = reader->next(7), none = reader->next(7);
  EXPECT_FALSE(first.has("sigma_t_s"));
  EXPECT_EQ(*second.reals("sigma_t_s"), std::vector<double>{0.5});
  EXPECT_EQ(second.place_of(0), "line 3");
  EXPECT_EQ(*third.reals("t_s"), std::vector<double>{3.0});
  EXPECT_TRUE(std::isnan(third.reals("sigma_t_s")->front()));
  EXPECT_EQ(third.place_of(0), "line 4");
  EXPECT_EQ(none.n_rows(), 0U);
  EXPECT_TRUE(none.has("t_s"));
}

TEST(JsonLines, IntegersAreWholeInRangeAndInAllRowsOrInNone) {
  const auto drop = [](const std::string& value) { return message_of("{\"t_s\":1,\"drop\":" + value + "}\n"); };
  for (const char* good : {"0", "-1", "3.0", "9223372036854775807"}) EXPECT_EQ(drop(good), "no error") << good;
  EXPECT_THAT(drop("18446744073709551615"), HasSubstr("line 1: key drop: 18446744073709551615 is beyond"));
  for (const char* bad : {"9223372036854775808", "1e300", "1.5", "true", "\"1\"", "[1]", "{}"})
    EXPECT_THAT(drop(bad), HasSubstr("key drop")) << bad;
  EXPECT_THAT(message_of("{\"t_s\":1}\n\n{\"t_s\":2,\"drop\":1}\n"),
              HasSubstr("line 1: the key 'drop' is missing, but line 3 has it"));
  EXPECT_THAT(message_of("{\"t_s\":1,\"drop\":0}\n\n{\"t_s\":2,\"drop\":null}\n"),
              HasSubstr("line 3: the key 'drop' is missing, but line 1 has it"));
  std::istringstream in("{\"t_s\":1}\n{\"t_s\":2,\"drop\":0}\n");
  const auto in_pieces = json_lines_reader(in, "a.jsonl", kWanted);
  in_pieces->next(1);
  EXPECT_THROW(in_pieces->next(1), FileError);
}

TEST(JsonLines, WhatIsNoTableIsRefusedByItsLine) {
  for (const char* bad : {"[1]", "1", "\"t_s\"", "null", "true", "{", "{\"t_s\":}", "{\"t_s\":1}x", "{\"t_s\":1}{}",
                          "{'t_s':1}", "\xFF", "{\"t_s\":\"\xFF\"}", "{\"recording\":\"\\u0000\"}"})
    EXPECT_THAT(message_of("{\"t_s\":1}\n\n" + std::string(bad) + "\n"), HasSubstr("a.jsonl: line 3")) << bad;
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {std::string("{\"t_s\":1}\n\0", 11), "line 2 holds a byte 0"},
           {"{\"t_s\":1}\n" + std::string(100'000'000, ' '), "line 2 is longer than"},
           {" \n", "is empty"},
           {"{\"t_s\":1e400}", "beyond the range of a 64-bit real"},
           {"{\"t_s\":null,\"t_s\":2}\n", "line 1: key t_s: stands there twice"},
           {"\n{\"drop\":1}\n", "line 2: the key 't_s' is missing"}})
    EXPECT_THAT(message_of(text), HasSubstr(words));
}

TEST(JsonLines, NestingInForeignKeysIsPassedOverAtAnyDepth) {
  const std::string deep = std::string(400'000, '[') + std::string(400'000, ']');
  EXPECT_EQ(read("{\"x\":{\"t_s\":[{\"t_s\":5}],\"drop\":{}},\"t_s\":1,\"y\":" + deep + "}").reals("t_s")->at(0), 1.0);
  EXPECT_NE(message_of(std::string(500'000, '[')), "no error");
}

TEST(JsonLines, NamesThatAreNotUtf8ComeBackByteForByte) {
  const std::vector<std::string> names{"caf\xE9.wav", "a\nb", "\xEE\xBE\x80", "=x", ""};
  std::ostringstream out;
  write_json_lines(out, {{{"t_s", std::vector<double>{1, 2, 3, NAN, INFINITY}}, {"recording", names}}});
  EXPECT_EQ(*read(out.str()).texts("recording"), names);
}

}  // namespace
}  // namespace bouncelab::stages
