// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "commands/synthesize_command.hpp"
#include "options/ball_options.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

namespace {

std::string hard_case_help() {
  std::string help = "A recording in which impacts are hard to detect:";
  for (const synthesis::HardCase& hard : synthesis::hard_cases()) help += "\n  " + hard.name + ": " + hard.what;
  return help;
}

void add_disturbance_options(CLI::App& app, synthesis::Disturbances& d) {
  const auto level = within(0.0, 1e6), per_s = within(0.0, 1e4);
  const char* group = "Disturbances (levels in units of the weakest wanted impact's peak)";
  app.add_option("--hum", d.hum_level, "Mains hum with harmonics")->check(level)->group(group);
  app.add_option("--hum-hz", d.hum_hz, "Mains frequency [Hz]")->check(within(1.0, 1000.0))->group(group);
  app.add_option("--drift", d.drift_level, "Slow drift of the zero line")->check(level)->group(group);
  app.add_option("--clicks", d.clicks_per_s, "Electric clicks [1/s]")->check(per_s)->group(group);
  app.add_option("--knocks", d.knocks_per_s, "Knocks of a second object [1/s]")->check(per_s)->group(group);
  app.add_option("--double-hits", d.double_hit_fraction, "Share of impacts followed by a knock within 12 ms")
      ->check(within(0.0, 1.0))
      ->group(group);
  app.add_flag("--robot", d.robot_cycle, "Release click, fan, motors and pick-up; needs --pause 2 or more")
      ->group(group);
  app.add_option("--timbre-wander", d.timbre_wander, "Standard deviation of ln(mode amplitude) between impacts")
      ->check(within(0.0, 3.0))
      ->group(group);
  app.add_option("--phase-wander", d.phase_wander_rad, "Standard deviation of mode phases between impacts [rad]")
      ->check(within(0.0, 10.0))
      ->group(group);
}

}  // namespace

void add_synthesize_options(CLI::App& app, SynthesizeOptions& o) {
  app.option_defaults()->group("Sound");
  synthesis::SynthesisConfig& c = o.config;
  app.add_option("--sensor", o.sensor, "Sensor")->check(CLI::IsMember({"piezo", "microphone"}));
  app.add_option("--channel", o.channels,
                 "Position X,Y[,Z[,GAIN]] of a sensor from the plate's middle [m]; once for each of up to 8 channels; "
                 "GAIN 0 is a dead channel")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--rate", c.rate_hz, "Sample rate [Hz]")->check(within(8000, 2000000));
  app.add_option("--bits", o.bits, "Bits of a sample")->check(CLI::IsMember({"16", "24", "32", "float"}));
  app.add_option("--snr-db", c.snr_db, "Clean peak of the weakest wanted impact over the rms of the noise [dB]")
      ->check(within(-40.0, 200.0));
  app.add_option("--noise-corner", c.noise_corner_hz, "Noise grows like 1/f below this [Hz]; 0: white")
      ->check(within(0.0, 1e6));
  app.add_option("--peak", c.peak, "Clean peak of the strongest impact, full scale = 1; above 1 it is clipped")
      ->check(within(1e-6, 1e3));
  app.add_option("--lead-in", c.lead_in_s, "Before the first release [s]")->check(within(0.01, 3600.0));
  app.add_option("--pause", c.pause_s, "After each drop's last impact [s]")->check(within(0.05, 3600.0));
  app.add_option("--positions", o.positions,
                 "Where the ball strikes: as simulated (where the impacts have states) or drawn, one place a drop")
      ->check(CLI::IsMember({"simulated", "drawn"}));
  app.add_option("--spread", c.start_spread_m, "Drawn positions lie within this of the middle [m]")
      ->check(within(0.0, 10.0));
  app.add_option("--max-mode", c.max_mode_hz, "Modes of the ground up to this [Hz]")->check(within(100.0, 200e3));
  app.add_option("--hard", o.hard_case, hard_case_help());
  add_disturbance_options(app, c.disturbances);
}

Command add_synthesize_command(CLI::App& app) {
  auto options = std::make_shared<SynthesizeOptions>();
  CLI::App* command =
      app.add_subcommand("synthesize", "Impact times to sound: plate, sensor, noise; exact times beside it as truth");
  command->footer("Example: bouncelab synthesize impacts.csv --out recording.flac --snr-db 20 --hum 0.5");
  command->add_option("impacts", options->impacts, "Impacts: FILE.csv or FILE.jsonl")->required();
  command->add_option("--out", options->out, "Sound: .wav (RF64 above 4 GiB), .flac, .w64 or .rf64")
      ->type_name("FILE")
      ->required();
  command->add_option("--truth", options->truth, "True onsets (default OUT without its extension + .truth.csv)")
      ->type_name("FILE");
  command->add_flag("--each-drop", options->each_drop, "One file for each drop: NAME.0000.wav, NAME.0001.wav ...");
  options->world = {};
  add_ball_options(*command, options->world, "those of the impacts' .meta.json, else steel:6mm on glass");
  add_synthesize_options(*command, *options);
  return {command, [options](Run& run) {
            BallChoice& world = options->world = with_provenance(options->world, {options->impacts});
            if (world.ball.empty()) world.ball = kPaperBall.ball;
            if (world.plate.empty()) world.plate = kPaperBall.plate;
            set_parameter(run.parameters, "ball", world.ball);
            set_parameter(run.parameters, "plate", world.plate);
            return run_synthesize(*options, run);
          }};
}

}  // namespace bouncelab::cli
