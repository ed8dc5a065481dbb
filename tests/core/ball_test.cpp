// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/ball.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "bouncelab/core/error.hpp"
#include "support/refusal.hpp"

namespace bouncelab {
namespace {

constexpr double kRounding = 1e-14;  // a few operations in double precision

std::string message_of(const std::string& text) {
  return test::refusal<InvalidArgument>([&] { ball_from_text(text); });
}

TEST(BallCatalogue, HasEachBallAndPlateOnceWithASource) {
  std::set<std::string> balls, plates;
  for (const BallKind& kind : ball_kinds()) {
    EXPECT_TRUE(balls.insert(kind.name).second) << kind.name;
    EXPECT_GT(kind.source.size(), 8U) << kind.name;
    EXPECT_GT(kind.material.density_kgpm3, 50.0) << kind.name;
    EXPECT_TRUE(kind.inertia_factor >= kSolidBallInertia && kind.inertia_factor < 2.0 / 3.0) << kind.name;
    EXPECT_EQ(kind.material.hertzian, kind.material.youngs_modulus_pa > 0.0) << kind.name;
  }
  for (const PlateKind& kind : plate_kinds()) {
    EXPECT_TRUE(plates.insert(kind.name).second) << kind.name;
    EXPECT_GT(kind.source.size(), 8U) << kind.name;
    EXPECT_TRUE(kind.material.youngs_modulus_pa > 1e9 && kind.loss_factor > 0.0) << kind.name;
    EXPECT_EQ(plate_from_text(kind.name), kind.material);
    EXPECT_EQ(plate_loss_factor(kind.material), kind.loss_factor);
  }
}

TEST(BallCatalogue, BallsOfSportsWeighWhatTheirRulesSay) {
  const auto mass_g = [](const char* name) { return 1e3 * mass_kg(ball_from_text(name)); };
  EXPECT_NEAR(mass_g("table-tennis"), 2.7, 2.7 * kRounding);
  EXPECT_NEAR(mass_g("golf"), 45.93, 45.93 * kRounding);
  EXPECT_TRUE(mass_g("tennis") > 56.0 && mass_g("tennis") < 59.4);
  EXPECT_TRUE(mass_g("basketball") > 580 && mass_g("basketball") < 620);
  EXPECT_NEAR(mass_g("steel:6mm"), 0.8935, 5e-5);  // 4/3 pi (3 mm)^3 7900 kg/m^3, to the digits given
}

TEST(BallCatalogue, BallsOfSportsReboundAsTheirRulesAsk) {
  const auto rule = [](const char* name) { return rebound_rule(ball_from_text(name)); };
  ASSERT_TRUE(rule("tennis") && rule("table-tennis"));
  EXPECT_EQ(rule("tennis")->height_m, 2.54);
  EXPECT_EQ(rule("tennis,mass=56g"), rule("tennis"));  // 3 % lighter than the catalogue's
  EXPECT_FALSE(rule("tennis,mass=45g"));
  EXPECT_FALSE(rule("squash"));  // of the size of a table-tennis ball
  EXPECT_FALSE(rule("steel:67mm"));
  for (const BallKind& kind : ball_kinds())
    if (kind.rebound) {
      EXPECT_LT(kind.rebound->least_m, kind.rebound->most_m) << kind.name;
      EXPECT_LT(kind.rebound->most_m, kind.rebound->height_m) << kind.name;
      EXPECT_THAT(kind.rebound->source, ::testing::StartsWith(kind.rebound->by));
    }
}

TEST(BallCatalogue, ADescriptionReadsBackAsTheSameBall) {
  for (const BallKind& kind : ball_kinds())
    for (const std::string size :
         {":6mm", ":r=1.7cm", ":d=0.123456789m,inertia=0.5", ":7mm,mass=1.1g,contact-time=80us"}) {
      const bool sized = kind.diameter_m && size.find("mass") == std::string::npos;
      const Ball ball = ball_from_text(kind.name + (sized ? "" : size));
      EXPECT_EQ(ball_from_text(to_text(ball)), ball) << kind.name << size << " -> " << to_text(ball);
    }
  for (const std::string text : {"steel:6mm", "table-tennis", "superball:27mm", "golf", "table-tennis,inertia=0.6667"})
    EXPECT_EQ(to_text(ball_from_text(text)), text);
  EXPECT_EQ(to_text(Ball{}), "steel:6mm");
  EXPECT_EQ(ball_from_text("steel:6mm"), Ball{});  // the paper's, bit for bit
  for (const std::string plate : {"wood,density=700", "glass,density=2600", "E=71.3GPa,nu=0.22,density=2520"})
    EXPECT_EQ(plate_from_text(plate_text(plate_from_text(plate))), plate_from_text(plate)) << plate;
}

TEST(BallCatalogue, ASizeIsADiameterUnlessSaidOtherwise) {
  EXPECT_EQ(ball_from_text("glass:16mm").radius_m, 0.008);
  EXPECT_EQ(ball_from_text("glass:d=16mm").radius_m, 0.008);
  EXPECT_EQ(ball_from_text("glass:r=8mm").radius_m, 0.008);
  EXPECT_EQ(ball_from_text("glass:radius=0.8cm").radius_m, 0.008);
  EXPECT_EQ(describe(ball_from_text("glass:16mm")),
            "glass:16mm (diameter 16 mm, radius 8 mm, mass 5.362 g, J = 0.4 m R^2)");
}

TEST(BallCatalogue, WordsOfEveryDayAskNothing) {
  EXPECT_EQ(to_text(ball_from_text("marble")), "glass:16mm");
  EXPECT_EQ(to_text(ball_from_text("marble:25mm")), "glass:25mm");
  EXPECT_EQ(to_text(ball_from_text("Glass marble")), "glass:16mm");
  EXPECT_EQ(to_text(ball_from_text("marble 25mm")), "glass:25mm");
  EXPECT_EQ(to_text(ball_from_text("steel ball 6 mm")), "steel:6mm");
  EXPECT_EQ(to_text(ball_from_text("golf balls")), "golf");
  for (const char* word : {"bouncy ball", "bouncy-ball", "Bouncy_Ball", "bouncy"})
    EXPECT_EQ(to_text(ball_from_text(word)), "superball:27mm") << word;
  for (const char* word : {"ping-pong", "ping pong ball", "table tennis ball", "Table-Tennis"})
    EXPECT_EQ(to_text(ball_from_text(word)), "table-tennis") << word;
  EXPECT_EQ(to_text(ball_from_text("soccer ball")), "football");
  EXPECT_EQ(to_text(ball_from_text("tennis ball")), "tennis");
  EXPECT_EQ(to_text(ball_from_text("pool ball")), "billiard");
  EXPECT_THROW(plate_from_text("marble"), InvalidArgument);  // the stone, which is not in the catalogue
}

TEST(BallCatalogue, NumbersAloneMakeABall) {
  const Ball shell = ball_from_text("radius=20mm,mass=2.7g,inertia=0.667");
  EXPECT_NEAR(mass_kg(shell), 2.7e-3, 2.7e-3 * kRounding);
  EXPECT_NEAR(moment_of_inertia_kgm2(shell), 0.667 * 2.7e-3 * 4e-4, 1e-20);  // rounding of 7.2e-7
  EXPECT_FALSE(shell.material.hertzian);
  const Ball steel = ball_from_text("radius=3mm,density=7900,E=200GPa,nu=0.3");
  EXPECT_EQ(steel, Ball{});
}

TEST(BallCatalogue, WhatIsNotUnderstoodIsAnsweredWithWhatIs) {
  using testing::AllOf;
  using testing::HasSubstr;
  EXPECT_THAT(message_of("stel:6mm"),
              AllOf(HasSubstr("'stel'"), HasSubstr("did you mean steel?"), HasSubstr("bouncelab balls")));
  for (const auto& [word, name] :
       {std::pair("Tischtennisball", "table-tennis"), std::pair("Fu\u00dfball", "football"),
        std::pair("Stahlkugel:6mm", "steel"), std::pair("balle de tennis de table", "table-tennis"),
        std::pair("Murmel", "marble"), std::pair("canica", "marble")})
    EXPECT_THAT(message_of(word), HasSubstr(std::string("did you mean ") + name + "?"));
  EXPECT_THAT(message_of("potato"), AllOf(HasSubstr("'potato'"), HasSubstr("bouncelab balls")));
  EXPECT_THAT(message_of("steel"), HasSubstr("steel:6mm is a diameter of 6 mm"));
  EXPECT_THAT(message_of("steel:6"), HasSubstr("such as 6mm"));
  EXPECT_THAT(message_of("steel:6mm,radius=3mm"), HasSubstr("not both"));
  EXPECT_THAT(message_of("steel:6mm,mass=1g,density=7800"), HasSubstr("not both"));
  EXPECT_THAT(message_of("tennis:6mm"), HasSubstr("needs its mass= too"));
  EXPECT_THAT(message_of("radius=3mm"), HasSubstr("mass= or density="));
  EXPECT_THAT(message_of("density=7900"), HasSubstr("radius= or diameter="));
  EXPECT_THAT(message_of("radius=3mm,mass=1kg"), HasSubstr("density of"));
  EXPECT_THAT(message_of("rubber:20mm,E=5MPa"), HasSubstr("give both"));
  EXPECT_THAT(message_of("steel:6mm,colour=red"), HasSubstr("'colour' is none of radius"));
  EXPECT_THAT(message_of("steel:6mm,7800"), HasSubstr("KEY=VALUE"));
  for (const char* text :
       {"", ",", ":", "steel:", "steel:nanmm", "steel:infm", "steel:-3mm", "steel:6mm,", "=", "steel:6mm,nu=0.5"})
    EXPECT_NE(message_of(text), "no error") << text;
  EXPECT_THROW(plate_from_text("ice"), InvalidArgument);
  EXPECT_THROW(plate_from_text("E=70GPa,nu=0.2"), InvalidArgument);
}

TEST(BallCatalogue, TheNearestNameIsOneOrTwoLettersAway) {
  EXPECT_EQ(nearest_name("tabel-tennis", {"tennis", "table-tennis"}), "table-tennis");
  EXPECT_EQ(nearest_name("xyz", {"steel", "glass"}), "");
  EXPECT_EQ(nearest_name(std::string(1000, 'a'), {"a"}), "");
}

TEST(Ball, AShellsInertiaIsThatOfTwoSpheres) {
  // a sphere of density 1 and radius 1 less one of radius a; thin walls: 2/3
  for (const double a : {0.2, 0.5, 0.9}) {
    const double mean = 1.0 - a * a * a;
    EXPECT_NEAR(shell_inertia_factor(mean, 1.0), 0.4 * (1.0 - std::pow(a, 5)) / mean, 10 * kRounding);
  }
  EXPECT_NEAR(shell_inertia_factor(1e-6, 1.0), 2.0 / 3.0, 1e-6);
}

TEST(Ball, ContactIsHertzsWhereHeHoldsElseAsMeasured) {
  // 2 cm of glass on glass: 2.943 (15 m / (16 E* sqrt R))^(2/5), m = 10.47 g, E* = 36.78 GPa, R = 1 cm
  EXPECT_NEAR(contact_duration(ball_from_text("glass:2cm"), kGlass)->at_1_mps_s * 1e6, 69.08, 0.01);
  EXPECT_EQ(contact_duration(Ball{}, kGlass)->at(0.5), hertz_contact_time_s(Ball{}, kGlass, 0.5));
  EXPECT_EQ(contact_duration(Ball{}, plate_from_text("wood")), std::nullopt);
  for (const char* by_numbers : {"radius=20mm,mass=2.7g", "radius=20mm,mass=2.7g,inertia=0.65", "d=3cm,density=1100"}) {
    EXPECT_EQ(contact_duration(ball_from_text(by_numbers), kGlass), std::nullopt) << by_numbers;
    EXPECT_EQ(ball_from_text(to_text(ball_from_text(by_numbers))), ball_from_text(by_numbers)) << by_numbers;
  }
  EXPECT_NEAR(contact_duration(ball_from_text("table-tennis"), kGlass)->at(1.0), 0.8e-3, 0.3e-3);  // measured, 0.5 to 1
  EXPECT_EQ(contact_duration(ball_from_text("table-tennis,contact-time=0.8ms"), kGlass)->at(2.0), 0.8e-3);
}

TEST(BallText, SizesAndDensitiesInOtherUnitsAreRefusedWithTheirRange) {
  for (const char* text : {"steel:10mm,density=7.9", "steel:10m", "steel:r=10m"})
    EXPECT_THROW(ball_from_text(text), InvalidArgument) << text;
  EXPECT_NO_THROW(ball_from_text("diameter=40cm,mass=100g,E=1MPa,nu=0.3"));  // blown up: 3 kg/m^3
}

}  // namespace
}  // namespace bouncelab
