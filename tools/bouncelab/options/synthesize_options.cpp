// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>
#include <utility>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "options/commands.hpp"
#include "stages/ball_of_files.hpp"
#include "stages/synthesize.hpp"

namespace bouncelab::cli {

namespace {

Description truth_columns() {
  Description all = description_of(columns_of(static_cast<const synthesis::TrueImpact*>(nullptr)));
  Member recording;
  recording.name = "recording";
  recording.text = "File of the sound";
  all.insert(all.begin(), std::move(recording));
  return all;
}

}  // namespace

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
           {"", &codec_option(), options.get()},
           disturbances_section(*options)},
          [options](Run& run) {
            BallChoice& world = options->world = with_provenance(options->world, {options->impacts});
            if (world.ball.empty()) world.ball = kPaperBall.ball;
            if (world.plate.empty()) world.plate = kPaperBall.plate;
            set_parameter(run.parameters, "ball", world.ball);
            set_parameter(run.parameters, "plate", world.plate);
            keep_conditions_of(options->impacts, run.parameters);
            return run_synthesize(*options, run);
          },
          {},
          false,
          {{"Columns of the truth, a row for each impact", truth_columns()}}};
}

}  // namespace bouncelab::cli
