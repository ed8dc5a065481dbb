// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/description.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "bouncelab/core/error.hpp"
#include "support/refusal.hpp"

namespace bouncelab {
namespace {

enum class Kind { round, flat };
std::string to_string(Kind kind) { return kind == Kind::round ? "round" : "flat"; }

struct Whole {
  std::int64_t n = 3;
  std::optional<double> speed_mps, height_m;
  std::string name = "a";
  std::vector<double> nodes{0.25, 0.6};
  std::vector<double> start_m{0.0, 1.5};
  bool drag = false;
  Kind kind = Kind::flat;
};

Description members_of(const Whole*) {
  static constexpr Member whole[]{
      member<&Whole::n>("n", "Number").within(1, 1'000'000'000),
      member<&Whole::speed_mps>("speed_mps", "Speed"),
      member<&Whole::height_m>("height_m", "Height [m]").within(0.0, 1.0).unknown_as("0"),
      member<&Whole::name>("name", "Name"),
      member<&Whole::nodes>("nodes", "Nodes").within(0.0, 1.0),
      member<&Whole::start_m>("start_m", "Start").with_commas("X,Y", 2, 2).within(-9.0, 9.0),
      member<&Whole::drag>("drag", "Air"),
      computed(
          "kind", [](const Whole& w) { return w.kind; }, "Form")
          .one_of("round,flat")
          .set_by([](void* whole, const Value& word) {
            static_cast<Whole*>(whole)->kind = std::get<std::string>(word) == "round" ? Kind::round : Kind::flat;
          })};
  return whole;
}

const Member& member_named(const std::string& name) {
  for (const Member& m : members_of(static_cast<const Whole*>(nullptr)))
    if (m.name == name) return m;
  throw Error("no member " + name);
}

/// The message with which a text is refused.
std::string refusal(const std::string& name, const std::string& text) {
  return test::refusal<InvalidArgument>([&] { value_from_text(member_named(name), text); });
}

TEST(Description, ATextSetsTheMemberItIsReadFor) {
  Whole whole;
  const auto set = [&](const std::string& name, const std::vector<std::string>& texts) {
    member_named(name).set(&whole, value_from_texts(member_named(name), texts));
  };
  set("n", {"7", "8"});
  set("speed_mps", {"1e-3"});
  set("nodes", {"0.3", "0.5,0.75"});
  set("start_m", {"1,2"});
  set("kind", {"round"});
  set("drag", {"true"});
  EXPECT_EQ(whole.n, 8);
  EXPECT_EQ(whole.speed_mps, 1e-3);
  EXPECT_EQ(whole.nodes, (std::vector{0.3, 0.5, 0.75}));
  EXPECT_EQ(whole.start_m, (std::vector{1.0, 2.0}));
  EXPECT_EQ(whole.kind, Kind::round);
  EXPECT_TRUE(whole.drag);
}

TEST(Description, ATextOutsideIsRefusedWithWhatItMustBe) {
  EXPECT_EQ(refusal("n", "0x10"), "'0x10' must be a decimal integer from 1 to 1000000000");
  EXPECT_EQ(refusal("n", "0"), "'0' must be a decimal integer from 1 to 1000000000");
  EXPECT_EQ(refusal("nodes", "inf"), "'inf' must be a finite decimal number from 0 to 1");
  EXPECT_EQ(refusal("nodes", "0.3,,1"), "'' must be a finite decimal number from 0 to 1");
  EXPECT_EQ(refusal("height_m", "2cm"), "'2cm' must be a finite decimal number from 0 to 1, in m");
  EXPECT_EQ(refusal("start_m", "1"), "'1' must be 2 finite decimal numbers, X,Y");
  EXPECT_EQ(refusal("start_m", "1,10"), "'1,10' must be numbers from -9 to 9");
  EXPECT_EQ(refusal("kind", "square"), "'square' must be one of round, flat");
}

TEST(Description, WhatAProgramFillsIsRefusedAsWhatIsTyped) {
  EXPECT_NO_THROW(check_options(Whole{}));
  const auto refused = [](auto set) {
    Whole whole;
    set(whole);
    return test::refusal<InvalidArgument>([&] { check_options(whole); });
  };
  EXPECT_EQ(refused([](Whole& w) { w.n = -1; }), "n: '-1' must be a decimal integer from 1 to 1000000000");
  EXPECT_EQ(refused([](Whole& w) { w.speed_mps = NAN; }), "speed_mps: 'nan' must be a finite decimal number");
  EXPECT_EQ(refused([](Whole& w) {
              w.nodes = {0.5, INFINITY};
            }),
            "nodes: 'inf' must be a finite decimal number from 0 to 1");
  EXPECT_EQ(refused([](Whole& w) { w.start_m = {1.0}; }), "start_m: '1' must be 2 finite decimal numbers, X,Y");
  EXPECT_EQ(refused([](Whole& w) { w.height_m = 0.0; }),
            "height_m: '0' stands for a value that is not known; leave it empty");
}

TEST(Description, TheDefaultAsTextIsReadBackAsTheSame) {
  const Whole whole;
  for (const char* name : {"n", "start_m", "kind", "drag", "name"}) {
    const Member& m = member_named(name);
    EXPECT_EQ(value_from_text(m, text_of(m.get(&whole))), m.get(&whole)) << name;
  }
}

}  // namespace
}  // namespace bouncelab
