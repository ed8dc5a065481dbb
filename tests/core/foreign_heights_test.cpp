// SPDX-License-Identifier: GPL-3.0-or-later
// Heights and speeds of other people's tables (docs/formats.md, "Files of other programs").
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/samples.hpp"
#include "support/refusal.hpp"

namespace bouncelab {
namespace {

using testing::HasSubstr;
using Falls = std::vector<std::vector<double>>;

TakenTable taken_of_heights(const std::string& text, const ForeignOptions& options) {
  return onsets_from_foreign(read_foreign_table(text, "x", options));
}

RestitutionSamples samples_of_speeds(const std::string& text, const std::string& columns) {
  const ForeignOptions options{"auto", "auto", columns};
  return samples_from_table(samples_from_foreign(read_foreign_table(text, "x", options)).table, "x");
}

struct HeightsCase {
  const char* text;
  ForeignOptions options;
  Falls falls_m;
  double digit_m;  ///< of the last one written, or the power of ten below it
};

const ForeignOptions kHeights{"heights", "auto", ""}, kHeightsInM{"heights", "m", ""};

TEST(ForeignHeights, AreReadAsTheDropsThatTheyProve) {
  const double in = 0.0254;
  for (const HeightsCase& c : std::vector<HeightsCase>{
           {"h (m)\n1.00\n0.81\n0.66\n", {}, {{1, .81, .66}}, .01},
           {"Höhe, cm\n100\n81\n66\n", {}, {{1, .81, .66}}, .01},
           {"Höhe, cm\n100,0\n81,0\n66,0\n", kHeights, {{1, .81, .66}}, .001},
           {"100, 81, 66\n100, 80\n", {"heights", "cm", ""}, {{1, .81, .66}, {1, .8}}, .01},
           {"1, 0,81, 0,66\n1, 0,80, 0,65\n", kHeightsInM, {{1, .81, .66}, {1, .8, .65}}, .01},
           {"n,a,b,c\n1,100,81,66\n2,100,80,\n", {"heights", "cm", "h=a,h=b,h=c"}, {{1, .81, .66}, {1, .8}}, .01},
           {"bounce;h / cm\n0;100,0\n1;81,5\n2;66,1\n", {}, {{1, .815, .661}}, .001},
           {"height_mm\n1000\n810\n", {}, {{1, .81}}, .001},
           {"y (in)\n40\n32.5\n", {}, {{40 * in, 32.5 * in}}, .001},
           {"y [ft]\n4\n3.2\n", {}, {{4 * .3048, 3.2 * .3048}}, .01},
           {"1, .81, .66\n", kHeightsInM, {{1, .81, .66}}, .01},  // the finest: people drop zeros
           {"100\n81\n66\n", {"heights", "cm", ""}, {{1, .81, .66}}, .01},
           {"h0 (m),h1 (m),h2 (m)\n1.0,.81,.66\n", kHeights, {{1, .81, .66}}, .01},
           {"drop,h (m)\n1,1.00\n1,.81\n2,1.20\n2,1.00\n", {}, {{1, .81}, {1.2, 1}}, .01},
           {"trial,h (m)\n1,.6\n1,.5\n2,.6\n2,.5\n",
            {"heights", "auto", "h=h (m),drop=trial"},
            {{.6, .5}, {.6, .5}},
            .1},
           {"h (m)\n1.00\n.81\n\n1.20\n1.00\n", {}, {{1, .81}, {1.2, 1}}, .01},
           {"h (m)\n1.00\n.81\n.40\n1.00\n.8\n", {}, {{1, .81, .4}, {1, .8}}, .01},  // by 2.5
           {"h (m)\n1.00\n.81\n.70\n.80\n.6\n", {}, {{1, .81, .7, .8, .6}}, .01},    // by a scatter of a seventh
           {"a (m);b (m)\n1.00;.81\n.50;.42\n", {"auto", "auto", "h0=1,h=2"}, {{1, .81}, {.5, .42}}, .01},
           {"a;b\n100;81\n;\n50;42\n", {"auto", "cm", "h0=a,h=b"}, {{1, .81}, {.5, .42}}, .01},
           {"Time (s);y (m)\n.4;1.0\n1;.8\n", {"heights", "auto", "h=y (m)"}, {{1, .8}}, .1}}) {
    SCOPED_TRACE(c.text);
    const TakenTable taken = taken_of_heights(c.text, c.options);
    const Onsets onsets = onsets_from_table(taken.table, "x");
    Falls falls_m;
    for (const Onset& onset : onsets) {
      if (onset.impact == 0) falls_m.emplace_back();
      ASSERT_TRUE(onset.fall_m && onset.sigma_fall_m);
      falls_m.back().push_back(*onset.fall_m);
      EXPECT_EQ(onset.errors, kOfDigits);
      EXPECT_NEAR(*onset.sigma_fall_m, c.digit_m / std::sqrt(12.0), 1e-2 * c.digit_m);
    }
    ASSERT_EQ(falls_m.size(), c.falls_m.size());
    for (std::size_t drop = 0; drop < falls_m.size(); ++drop)
      EXPECT_THAT(falls_m[drop], testing::Pointwise(testing::DoubleNear(1e-12), c.falls_m[drop]));
    EXPECT_THAT(taken.taken_for, testing::StartsWith("heights"));
    EXPECT_THAT(taken.taken_for, HasSubstr(std::to_string(falls_m.size()) + " drop"));
  }
}

TEST(ForeignHeights, ThatTheirTableDoesNotProveAreAsked) {
  struct Asked {
    const char* text;
    ForeignOptions options;
    const char* question;
    std::vector<std::string> answers;
  };
  for (const Asked& c : std::vector<Asked>{
           {"a (m);b (m)\n.81;1.0\n.42;.5\n", {}, "before and after a bounce?", {"--columns 'h0=b (m),h=a (m)'"}},
           {"a (m);b (m)\n1.0;.81\n", {}, "heights in a row", {"--as heights"}},
           {"Höhe, cm\n100,5\n81,0\n", {}, "is one number or several", {"--as heights", "--columns t=1"}},
           {"h (m);rebound\n1;.81\n1;.8\n.5;.4\n",  // below 1, as the numbers of bounces never are
            {},
            "another column of numbers",
            {"--as heights --columns 'h=h (m)'", "--as heights --columns 'h0=h (m),h=rebound'"}},
           {"trial,h (m)\n1,1.00\n1,.81\n2,1.00\n2,.81\n",
            {},
            "'trial' changes",
            {"--columns 'h=h (m),drop=trial'", "--columns 'h=h (m)'"}},
           {"1, .81, .66\n", kHeights, "in which unit", {"--as heights --unit m"}},
           {"100\n81\n", kHeights, "in which unit", {"--as heights --unit cm", "--as heights --unit mm"}},
           {"a;b\n1;.8\n", {"auto", "auto", "h0=a,h=b"}, "in which unit", {"--as heights --unit m --columns h0=a,h=b"}},
           {"a;b\n1;.8\n.9;.7\n",
            kHeights,
            "which column holds heights?",
            {"--as heights --columns h=a", "--as heights --columns h=b", "--as heights --columns h0=a,h=b"}},
           {"1\n.81\n.66\n", {}, "do not rise", {"--as intervals --unit s", "--as heights --unit m"}}}) {
    SCOPED_TRACE(c.text);
    try {
      taken_of_heights(c.text, c.options);
      ADD_FAILURE() << "no question";
    } catch (const AmbiguousTable& asked) {
      EXPECT_THAT(asked.question(), HasSubstr(c.question));
      std::vector<std::string> answers;
      for (const AmbiguousTable::Reading& reading : asked.readings())
        answers.push_back(command_line_of(reading.options));
      EXPECT_THAT(answers, testing::ElementsAreArray(c.answers));
    }
  }
}

TEST(ForeignHeights, ThatCannotBeAreErrorsWithTheirPlace) {
  const auto error = [](const char* text, const ForeignOptions& options) {
    return test::refusal<>([&] { taken_of_heights(text, options); });
  };
  EXPECT_THAT(error("h (m)\n1\n0\n.6\n", {}), HasSubstr("line 3: a height of 0; heights are above 0"));
  EXPECT_THAT(error("h (m)\n1\n\"\"\n.6\n", {}), HasSubstr("line 3, column 'h (m)': the cell is empty"));
  EXPECT_THAT(error("a;b\n1;.8\n1;0\n", {"auto", "m", "h0=a,h=b"}), HasSubstr("line 3: a bounce from or to 0"));
  EXPECT_THAT(error("a (m);b (cm)\n1;80\n", {"auto", "auto", "h0=1,h=2"}), HasSubstr("have two units; write one"));
  EXPECT_THAT(error("a (m);b (s)\n1;.8\n", {"auto", "auto", "h0=1,h=2"}), HasSubstr("another quantity: its unit is s"));
  EXPECT_THAT(error("1\n.8\n", {"heights", "s", ""}), HasSubstr("--unit s: heights are in m, cm, mm, in or ft"));
}

TEST(ForeignSpeeds, BeforeAndAfterABounceAreSignedOrNotAndOfAnyUnit) {
  for (const char* text : {"v1 (m/s);v2 (m/s)\n2.0;1.8\n1.0;0.95\n", "v1 (m/s);v2 (m/s)\n-2.0;1.8\n-1.0;0.95\n",
                           "v1 (cm/s);v2 (m/s)\n200;-1.8\n100;-0.95\n"}) {
    const RestitutionSamples samples = samples_of_speeds(text, "v_in=1,v_out=2");
    ASSERT_EQ(samples.size(), 2U);
    EXPECT_NEAR(samples[0].v_mps, 2.0, 1e-12);
    EXPECT_NEAR(samples[0].eps, 0.9, 1e-12);
    EXPECT_NEAR(samples[1].eps, 0.95, 1e-12);
    EXPECT_FALSE(samples[0].conditions.gravity_mps2);  // of no interval: no drag is in it
  }
  const RestitutionSample mph = samples_of_speeds("a (mph),b (mph)\n10,8\n", "v_in=a (mph),v_out=b (mph)").at(0);
  EXPECT_NEAR(mph.v_mps, 4.4704, 1e-12);
  // each is off by up to half a mile: 1/sqrt(12) of 10, and of 8
  EXPECT_NEAR(mph.sigma_eps.value_or(0.0), 0.8 / std::sqrt(12.0) * std::hypot(0.1, 0.125), 1e-12);
  const auto error = [](const char* text) {
    return test::refusal<>([&] { samples_of_speeds(text, "v_in=1,v_out=2"); });
  };
  EXPECT_THAT(error("a;b\n2;1\n0;1\n"), HasSubstr("line 3: a bounce of speed 0"));
  EXPECT_THAT(error("a (m);b (m)\n2;1\n"), HasSubstr("is no speed"));
  EXPECT_THAT(test::refusal<AmbiguousTable>([] { samples_of_speeds("a (m/s);b (m/s)\n2;1\n", ""); }),
              HasSubstr("--columns 'v_in=a (m/s),v_out=b (m/s)'"));
}

}  // namespace
}  // namespace bouncelab
