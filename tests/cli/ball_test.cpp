// SPDX-License-Identifier: GPL-3.0-or-later
// `bouncelab balls`, and --ball and --plate of every command that takes them.
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/table.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Json = nlohmann::json;

class BallOption : public ProgramTest {
 protected:
  Json json_of(const std::string& arguments) const {
    const Result result = run(arguments + " --json");
    EXPECT_LE(result.exit_code, 1) << arguments << "\n" << result.err;  // 1: few samples identify no constants
    return Json::parse(result.out);
  }
  Json meta(const std::string& name) const { return Json::parse(content_of(folder_ / (name + ".meta.json"))); }
  /// Onsets of a ball that loses 3 % of its speed in each bounce, without jitter.
  void write_onsets() const {
    std::string text = "drop,impact,t_s,sigma_t_s\n";
    double t = 0.2, interval = 0.28;
    for (int k = 0; k < 60; ++k) {
      text += "0," + std::to_string(k) + "," + std::to_string(t) + ",1e-6\n";
      t += interval;
      interval *= 0.97;
    }
    write("o.csv", text);
  }
  double contact_us(const std::string& truth) const {
    std::istringstream lines(content_of(folder_ / truth));
    std::string header, row, name, cell;
    std::getline(lines, header);
    std::getline(lines, row);
    std::istringstream names(header), cells(row);
    while (std::getline(names, name, ',') && std::getline(cells, cell, ','))
      if (name == "contact_time_s") return 1e6 * std::stod(cell);
    return 0.0;
  }
};

TEST_F(BallOption, TheListHasNumbersAndSources) {
  const Result list = run("balls");
  EXPECT_EQ(list.exit_code, 0);
  for (const char* what :
       {"table-tennis", "steel", "superball", "concrete", "diameter[mm]", "--ball steel:6mm", "ITTF"})
    EXPECT_THAT(list.out, testing::HasSubstr(what));
  const Json j = json_of("balls");
  EXPECT_EQ(j.at("balls").at(0).at("name"), "table-tennis");
  EXPECT_NEAR(j.at("balls").at(0).at("mass_kg").get<double>(), 2.7e-3, 1e-15);
  EXPECT_EQ(j.at("balls").at(0).at("radius_m"), 0.02);
  EXPECT_TRUE(j.at("balls").at(0).at("youngs_modulus_pa").is_null());
  for (const char* list_name : {"balls", "plates"})
    for (const Json& kind : j.at(list_name)) EXPECT_GT(kind.at("source").get<std::string>().size(), 8u);
}

TEST_F(BallOption, TheSoundIsThatOfTheBall) {
  // R = 2 cm, 2500 kg/m^3, as stiff as steel: Hertz says 118 us at 1 m/s, not the 28 us of the 3 mm steel ball
  const std::string heavy = "radius=2cm,density=2500,E=200GPa,nu=0.3";
  write("i.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.1,1,0.9\n0,1,0.3,0.9,0.8\n");
  ASSERT_EQ(run("synthesize i.csv --rate 24000 --out heavy.wav --ball " + heavy).exit_code, 0);
  ASSERT_EQ(run("synthesize i.csv --rate 24000 --out steel.wav").exit_code, 0);
  EXPECT_NEAR(contact_us("heavy.truth.csv"), 117.5, 0.1);  // 2.943 (15 m / (16 E* sqrt R))^(2/5)
  EXPECT_NEAR(contact_us("steel.truth.csv"), 27.9, 0.1);
  EXPECT_NE(content_of(folder_ / "heavy.wav"), content_of(folder_ / "steel.wav"));
  EXPECT_EQ(meta("heavy.wav").at("parameters").at("ball"), heavy);
  EXPECT_EQ(meta("steel.wav").at("parameters").at("ball"), "steel:6mm");
}

TEST_F(BallOption, OfASimulationGoesWithItsImpacts) {
  ASSERT_EQ(
      run("simulate --drops 1 --impacts 5 --asperities 1000 --ball glass:16mm --plate steel --out i.csv").exit_code, 0);
  const Json sound = json_of("synthesize i.csv --rate 24000 --out r.wav");
  EXPECT_EQ(sound.at("ball").at("name"), "glass:16mm");
  EXPECT_EQ(sound.at("plate").at("name"), "steel");
  EXPECT_EQ(json_of("restitution i.csv --out s.csv").at("ball").at("name"), "glass:16mm");
  EXPECT_EQ(json_of("restitution i.csv --out t.csv --ball golf").at("ball").at("name"), "golf");
  EXPECT_EQ(meta("s.csv").at("parameters").at("ball"), "glass:16mm");
  EXPECT_THAT(content_of(folder_ / "s.csv"), testing::HasSubstr(",glass:16mm,steel,"));
  EXPECT_EQ(json_of("synthesize i.csv --rate 24000 --out r.wav --force --plate sic").at("plate").at("name"), "sic");
}

