// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/detect.hpp"

namespace bouncelab::cli {

Member recordings_member() {
  return member("recordings", &DetectOptions::recordings,
                "Recordings: WAV, FLAC, MP3 ...; m4a, mp4 and others by ffmpeg; .npy, .csv of samples; - = standard "
                "input")
      .positional();
}
Member list_member() {
  return member("list", &DetectOptions::list, "File with more recordings, one a line").looks_like("FILE");
}

Command detect_command() {
  static const Description files{
      recordings_member(), list_member(),
      member("out", &DetectOptions::out, "Onsets, .csv").looks_like("FILE").required(),
      member("labels", &DetectOptions::labels, "Also an Audacity label track").looks_like("FILE")};
  auto options = std::make_shared<DetectOptions>();
  return {"detect",
          "Impact times of bouncing balls in recordings, with standard errors; nothing has to be set",
          "Example: bouncelab detect drop.wav --out onsets.csv --labels drop.txt",
          {{"", &files, options.get()}, {"Detection", &members_of(&options->config), &options->config}},
          [options](Run& run) { return run_detect(*options, run); }};
}

}  // namespace bouncelab::cli
