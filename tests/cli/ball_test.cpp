// SPDX-License-Identifier: GPL-3.0-or-later
// `bouncelab balls`, and --ball and --plate of every command that takes them.
#include <sstream>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/table.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

class BallOption : public ProgramTest {
 protected:
  Json json_of(const std::string& arguments) const {
    const Result result = run(arguments + " --json");
    EXPECT_LE(result.exit_code, 1) << arguments << "\n" << result.err;  // 1: few samples identify no constants
    return Json(result.out);
  }
  Json meta(const std::string& name) const { return Json(content_of(folder_ / (name + ".meta.json"))); }
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
  /// How the first of some samples was computed.
  SampleConditions first_of(const std::string& samples) const {
    return samples_from_table(read_csv(folder_ / samples, sample_columns()), samples)[0].conditions;
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
  for (const char* what : {"table-tennis", "concrete", "diameter 40 mm", "steel:6mm", "ITTF"})
    EXPECT_THAT(list.out, testing::HasSubstr(what));
  EXPECT_THAT(list.out, testing::HasSubstr("dropped from 254 cm onto concrete: 135 to 147 cm (ITF)"));
  const Json j = json_of("balls");
  EXPECT_EQ(j["balls"][0]["rebound"]["most_m"], 0.26);
  EXPECT_EQ(j["balls"][0]["name"], "table-tennis");
  EXPECT_NEAR(j["balls"][0]["mass_kg"].number(), 2.7e-3, 1e-15);
  EXPECT_EQ(j["balls"][0]["radius_m"], 0.02);
  EXPECT_TRUE(j["balls"][0]["youngs_modulus_pa"].is_null());
  for (const char* list_name : {"balls", "plates"})
    for (const Json& kind : j[list_name].elements()) EXPECT_GT(kind["source"].text().size(), 8u);
}

TEST_F(BallOption, OfASimulationGoesWithItsImpacts) {
  const std::string few = "simulate --drops 1 --impacts 5 --asperities 99 ";
  ASSERT_EQ(run(few + "--ball glass:16mm --plate steel --gravity 1.62 --out i.csv").exit_code, 0);
  const Json sound = json_of("synthesize i.csv --rate 24000 --out r.wav");
  EXPECT_EQ(sound["ball"]["name"], "glass:16mm");
  EXPECT_EQ(sound["plate"]["name"], "steel");
  EXPECT_EQ(json_of("restitution i.csv --out s.csv")["ball"]["name"], "glass:16mm");
  EXPECT_EQ(json_of("restitution i.csv --out t.csv --ball golf")["ball"]["name"], "golf");
  EXPECT_EQ(meta("s.csv")["parameters"]["ball"], "glass:16mm");
  EXPECT_THAT(content("s.csv"), testing::HasSubstr(",glass:16mm,steel,"));
  // at 9.81 m/s2 the speeds would be six times too large
  EXPECT_EQ(first_of("s.csv").gravity_mps2, 1.62);
  ASSERT_EQ(run("restitution i.csv --gravity 9.81 --out told.csv").exit_code, 0);
  EXPECT_EQ(first_of("told.csv").gravity_mps2, 9.81);
  EXPECT_EQ(json_of("synthesize i.csv --rate 24000 --out r.wav --force --plate sic")["plate"]["name"], "sic");
}

TEST_F(BallOption, NotNamedNothingIsAssumedAndNamedItIsThatOfTheBudget) {
  write_onsets();
  EXPECT_TRUE(json_of("restitution o.csv --out s.csv")["ball"].is_null());
  const Result fitted = run("fit s.csv --out f.json --goodness-replicates 0");
  EXPECT_THAT(fitted.err, testing::Not(testing::HasSubstr("steel")));
  const Json budget = json("f.json")["budget"];
  EXPECT_TRUE(budget["ball"].is_null());
  EXPECT_TRUE(budget["rows"][0]["shift_drag"].is_null());
  run("fit s.csv --out g.json --quiet --goodness-replicates 0 --plate glass --ball table-tennis");
  EXPECT_EQ(json("g.json")["budget"]["ball"], "table-tennis");
  EXPECT_NE(json("g.json")["budget"]["rows"][0]["shift_drag"].number(), 0.0);
}

TEST_F(BallOption, WhatIsNotKnownIsAnsweredWithTheNearestAndTheList) {
  expect_one_line_error(run("simulate --out a.csv --ball tabletennis"), 2,
                        {"--ball", "'tabletennis'", "table-tennis?", "bouncelab balls"});
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

TEST_F(BallOption, OfASimulationIsKnownToWhatIsHeardOfIt) {
  const std::string few = " --drops 1 --impacts 12 --asperities 99 --ball glass:16mm ";
  ASSERT_EQ(run("simulate --gravity 1.62 --height 0.1 --out moon.csv" + few).exit_code, 0);
  ASSERT_EQ(run("synthesize moon.csv --rate 24000 --out moon.wav").exit_code, 0);
  ASSERT_LE(run("analyze moon.wav --out moon").exit_code, 1);
  SampleConditions known = first_of("moon/samples.csv");
  EXPECT_EQ(known.gravity_mps2, 1.62);
  EXPECT_TRUE(known.drag_corrected && known.contact_time_corrected);
  EXPECT_EQ(to_text(known.ball.value()), "glass:16mm");
  ASSERT_EQ(run("simulate --drag --out air.csv" + few).exit_code, 0);
  ASSERT_EQ(run("synthesize air.csv --rate 24000 --out air.wav").exit_code, 0);
  ASSERT_LE(run("analyze air.wav --out air").exit_code, 1);
  known = first_of("air/samples.csv");
  EXPECT_FALSE(known.drag_corrected);
  EXPECT_TRUE(known.contact_time_corrected);
  // the sound got about without its impacts, or with others of their name
  fs::copy_file(folder_ / "air.csv", folder_ / "moon.csv", fs::copy_options::overwrite_existing);
  ASSERT_LE(run("analyze moon.wav --out again").exit_code, 1);
  EXPECT_EQ(first_of("again/samples.csv"), first_of("moon/samples.csv"));
  // what is known of another sound is not believed
  fs::copy_file(folder_ / "moon.wav.meta.json", folder_ / "air.wav.meta.json", fs::copy_options::overwrite_existing);
  ASSERT_LE(run("analyze air.wav --out stale").exit_code, 1);
  EXPECT_EQ(first_of("stale/samples.csv").gravity_mps2, kDefaultGravity_mps2);
  EXPECT_FALSE(first_of("stale/samples.csv").ball);
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
  EXPECT_NEAR(json("f.json")["n_left_out"]["contact_most_of_bounce"].number(), 58 - 18, 1);
}

TEST_F(BallOption, AProvenanceThatWasEditedIsRefusedWhereItIsWrong) {
  ASSERT_EQ(run("simulate --drops 2 --impacts 9 --asperities 99 --out i.csv").exit_code, 0);
  const std::string meta = content("i.csv.meta.json");
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