TEST_F(BallOption, NotNamedNothingIsAssumed) {
  write_onsets();
  EXPECT_TRUE(json_of("restitution o.csv --out s.csv").at("ball").is_null());
  const Result fitted = run("fit s.csv --out f.json --goodness-replicates 0");
  EXPECT_THAT(fitted.err, testing::Not(testing::HasSubstr("steel")));
  const Json budget = Json::parse(content_of(folder_ / "f.json")).at("budget");
  EXPECT_TRUE(budget.at("ball").is_null());
  EXPECT_TRUE(budget.at("rows").at(0).at("shift_drag").is_null());
}

TEST_F(BallOption, NamedToTheFitItIsThatOfTheBudget) {
  write_onsets();
  ASSERT_EQ(run("restitution o.csv --out s.csv --quiet").exit_code, 0);
  const auto drag_of = [&](const std::string& ball) {
    run("fit s.csv --out f.json --force --quiet --goodness-replicates 0 --plate glass --ball " + ball);
    return Json::parse(content_of(folder_ / "f.json")).at("budget").at("rows").at(0).at("shift_drag").get<double>();
  };
  // kappa = 3 rho_air C_d / (8 rho_ball R): densities and radii alone make it 14.5 times that of the steel ball, and
  // C_d is .50 to .55 (Re of 600) instead of 1.0 to 1.2 (Re of 90)
  const double ratio = drag_of("table-tennis") / drag_of("steel:6mm");
  EXPECT_TRUE(ratio > 6.0 && ratio < 8.0) << ratio;
}

TEST_F(BallOption, WhatIsNotKnownIsAnsweredWithTheNearestAndTheList) {
  expect_one_line_error(run("simulate --out a.csv --ball tabletennis"), 2,
                        {"--ball", "'tabletennis'", "table-tennis?", "bouncelab balls"});
  expect_one_line_error(run("simulate --out a.csv --plate glas"), 2, {"--plate", "'glas'", "glass?"});
  expect_one_line_error(run("analyze none.wav --out d --ball steel"), 2, {"--ball", "size is missing"});
  write("c.toml", "drops = 1\nball = \"stele:6mm\"\n");
  expect_one_line_error(run("simulate --out a.csv --config c.toml"), 2, {"c.toml: line 2", "steel?"});
  write("i.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.1,1,0.9\n0,1,0.3,0.9,0.8\n");
  expect_one_line_error(run("synthesize i.csv --out r.wav --ball radius=33mm,mass=58g"), 2,
                        {"diameter=66mm", "contact-time="});
  EXPECT_EQ(run("synthesize i.csv --out r.wav --rate 24000 --ball radius=33mm,mass=58g,contact-time=5ms").exit_code, 0);
  EXPECT_NEAR(contact_us("r.truth.csv"), 5000.0, 1e-6);
  expect_one_line_error(run("simulate --out a.csv --contact-patch --ball squash"), 2, {"squash", "Hertz"});
  write("s.csv", "v_mps,eps,ball\n0.5,0.98,steel:6mm\n0.4,0.98,stone\n");
  expect_one_line_error(run("fit s.csv --out f.json"), 3, {"s.csv", "line 3", "'stone'"});
  write("i.csv.meta.json", "no json");
  expect_one_line_error(run("synthesize i.csv --out q.wav"), 3, {"i.csv.meta.json", "not JSON"});
}

TEST_F(BallOption, IsSetInConfigurationFilesAlsoInSectionsOfStages) {
  write_onsets();
  write("c.toml", "ball = \"glass:16mm\"\n[simulate]\ndrops = 1\nimpacts = 3\nasperities = 1000\n");
  EXPECT_EQ(json_of("simulate --out a.csv --config c.toml").at("ball").at("name"), "glass:16mm");
}

TEST_F(BallOption, GravityOfASimulationIsThatOfItsSpeeds) {
  // on the Moon: at 9.81 m/s2 the speeds would be six times too large
  ASSERT_EQ(run("simulate --gravity 1.62 --height 0.1 --drops 1 --impacts 5 --asperities 99 --out moon.csv").exit_code,
            0);
  ASSERT_EQ(run("restitution moon.csv --out moon_s.csv").exit_code, 0);
  for (const RestitutionSample& s :
       samples_from_table(read_csv(folder_ / "moon_s.csv", sample_columns()), "moon_s.csv")) {
    EXPECT_EQ(s.conditions.gravity_mps2, 1.62);
    EXPECT_LT(s.v_mps, 0.57);  // sqrt(2 g h)
  }
  ASSERT_EQ(run("restitution moon.csv --gravity 9.81 --out told.csv").exit_code, 0);
  EXPECT_EQ(samples_from_table(read_csv(folder_ / "told.csv", sample_columns()), "told.csv")[0].conditions.gravity_mps2,
            9.81);
}

