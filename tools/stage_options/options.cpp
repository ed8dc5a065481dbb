// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/options.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/sim/contact.hpp"

namespace bouncelab::options {

Description members_of(const BallChoice*) {
  static constexpr Member all[]{
      member<&BallChoice::ball>(
          "ball",
          "The ball: table-tennis, golf ...; steel:6mm, glass:16mm ... (material and DIAMETER; steel:r=3mm: "
          "radius); or numbers, radius=20mm,mass=2.7g,inertia=0.65. bouncelab balls lists them")
          .looks_like("BALL")
          .checked_by([](const std::string& text) { ball_from_text(text); }),
      member<&BallChoice::plate>("plate",
                                 "What it falls on: glass, steel, concrete ...; or E=70GPa,nu=0.22,density=2500")
          .looks_like("PLATE")
          .checked_by([](const std::string& text) { plate_from_text(text); })};
  return all;
}

Section ball_section(BallChoice& choice, std::string_view unnamed, std::vector<std::string> stages) {
  Section section = section_of(choice, "", std::move(stages));
  section.unnamed = unnamed;
  return section;
}

Object catalogue() { return {{"balls", value_of(ball_kinds())}, {"plates", value_of(plate_kinds())}}; }

namespace {

sim::ContactModel contact_model(const SimulateOptions& options) {
  if (options.contact == "frictionless") return sim::FrictionlessContact{};
  if (options.contact == "coulomb") return sim::CoulombContact{options.mu};
  if (options.contact == "stronge") return sim::StrongeContact{options.mu};
  return sim::PaperContact{options.beta};
}

}  // namespace

Description members_of(const SimulateOptions*) {
  using O = SimulateOptions;
  using C = sim::SimulationConfig;
  static constexpr Member options[]{
      member<&O::config, &C::n_drops>("drops", "Number of drops").within(1, 1e9),
      member<&O::config, &C::n_impacts_max>("impacts", "A drop ends after so many impacts").within(1, 1e9),
      member<&O::n_asperities>("asperities", "Small spheres on the ball").within(1, 1e9),
      member<&O::radius_law>(
          "radius_law",
          "Radii of the asperities in units of the ball's: constant:R, uniform:LO,HI, normal:MEAN,SD, "
          "lognormal:MEDIAN,SIGMA, exponential:MEAN"),
      member<&O::surface_file>("surface", "Read the asperities from a table (ux,uy,uz,radius_m) instead")
          .looks_like("FILE"),
      member<&O::restitution_law>(
          "law", "eps(v): series:A2=X,A4=Y,..., viscoelastic:GAMMA, constant:EPS, table:FILE.csv (v_mps,eps)"),
      member<&O::contact>("contact", "Contact model").one_of("paper,frictionless,coulomb,stronge"),
      member<&O::beta>("beta", "Tangential restitution of the paper's contact model").within(-1.0, 1.0),
      member<&O::mu>("mu", "Coefficient of friction of the coulomb and stronge models").within(0.0, 1e3),
      member<&O::contact_patch>(
          "contact_patch",
          "Offset of each contact averaged over the Hertzian area of contact on the plate at the impact's speed"),
      member<&O::config, &C::gravity_mps2>("gravity", "Gravity [m/s^2]").within(1e-3, 1e3),
      member<&O::height_m>("height", "Fall height [m]: one value, or LO,HI to draw between")
          .with_commas("LO[,HI]", 1, 2)
          .within(1e-6, 1e3),
      member<&O::start_m>("start", "Start position on the plate [m]").with_commas("X,Y", 2, 2).within(-1e3, 1e3),
      member<&O::velocity_mps>("velocity", "Horizontal start velocity [m/s]")
          .with_commas("X,Y", 2, 2)
          .within(-1e3, 1e3),
      member<&O::spin_radps>("spin", "Start spin [rad/s]").with_commas("X,Y,Z", 3, 3).within(-1e6, 1e6),
      member<&O::plate_m>("plate_size", "Size of the plate [m]; a drop ends beyond its edge; default no edge")
          .with_commas("X,Y", 2, 2)
          .within(1e-6, 1e6),
      member<&O::config, &C::tilt_rad>("tilt", "Tilt of the plate, downhill along x [rad]").within(0.0, 1.5707),
      member<&O::drag>("drag", "Air drag (standard curve of a sphere, 20 degrees C)"),
      member<&O::config, &C::min_speed_mps>("min_speed", "A drop ends before an impact slower than this [m/s]")
          .within(0.0, 1e3),
      member<&O::config, &C::max_time_s>("max_time", "A drop ends so long after its release [s]").within(1e-6, 1e9)};
  return options;
}

Section simulation_alone_section(SimulateOptions& options) {
  using O = SimulateOptions;
  using C = sim::SimulationConfig;
  static constexpr Member alone[]{
      member<&O::config, &C::first_drop>("first_drop", "Number of the first drop").within(0, 1e12),
      member<&O::preset>("preset", "paper: 2,320 drops of 95 impacts").one_of("paper"),
      member<&O::config, &C::with_state>("state",
                                         "Also position, orientation, velocities and energies at each impact")};
  return {"Ball, ground and drops", alone, &options};
}

sim::SimulationConfig simulation_config(const SimulateOptions& options, std::uint64_t seed, int n_threads) {
  sim::SimulationConfig config = options.config;
  config.seed = seed;
  config.n_threads = n_threads;
  config.law = restitution_law_from_text(options.restitution_law);
  config.contact = contact_model(options);
  if (options.drag) config.air = Air{};
  if (const std::optional<Ball> ball = ball_of(options.world)) config.ball = *ball;
  if (options.contact_patch) config.patch_plate = plate_of(options.world).value_or(kGlass);
  config.drop_height_min_m = options.height_m.front();
  config.drop_height_max_m = options.height_m.back();
  std::copy(options.plate_m.begin(), options.plate_m.end(), config.plate_size_m.begin());
  std::copy(options.start_m.begin(), options.start_m.end(), config.start_position_m.begin());
  std::copy(options.velocity_mps.begin(), options.velocity_mps.end(), config.start_velocity_mps.begin());
  std::copy(options.spin_radps.begin(), options.spin_radps.end(), config.start_spin_radps.begin());
  validate(config);
  return config;
}

namespace {

std::string hard_case_help() {
  std::string help = "A recording in which impacts are hard to detect, or none:";
  for (const synthesis::HardCase& hard : synthesis::hard_cases())
    help += std::string("\n  ") + hard.name + ": " + hard.what;
  return help;
}

synthesis::Channel channel_of(const std::string& text, double default_z_m) {
  synthesis::Channel channel;
  channel.z_m = default_z_m;
  double* const fields[] = {&channel.x_m, &channel.y_m, &channel.z_m, &channel.gain};
  std::string_view rest = text;
  for (std::size_t n = 0; n < std::size(fields); ++n) {
    const auto comma = rest.find(',');
    if (parse_number(rest.substr(0, comma), *fields[n]) != std::errc{} || !std::isfinite(*fields[n])) break;
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

audio::SampleEncoding encoding_of(const std::string& bits) {
  if (bits == "16") return audio::SampleEncoding::pcm16;
  if (bits == "32") return audio::SampleEncoding::pcm32;
  return bits == "float" ? audio::SampleEncoding::float32 : audio::SampleEncoding::pcm24;
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

fit::RestitutionConfig with_ball(const RestitutionOptions& options) {
  fit::RestitutionConfig config = options.config;
  if (config.air_kgpm3 == 0.0) config.instant_contacts = true;
  if (const std::optional<Ball> ball = ball_of(options.world)) config.ball = ball;
  if (const std::optional<Material> plate = plate_of(options.world)) config.plate = plate;
  return config;
}

Description members_of(const ForeignFileOptions*) {
  using O = ForeignFileOptions;
  static constexpr Member all[]{
      member<&O::table, &ForeignOptions::as>("as", "What the numbers are; auto: what their table proves")
          .one_of("auto,times,intervals,heights"),
      member<&O::table, &ForeignOptions::unit>("unit", "Their unit; auto: that of their title")
          .one_of("auto,s,ms,us,m,cm,mm,in,ft"),
      member<&O::table, &ForeignOptions::columns>("columns",
                                                  "Which columns are what, by title or number from 1; t=1,t=2: a drop "
                                                  "in each; h0=COLUMN,h=COLUMN: heights before "
                                                  "and after a bounce, v_in=COLUMN,v_out=COLUMN: speeds "
                                                  "(default: by the units of their titles)")
          .looks_like("t|h=COLUMN[,drop=COLUMN]"),
      member<&O::tier>(
          "tier",
          "Tier of a TextGrid or layer of an .svl, by name or number (default: the one that looks like impacts)")};
  return all;
}

}  // namespace bouncelab::options
