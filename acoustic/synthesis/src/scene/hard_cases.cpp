// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/synthesis/synthetic_recording.hpp"

#include <algorithm>

#include "bouncelab/core/error.hpp"

namespace bouncelab::synthesis {
namespace {

struct Recipe {
  const char* name;
  const char* what;
  void (*apply)(SynthesisConfig&);
};

void add_dead_channel(SynthesisConfig& c) {
  Channel dead = c.channels.front();
  dead.gain = 0.0;
  c.channels.insert(c.channels.begin(), dead);
}

void add_robot(SynthesisConfig& c) {
  c.disturbances.robot_cycle = true;
  c.pause_s = std::max(c.pause_s, 3.0);
}

constexpr Recipe kRecipes[]{
    {"noisy", "weakest impact only 10 dB above white and 1/f noise",
     [](SynthesisConfig& c) {
       c.snr_db = 10.0;
       c.noise_corner_hz = 500.0;
     }},
    {"hum", "mains hum louder than the weakest impact, drift of the zero line",
     [](SynthesisConfig& c) {
       c.disturbances.hum_level = 1.5;
       c.disturbances.drift_level = 2.0;
     }},
    {"clicks", "electric clicks, one a second", [](SynthesisConfig& c) { c.disturbances.clicks_per_s = 1.0; }},
    {"knocks", "a second object strikes the plate every two seconds",
     [](SynthesisConfig& c) { c.disturbances.knocks_per_s = 0.5; }},
    {"double-hits", "half of the impacts are followed by a knock within 12 ms",
     [](SynthesisConfig& c) { c.disturbances.double_hit_fraction = 0.5; }},
    {"robot", "release clicks, fan, motor bursts and pick-up between the drops", add_robot},
    {"clipped", "strong impacts three times beyond full scale", [](SynthesisConfig& c) { c.peak = 3.0; }},
    {"wander", "amplitudes and phases of the modes change from impact to impact",
     [](SynthesisConfig& c) {
       c.disturbances.timbre_wander = 0.4;
       c.disturbances.phase_wander_rad = 0.5;
     }},
    {"dead-channel", "two channels, the first one holds noise only", add_dead_channel},
    {"ringing", "a plate that rings three times as long",
     [](SynthesisConfig& c) {
       for (Damping* damping : {&c.ground.carrier_damping, &c.ground.disk_damping}) {
         damping->loss_factor /= 3.0;
         damping->support_per_s /= 3.0;
       }
     }},
    {"microphone", "by air, 30 cm above the plate, with echoes",
     [](SynthesisConfig& c) {
       c.sensor = microphone();
       for (Channel& channel : c.channels) channel.z_m = 0.3;
     }},
    {"rough", "noise at 20 dB, hum, clicks, knocks, some double hits, robot, wander",
     [](SynthesisConfig& c) {
       c.snr_db = 20.0;
       c.noise_corner_hz = 300.0;
       c.disturbances.hum_level = 0.5;
       c.disturbances.drift_level = 0.5;
       c.disturbances.clicks_per_s = 0.3;
       c.disturbances.knocks_per_s = 0.1;
       c.disturbances.double_hit_fraction = 0.1;
       c.disturbances.timbre_wander = 0.2;
       add_robot(c);
     }},
};

}  // namespace

Description members_of(const Disturbances*) {
  using D = Disturbances;
  static constexpr Member options[]{
      member<&D::hum_level>("hum", "Mains hum with harmonics").within(0.0, 1e6),
      member<&D::hum_hz>("hum_hz", "Mains frequency [Hz]").within(1.0, 1000.0),
      member<&D::drift_level>("drift", "Slow drift of the zero line").within(0.0, 1e6),
      member<&D::clicks_per_s>("clicks", "Electric clicks [1/s]").within(0.0, 1e4),
      member<&D::knocks_per_s>("knocks", "Knocks of a second object [1/s]").within(0.0, 1e4),
      member<&D::double_hit_fraction>("double_hits", "Share of impacts followed by a knock within 12 ms")
          .within(0.0, 1.0),
      member<&D::robot_cycle>("robot", "Release click, fan, motors and pick-up; needs --pause 2 or more"),
      member<&D::timbre_wander>("timbre_wander", "Standard deviation of ln(mode amplitude) between impacts")
          .within(0.0, 3.0),
      member<&D::phase_wander_rad>("phase_wander", "Standard deviation of mode phases between impacts [rad]")
          .within(0.0, 10.0),
      member<&D::speech_per_s>("speech", "Voiced syllables, peaks at levels 0.5 to 5 [1/s]").within(0.0, 20.0)};
  return options;
}

const std::vector<HardCase>& hard_cases() {
  static const std::vector<HardCase> cases = [] {
    std::vector<HardCase> result;
    for (const Recipe& recipe : kRecipes) result.push_back({recipe.name, recipe.what});
    return result;
  }();
  return cases;
}

SynthesisConfig with_hard_case(SynthesisConfig config, const std::string& name) {
  std::string names;
  for (const Recipe& recipe : kRecipes) {
    if (recipe.name == name) {
      recipe.apply(config);
      return config;
    }
    names += (names.empty() ? "" : ", ") + std::string(recipe.name);
  }
  throw InvalidArgument("hard case '" + name + "' is not known; the cases are " + names);
}

}  // namespace bouncelab::synthesis