TEST_F(BallOption, OfASimulationIsKnownToWhatIsHeardOfIt) {
  const std::string few = " --drops 1 --impacts 12 --asperities 99 --ball glass:16mm ";
  ASSERT_EQ(run("simulate --gravity 1.62 --height 0.1 --out moon.csv" + few).exit_code, 0);
  ASSERT_EQ(run("synthesize moon.csv --rate 24000 --out moon.wav").exit_code, 0);
  ASSERT_LE(run("analyze moon.wav --out moon").exit_code, 1);
  const auto first_of = [&](const std::string& folder) {
    return samples_from_table(read_csv(folder_ / folder / "samples.csv", sample_columns()), folder)[0].conditions;
  };
  SampleConditions known = first_of("moon");
  EXPECT_EQ(known.gravity_mps2, 1.62);
  EXPECT_TRUE(known.drag_corrected && known.contact_time_corrected);
  EXPECT_EQ(to_text(known.ball.value()), "glass:16mm");
  ASSERT_EQ(run("simulate --drag --out air.csv" + few).exit_code, 0);
  ASSERT_EQ(run("synthesize air.csv --rate 24000 --out air.wav").exit_code, 0);
  ASSERT_LE(run("analyze air.wav --out air").exit_code, 1);
  known = first_of("air");
  EXPECT_FALSE(known.drag_corrected);
  EXPECT_TRUE(known.contact_time_corrected);
  // the sound got about without its impacts, or with others of their name
  fs::copy_file(folder_ / "air.csv", folder_ / "moon.csv", fs::copy_options::overwrite_existing);
  ASSERT_LE(run("analyze moon.wav --out again").exit_code, 1);
  EXPECT_EQ(first_of("again"), first_of("moon"));
  // what is known of another sound is not believed
  fs::copy_file(folder_ / "moon.wav.meta.json", folder_ / "air.wav.meta.json", fs::copy_options::overwrite_existing);
  ASSERT_LE(run("analyze air.wav --out stale").exit_code, 1);
  EXPECT_EQ(first_of("stale").gravity_mps2, kDefaultGravity_mps2);
  EXPECT_FALSE(first_of("stale").ball);
  expect_one_line_error(run("analyze moon.wav air.wav --out both"), 2, {"air.wav", "--ball", "not known", "moon.wav"});
  EXPECT_THAT(run("analyze moon.wav none.wav --out one").err, testing::HasSubstr("none.wav: no such file"));
}

TEST_F(BallOption, WhoseContactsWouldBeMostOfTheBouncesLeavesTheRowsOut) {
  write_onsets();
  ASSERT_EQ(run("restitution o.csv --ball squash,contact-time=80ms --out s.csv").exit_code, 0);
  const Result fitted = run("fit s.csv --out f.json");
  EXPECT_LE(fitted.exit_code, 1);
  EXPECT_THAT(fitted.err, testing::HasSubstr("the ball named touches the floor for most of that bounce"));
  // of the intervals .28 s .97^k those from the 19th on are shorter than twice 80 ms
  const int n = Json::parse(content_of(folder_ / "f.json"))["n_left_out"]["contact_most_of_bounce"].get<int>();
  EXPECT_NEAR(n, 58 - 18, 1);
}

TEST_F(BallOption, AProvenanceThatWasEditedIsRefusedWhereItIsWrong) {
  ASSERT_EQ(run("simulate --drops 2 --impacts 9 --asperities 99 --out i.csv").exit_code, 0);
  const std::string meta = content_of(folder_ / "i.csv.meta.json");
  const auto edited = [&](const std::string& was, const std::string& is) {
    std::string text = meta;
    text.replace(text.find(was), was.size(), is);
    write("i.csv.meta.json", text);
    return run("restitution i.csv --out s.csv --force");
  };
  for (const char* gravity : {"1,62", "1e300", "-5", "nan", "fast"})
    expect_one_line_error(edited("\"gravity\": \"9.81\"", "\"gravity\": \"" + std::string(gravity) + "\""), 3,
                          {"i.csv", "--gravity", ".meta.json"});
  expect_one_line_error(edited("\"ball\": \"steel:6mm\"", "\"ball\": \"cheese:6mm\""), 3,
                        {"i.csv", "--ball", "cheese"});
  EXPECT_EQ(edited("\"gravity\": \"9.81\"", "\"gravity\": \"1.62\"").exit_code, 0);
}

}  // namespace
}  // namespace bouncelab::cli_test
