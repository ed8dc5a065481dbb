// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "commands/synthesize_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

namespace {

std::string hard_case_help() {
  std::string help = "A recording in which impacts are hard to detect:";
  for (const synthesis::HardCase& hard : synthesis::hard_cases()) help += "\n  " + hard.name + ": " + hard.what;
  return help;
}

}  // namespace

const Description& members_of(const SynthesizeOptions*) {
  using O = SynthesizeOptions;
  static const Description options{
      member("sensor", &O::sensor, "Sensor").one_of({"piezo", "microphone"}),
      member("channel", &O::channels,
             "Position X,Y[,Z[,GAIN]] of a sensor from the plate's middle [m]; once for each of up to 8 channels; GAIN "
             "0 is a dead channel"),
      member<O>(
          "rate", [](auto& o) -> auto& { return o.config.rate_hz; }, "Sample rate [Hz]")
          .within(8000, 2e6),
      member("bits", &O::bits, "Bits of a sample").one_of({"16", "24", "32", "float"}),
      member<O>(
          "snr_db", [](auto& o) -> auto& { return o.config.snr_db; },
          "Clean peak of the weakest wanted impact over the rms of the noise [dB]")
          .within(-40.0, 200.0),
      member<O>(
          "noise_corner", [](auto& o) -> auto& { return o.config.noise_corner_hz; },
          "Noise grows like 1/f below this [Hz]; 0: white")
          .within(0.0, 1e6),
      member<O>(
          "peak", [](auto& o) -> auto& { return o.config.peak; },
          "Clean peak of the strongest impact, full scale = 1; above 1 it is clipped")
          .within(1e-6, 1e3),
      member<O>(
          "lead_in", [](auto& o) -> auto& { return o.config.lead_in_s; }, "Before the first release [s]")
          .within(0.01, 3600.0),
      member<O>(
          "pause", [](auto& o) -> auto& { return o.config.pause_s; }, "After each drop's last impact [s]")
          .within(0.05, 3600.0),
      member("positions", &O::positions,
             "Where the ball strikes: as simulated (where the impacts have states) or drawn, one place a drop")
          .one_of({"simulated", "drawn"}),
      member<O>(
          "spread", [](auto& o) -> auto& { return o.config.start_spread_m; },
          "Drawn positions lie within this of the middle [m]")
          .within(0.0, 10.0),
      member<O>(
          "max_mode", [](auto& o) -> auto& { return o.config.max_mode_hz; }, "Modes of the ground up to this [Hz]")
          .within(100.0, 200e3),
      member("hard", &O::hard_case, hard_case_help())};
  return options;
}

Command synthesize_command() {
  using O = SynthesizeOptions;
  static const Description files{
      member("impacts", &O::impacts, "Impacts: FILE.csv or FILE.jsonl").required().positional(),
      member("out", &O::out, "Sound: .wav (RF64 above 4 GiB), .flac, .w64 or .rf64").looks_like("FILE").required(),
      member("truth", &O::truth, "True onsets (default OUT without its extension + .truth.csv)").looks_like("FILE"),
      member("each_drop", &O::each_drop, "One file for each drop: NAME.0000.wav, NAME.0001.wav ...")};
  static const Description ball = ball_options("those of the impacts' .meta.json, else steel:6mm on glass");
  auto options = std::make_shared<O>();
  options->world = {};
  return {"synthesize",
          "Impact times to sound: plate, sensor, noise; exact times beside it as truth",
          "Example: bouncelab synthesize impacts.csv --out recording.flac --snr-db 20 --hum 0.5",
          {{"", &files, options.get()},
           {"", &ball, &options->world},
           {"Sound", &members_of(options.get()), options.get()},
           disturbances_section(*options)},
          [options](Run& run) {
            BallChoice& world = options->world = with_provenance(options->world, {options->impacts});
            if (world.ball.empty()) world.ball = kPaperBall.ball;
            if (world.plate.empty()) world.plate = kPaperBall.plate;
            set_parameter(run.parameters, "ball", world.ball);
            set_parameter(run.parameters, "plate", world.plate);
            return run_synthesize(*options, run);
          }};
}

Section disturbances_section(SynthesizeOptions& options) {
  synthesis::Disturbances& disturbances = options.config.disturbances;
  return {"Disturbances (levels in units of the weakest wanted impact's peak)", &members_of(&disturbances),
          &disturbances};
}

}  // namespace bouncelab::cli
