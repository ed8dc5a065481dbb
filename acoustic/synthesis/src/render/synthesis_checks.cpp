// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::synthesis {
namespace {

std::string number(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

/// NaN is in no range.
void require_range(const std::string& name, double value, double lo, double hi) {
  if (value >= lo && value <= hi) return;
  throw InvalidArgument(name + " is " + number(value) + "; it must be from " + number(lo) + " to " + number(hi));
}

void validate(const Disturbances& d, double pause_s) {
  constexpr double kMuch = 1e3;
  require_range("hum_level", d.hum_level, 0.0, kMuch);
  require_range("hum_hz", d.hum_hz, 1.0, 1000.0);
  require_range("drift_level", d.drift_level, 0.0, kMuch);
  require_range("clicks_per_s", d.clicks_per_s, 0.0, kMuch);
  require_range("knocks_per_s", d.knocks_per_s, 0.0, kMuch);
  require_range("double_hit_fraction", d.double_hit_fraction, 0.0, 1.0);
  require_range("timbre_wander", d.timbre_wander, 0.0, 3.0);
  require_range("phase_wander_rad", d.phase_wander_rad, 0.0, 10.0);
  require_range("speech_per_s", d.speech_per_s, 0.0, 20.0);
  if (d.robot_cycle) require_range("pause_s with the robot's cycle", pause_s, 2.0, 3600.0);
}

void validate(const std::vector<Channel>& channels, const SynthesisConfig& config) {
  require_range("number of channels", static_cast<double>(channels.size()), 1.0, 8.0);
  const RectangularPlate& plate = config.ground.carrier;
  for (const Channel& channel : channels) {
    if (config.sensor.kind == SensorKind::piezo) {
      require_range("sensor x_m", channel.x_m, -0.5 * plate.length_x_m, 0.5 * plate.length_x_m);
      require_range("sensor y_m", channel.y_m, -0.5 * plate.length_y_m, 0.5 * plate.length_y_m);
    } else {
      require_range("microphone x_m", channel.x_m, -10.0, 10.0);
      require_range("microphone y_m", channel.y_m, -10.0, 10.0);
      require_range("microphone z_m", channel.z_m, 0.01, 10.0);
    }
    require_range("channel gain", channel.gain, -1e3, 1e3);
  }
  if (std::all_of(channels.begin(), channels.end(), [](const Channel& c) { return c.gain == 0.0; }))
    throw InvalidArgument("every channel is dead; at least one gain must not be 0");
}

}  // namespace

void validate(const SynthesisConfig& config) {
  require_range("rate_hz", config.rate_hz, 8000, 2000000);
  require_range("snr_db", config.snr_db, -40.0, 200.0);
  require_range("noise_corner_hz", config.noise_corner_hz, 0.0, 0.25 * config.rate_hz);
  require_range("peak", config.peak, 1e-6, 1e3);
  require_range("lead_in_s", config.lead_in_s, 0.01, 3600.0);
  require_range("pause_s", config.pause_s, 0.05, 3600.0);
  require_range("together", config.together, 1, 8);
  require_range("start_spread_m", config.start_spread_m, 0.0, 1.0);
  require_range("gain_control_db", config.gain_control_db, 0.0, 40.0);
  require_range("max_mode_hz", config.max_mode_hz, 100.0, 200e3);
  require_range("ball radius_m", config.ball.radius_m, 1e-5, 1.0);
  const Material& plate = contact_material(config.ground);
  if (!contact_duration(config.ball, plate))
    throw InvalidArgument("how long " + to_text(config.ball) + " touches " + plate_text(plate) +
                          " is not known: Hertz's theory does not hold for it; give a contact time that was measured, "
                          "--ball " +
                          to_text(config.ball) + ",contact-time=0.8ms");
  validate(config.channels, config);
  validate(config.disturbances, config.pause_s);
  if (config.levels) {
    require_range("levels gain", config.levels->gain, 1e-300, 1e300);
    require_range("levels noise_rms", config.levels->noise_rms, 1e-30, 1e3);
    require_range("levels weakest_peak", config.levels->weakest_peak, 1e-30, 1e3);
  }
}

void validate(const Impacts& impacts, const SynthesisConfig& config) {
  if (impacts.rows.empty()) throw InvalidArgument("there are no impacts to synthesize; simulate some first");
  if (!impacts.states.empty() && impacts.states.size() != impacts.rows.size())
    throw InvalidArgument(std::to_string(impacts.states.size()) + " states for " + std::to_string(impacts.rows.size()) +
                          " impacts; there must be one for each, or none");
  for (std::size_t k = 0; k < impacts.rows.size(); ++k) {
    const Impact& impact = impacts.rows[k];
    const std::string place =
        "drop " + std::to_string(impact.drop) + ", impact " + std::to_string(impact.impact) + ": ";
    const bool goes_on = k > 0 && impacts.rows[k - 1].drop == impact.drop;
    if (!(impact.t_s >= 0.0) || !std::isfinite(impact.t_s))
      throw InvalidArgument(place + "t_s is " + std::to_string(impact.t_s) + "; it must be finite and not negative");
    if (k > 0 && impact.drop < impacts.rows[k - 1].drop)
      throw InvalidArgument(place + "follows drop " + std::to_string(impacts.rows[k - 1].drop) +
                            "; sort by drop and time");
    if (goes_on && impact.t_s <= impacts.rows[k - 1].t_s)
      throw InvalidArgument(place + "t_s " + std::to_string(impact.t_s) + " does not come after " +
                            std::to_string(impacts.rows[k - 1].t_s) + "; sort by drop and time");
    constexpr double kLongestDrop_s = 1e6;  // eleven days of one ball; the paper's whole experiment took 7 hours
    if (std::abs(impact.t_s) > kLongestDrop_s)
      throw InvalidArgument(place + "t_s is " + std::to_string(impact.t_s) + "; no drop lasts longer than 1e6 s");
    if (!(impact.v_mps > 0.0) || !std::isfinite(impact.v_mps) || !std::isfinite(impact.v_after_mps))
      throw InvalidArgument(place + "v_mps is " + std::to_string(impact.v_mps) + "; it must be positive and finite");
    if (impacts.states.empty() || !config.simulated_positions) continue;
    const auto& position = impacts.states[k].position_m;
    if (!contains(config.ground, position[0], position[1]))
      throw OffThePlate(
          place + "x = " + std::to_string(position[0]) + " m, y = " + std::to_string(position[1]) +
          " m is off the plate; let the simulation end the drop at the edge of the plate, or draw the positions");
  }
}

void check_contact(double duration_s, const SynthesisConfig& config) {
  if (duration_s * config.rate_hz <= kMaxContact_samples) return;
  throw InvalidArgument("a contact of " + std::to_string(duration_s * 1e6) + " us is " +
                        std::to_string(duration_s * config.rate_hz) + " samples long, more than " +
                        std::to_string(kMaxContact_samples) + "; lower the rate");
}

}  // namespace bouncelab::synthesis
