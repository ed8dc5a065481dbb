// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/synthesize_options.hpp"

#include <cmath>
#include <iterator>
#include <string_view>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::options {
namespace {

std::string hard_case_help() {
  std::string help = "A recording in which impacts are hard to detect, or none:";
  for (const synthesis::HardCase& hard : synthesis::hard_cases()) help += "\n  " + hard.name + ": " + hard.what;
  return help;
}

audio::SampleEncoding encoding_of(const std::string& bits) {
  if (bits == "16") return audio::SampleEncoding::pcm16;
  if (bits == "32") return audio::SampleEncoding::pcm32;
  return bits == "float" ? audio::SampleEncoding::float32 : audio::SampleEncoding::pcm24;
}

/// False where the text is not one finite decimal number.
bool read_number(std::string_view text, double& value) {
  const auto [end, status] = bouncelab::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

synthesis::Channel channel_of(const std::string& text, double default_z_m) {
  synthesis::Channel channel;
  channel.z_m = default_z_m;
  double* const fields[] = {&channel.x_m, &channel.y_m, &channel.z_m, &channel.gain};
  std::string_view rest = text;
  for (std::size_t n = 0; n < std::size(fields); ++n) {
    const auto comma = rest.find(',');
    if (!read_number(rest.substr(0, comma), *fields[n])) break;
    if (comma == std::string_view::npos && n >= 1) return channel;
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  throw InvalidArgument("--channel: '" + printable(text) +
                        "' is not X,Y[,Z[,GAIN]], finite decimal numbers, in metres");
}

/// @throws InvalidArgument where the sensor is no microphone
void set_room(const SynthesizeOptions& options, synthesis::Sensor& sensor) {
  if (!options.reverberation_db && !options.reverberation_time_s) return;
  if (sensor.kind != synthesis::SensorKind::microphone)
    throw InvalidArgument(std::string(options.reverberation_db ? "--reverberation" : "--reverberation-time") +
                          ": a piezo disc does not hear the room; add --sensor microphone");
  sensor.reverberation.level_db = options.reverberation_db.value_or(sensor.reverberation.level_db);
  sensor.reverberation.decay_60db_s = options.reverberation_time_s.value_or(sensor.reverberation.decay_60db_s);
}

}  // namespace

Description members_of(const SynthesizeOptions*) {
  using O = SynthesizeOptions;
  using C = synthesis::SynthesisConfig;
  static const std::string hard_cases = hard_case_help();
  static const Member options[]{
      member<&O::sensor>("sensor", "Sensor").one_of("piezo,microphone"),
      member<&O::reverberation_db>(
          "reverberation",
          "Of a microphone's room: energy of its tail over that of the direct sound [dB] (default -15)")
          .within(-60.0, 20.0),
      member<&O::reverberation_time_s>("reverberation_time", "The tail falls by 60 dB in this [s] (default 0.25)")
          .within(0.02, 5.0),
      member<&O::channels>(
          "channel",
          "Position X,Y[,Z[,GAIN]] of a sensor from the plate's middle [m]; once for each of up to 8 channels; GAIN "
          "0 is a dead channel"),
      member<&O::config, &C::rate_hz>("rate", "Sample rate [Hz]").within(8000, 2e6),
      member<&O::bits>("bits", "Bits of a sample").one_of("16,24,32,float"),
      member<&O::config, &C::snr_db>("snr_db", "Clean peak of the weakest wanted impact over the rms of the noise [dB]")
          .within(-40.0, 200.0),
      member<&O::config, &C::noise_corner_hz>("noise_corner", "Noise grows like 1/f below this [Hz]; 0: white")
          .within(0.0, 1e6),
      member<&O::config, &C::peak>("peak", "Clean peak of the strongest impact, full scale = 1; above 1 it is clipped")
          .within(1e-6, 1e3),
      member<&O::config, &C::lead_in_s>("lead_in", "Before the first release [s]").within(0.01, 3600.0),
      member<&O::config, &C::pause_s>("pause", "After each drop's last impact [s]").within(0.05, 3600.0),
      member<&O::config, &C::together>(
          "together", "Balls at once: so many drops in turn, each released 0.05 to 0.5 s after the one before")
          .within(1, 8),
      member<&O::positions>(
          "positions",
          "Where the ball strikes: as simulated (where the impacts have states) or drawn, one place a drop")
          .one_of("simulated,drawn"),
      member<&O::config, &C::start_spread_m>("spread", "Drawn positions lie within this of the middle [m]")
          .within(0.0, 10.0),
      member<&O::config, &C::max_mode_hz>("max_mode", "Modes of the ground up to this [Hz]").within(100.0, 200e3),
      member<&O::config, &C::gain_control_db>(
          "gain_control",
          "A phone's automatic gain: how far the strongest impact pushes it down, back within 0.3 s [dB]")
          .within(0.0, 40.0),
      member<&O::config, &C::without_ball>(
          "without_ball",
          "The same recording but for the ball, which makes no sound: whatever is found in it is invented"),
      member<&O::hard_case>("hard", hard_cases)};
  return options;
}

Section disturbances_section(SynthesizeOptions& options) {
  synthesis::Disturbances& disturbances = options.config.disturbances;
  return section_of(disturbances, "Disturbances (levels in units of the weakest wanted impact's peak)");
}

synthesis::SynthesisConfig synthesis_config(const SynthesizeOptions& options, std::uint64_t seed, int n_threads) {
  synthesis::SynthesisConfig config = options.config;
  config.seed = seed;
  config.n_threads = n_threads;
  if (const std::optional<Ball> ball = ball_of(options.world)) config.ball = *ball;
  if (const std::optional<Material> plate = plate_of(options.world)) config.ground = synthesis::ground_of(*plate);
  config.encoding = encoding_of(options.bits);
  config.simulated_positions = options.positions == "simulated";
  const bool by_air = options.sensor == "microphone";
  if (by_air) config.sensor = synthesis::microphone();
  const double default_z_m = by_air ? 0.3 : 0.0;
  config.channels.front().z_m = default_z_m;
  if (!options.channels.empty()) config.channels.clear();
  for (const std::string& text : options.channels) config.channels.push_back(channel_of(text, default_z_m));
  if (options.hard_case != "none") config = synthesis::with_hard_case(config, options.hard_case);
  set_room(options, config.sensor);
  return config;
}

}  // namespace bouncelab::options
