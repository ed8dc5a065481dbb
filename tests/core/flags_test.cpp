// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/flags.hpp"

#include <gtest/gtest.h>

namespace bouncelab {
namespace {

TEST(Flags, KeepTheOrderInWhichTheyWereSet) {
  Flags flags;
  flags.add(Flag::overlap);
  flags.add(Flag::clipped);
  flags.add(Flag::overlap);
  EXPECT_EQ(flags.text(), "overlap|clipped");
  EXPECT_EQ(flags.first_word(), "overlap");
  EXPECT_NE(flags, (Flags{Flag::clipped, Flag::overlap}));
}

TEST(Flags, AreWholeWords) {
  const Flags flags = Flags::from_text("overlapping|unclipped|not_finite");
  EXPECT_FALSE(flags.has(Flag::overlap));
  EXPECT_FALSE(flags.has(Flag::clipped));
  EXPECT_TRUE(flags.has(Flag::not_finite));
  EXPECT_FALSE(Flags().has(Flag::overlap));
}

TEST(Flags, KeepWordsThatAreNotOurs) {
  Flags flags = Flags::from_text("noisy|clipped||");
  flags.add(Flag::clipped);
  EXPECT_EQ(flags.text(), "noisy|clipped||");
  flags.add(Flag::by_hand);
  EXPECT_EQ(flags.text(), "noisy|clipped|||by_hand");
  EXPECT_EQ(flags.first_word(), "noisy");
}

TEST(Flags, OfAnEmptyCellAreNone) {
  EXPECT_TRUE(Flags::from_text("").empty());
  EXPECT_EQ(Flags().text(), "");
  EXPECT_EQ(Flags().first_word(), "");
}

TEST(Flags, AreFoundByTheWordsThatTheyWrite) {
  for (int k = 0; k <= static_cast<int>(Flag::overlap); ++k) {
    const auto flag = static_cast<Flag>(k);
    EXPECT_EQ(flag_named(name_of(flag)), flag);
    EXPECT_TRUE(Flags::from_text(std::string(name_of(flag))).has(flag)) << name_of(flag);
  }
  EXPECT_FALSE(flag_named("clip").has_value());
  EXPECT_FALSE(flag_named("").has_value());
}

}  // namespace
}  // namespace bouncelab
