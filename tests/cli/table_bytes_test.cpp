// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/table_bytes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace bouncelab::cli {
namespace {

TEST(TableBytes, GiveBackEveryColumnBitByBit) {
  const std::vector<double> reals{1.0 / 3.0, -0.0, INFINITY, 5e-324};
  const std::vector<std::int64_t> integers{0, -1, INT64_MAX, INT64_MIN};
  const std::vector<std::string> texts{"", "a,b", std::string("\0x", 2), std::string(100000, 'y')};
  const Table table = table_from_bytes(to_bytes(
      {{{"r", reals}, {"i", integers}, {"t", texts}, {"", std::vector<double>{}}, {"e", std::vector<std::string>{}}}}));
  ASSERT_EQ(table.columns.size(), 5U);
  EXPECT_EQ(*table.reals("r"), reals);
  EXPECT_TRUE(std::signbit((*table.reals("r"))[1]));
  EXPECT_EQ(*table.integers("i"), integers);
  EXPECT_EQ(*table.texts("t"), texts);
  EXPECT_TRUE(table.reals("")->empty());
  EXPECT_TRUE(table.texts("e")->empty());
  EXPECT_TRUE(std::isnan(table_from_bytes(to_bytes({{{"r", std::vector<double>{NAN}}}})).reals("r")->front()));
}

TEST(TableBytes, OfNoColumnsAreATableWithoutColumns) { EXPECT_TRUE(table_from_bytes(to_bytes({})).columns.empty()); }

}  // namespace
}  // namespace bouncelab::cli
