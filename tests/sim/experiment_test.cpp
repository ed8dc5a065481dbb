// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/experiment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <sstream>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab::sim {
namespace {

SimulationConfig small_config() {
  SimulationConfig config;
  config.n_drops = 10;
  config.n_impacts_max = 60;
  config.with_state = true;
  config.n_threads = 1;
  return config;
}

Surface small_surface(const SimulationConfig& config) {
  return make_surface(config.ball, 50'000, UniformRadii{}, config.seed);
}

std::string bytes(const Impacts& impacts) {
  std::ostringstream out;
  write_csv(out, to_table(impacts));
  return out.str();
}

TEST(Simulate, GivesTheSameDropsAloneAndInTurnWhereSomeEndEarly) {
  SimulationConfig config = small_config();
  config.n_impacts_max = 1000;
  config.min_speed_mps = 0.3;
  const Envelope envelope(config.ball, small_surface(config));
  const std::vector<std::int64_t> numbers{3, 14, 15, 9, 2, 6, 5, 35, 8, 97, 93};  // more than take turns
  for (const bool with_air : {false, true}) {
    if (with_air) config.air = Air{};
    const std::vector<DropResult> together = simulate_drops(config, envelope, numbers);
    ASSERT_EQ(together.size(), numbers.size());
    std::set<std::size_t> lengths;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const DropResult alone = simulate_drops(config, envelope, std::array{numbers[k]}).front();
      EXPECT_EQ(bytes(together[k].impacts), bytes(alone.impacts));
      EXPECT_EQ(together[k].end, alone.end);
      EXPECT_EQ(together[k].energy.remaining_j, alone.energy.remaining_j);
      EXPECT_EQ(together[k].energy.drag_j, alone.energy.drag_j);
      lengths.insert(alone.impacts.rows.size());
    }
    EXPECT_GT(lengths.size(), 3U);  // they do end at different impacts
  }
}

TEST(Simulate, SmoothBallHasTheLawsRestitutionExactly) {
  SimulationConfig config = small_config();
  config.n_impacts_max = 100;
  const SimulationResult result = simulate(config, Surface{});
  ASSERT_EQ(result.impacts.rows.size(), 1000U);
  for (const Impact& impact : result.impacts.rows) {
    // some twenty roundings of 1e-16 on the way through the impulse
    EXPECT_NEAR(impact.eps_macro, restitution(config.law, impact.v_mps), 4e-15);
    EXPECT_EQ(impact.asperity, -1);
  }
  EXPECT_EQ(result.n_smooth, 1000);
}

TEST(Simulate, EnergyLedgerClosesForEveryContactModel) {
  SimulationConfig config = small_config();
  config.start_spin_radps = {100.0, 50.0, -80.0};
  config.start_velocity_mps = {0.05, -0.02};
  const Surface surface = small_surface(config);
  for (const ContactModel& model : {ContactModel{PaperContact{}}, ContactModel{FrictionlessContact{}},
                                    ContactModel{CoulombContact{0.2}}, ContactModel{StrongeContact{0.2}}}) {
    config.contact = model;
    const EnergyLedger energy = simulate(config, surface).energy;
    EXPECT_LT(std::abs(energy.closure()), 1e-12) << describe(model);
    EXPECT_GT(energy.dissipated_j, 0.5 * energy.released_j);
  }
}

TEST(Simulate, LosslessRestitutionWithFrictionCreatesEnergyByNewtonsRuleAndNoneByStronges) {
  SimulationConfig config = small_config();
  config.law = ConstantLaw{1.0};
  const Surface surface = small_surface(config);
  config.contact = StrongeContact{0.02};  // so small that many impacts of this rough ball slide
  const SimulationResult energetic = simulate(config, surface);
  EXPECT_EQ(energetic.energy.n_creating, 0);
  EXPECT_GT(energetic.energy.dissipated_j, 0.0);
  EXPECT_LT(std::abs(energetic.energy.closure()), 1e-12);  // as above: 600 roundings
  config.contact = CoulombContact{0.02};
  EXPECT_GT(simulate(config, surface).energy.n_creating, 0);
}

TEST(Simulate, EnergyOfEachImpactBalancesAndTheImpactsAddUpToTheRun) {
  SimulationConfig config = small_config();
  config.start_spin_radps = {100.0, 50.0, -80.0};  // the paper's rule then creates energy now and then
  const SimulationResult result = simulate(config, small_surface(config));
  double dissipated = 0.0, created = 0.0;
  for (const ImpactState& s : result.impacts.states) {
    const double before = s.energy_j[0] + s.energy_j[1] + s.energy_j[2];
    const double after = s.energy_after_j[0] + s.energy_after_j[1] + s.energy_after_j[2];
    EXPECT_NEAR((before + s.created_j - after - s.dissipated_j) / before, 0.0, 1e-12);
    dissipated += s.dissipated_j;
    created += s.created_j;
  }
  EXPECT_GT(created, 0.0);
  EXPECT_NEAR(dissipated / result.energy.dissipated_j, 1.0, 1e-12);  // 600 roundings of 1e-16
  EXPECT_NEAR(created / result.energy.created_j, 1.0, 1e-12);
}

TEST(Simulate, FallTimeAndSpeedFollowFromTheHeightAboveATiltedPlateToo) {
  SimulationConfig config = small_config();
  config.drop_height_min_m = config.drop_height_max_m = 0.1;
  for (const double tilt_rad : {0.0, 0.1}) {
    config.tilt_rad = tilt_rad;
    const Impact first = simulate(config, Surface{}).impacts.rows.front();
    const double normal_mps2 = 9.81 * std::cos(tilt_rad);
    EXPECT_NEAR(first.v_mps, std::sqrt(2 * normal_mps2 * 0.1), 1e-15);
    EXPECT_NEAR(first.t_s, std::sqrt(2 * 0.1 / normal_mps2), 1e-15);
  }
}

TEST(Simulate, TiltedPlateLetsTheSmoothBallBounceDownhill) {
  SimulationConfig config = small_config();
  config.n_drops = 1;
  config.tilt_rad = 0.1;
  const SimulationResult result = simulate(config, Surface{});
  // along the plate nothing acts but gravity: x = g sin(tilt) t^2 / 2 whatever the bounces
  const auto& rows = result.impacts.rows;
  for (std::size_t k = 0; k < rows.size(); ++k)
    EXPECT_NEAR(result.impacts.states[k].position_m[0], 0.5 * 9.81 * std::sin(0.1) * rows[k].t_s * rows[k].t_s, 1e-12);
  EXPECT_LT(std::abs(result.energy.closure()), 1e-12);
}

TEST(Simulate, DropEndsWhereTheBallLeavesThePlateAndIsCounted) {
  SimulationConfig config = small_config();
  config.plate_size_m = {0.30, 0.20};
  config.start_velocity_mps = {0.0, 0.1};
  const SimulationResult result = simulate(config, Surface{});
  EXPECT_EQ(result.n_ended[static_cast<std::size_t>(DropEnd::left_plate)], 10);
  for (const ImpactState& state : result.impacts.states) EXPECT_LE(state.position_m[1], 0.1);
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_EQ(result.notes[0].kind, NoteKind::drops_left_plate);
}

TEST(Simulate, StopsBySpeedAndByTime) {
  SimulationConfig config = small_config();
  config.n_impacts_max = 100'000;
  config.min_speed_mps = 0.5;
  for (const Impact& impact : simulate(config, Surface{}).impacts.rows) EXPECT_GE(impact.v_mps, 0.5);
  config.min_speed_mps = 0.0;
  config.law = ConstantLaw{0.7};  // after some 30 impacts the ball rolls from asperity to asperity
  config.n_impacts_max = 100;
  for (const Impact& impact : simulate(config, small_surface(config)).impacts.rows) EXPECT_GT(impact.v_mps, 0.0);
  config.max_time_s = 2.0;
  for (const Impact& impact : simulate(config, Surface{}).impacts.rows) EXPECT_LE(impact.t_s, 2.0);
}

TEST(Simulate, RefusesWhatCannotBe) {
  const auto refuses = [](auto change) {
    SimulationConfig config = small_config();
    change(config);
    EXPECT_THROW(simulate(config, Surface{{{{0, 0, 1}, 1e-3}}}), InvalidArgument);
  };
  refuses([](SimulationConfig& c) { c.n_drops = 0; });
  refuses([](SimulationConfig& c) { c.gravity_mps2 = -9.81; });
  refuses([](SimulationConfig& c) { c.tilt_rad = std::numbers::pi / 2; });
  refuses([](SimulationConfig& c) { c.drop_height_min_m = c.drop_height_max_m = 0.5e-3; });  // asperity of 1 mm
  refuses([](SimulationConfig& c) { c.drop_height_max_m = 0.01; });
  refuses([](SimulationConfig& c) { c.law = ConstantLaw{2.0}; });
  refuses([](SimulationConfig& c) { c.law = TableLaw{{0.0, 1.0}, {1.0, -0.1}}; });  // below 0 at 1 m/s
  refuses([](SimulationConfig& c) { c.start_spin_radps[1] = NAN; });
}

}  // namespace
}  // namespace bouncelab::sim
