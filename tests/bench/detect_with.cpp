// SPDX-License-Identifier: GPL-3.0-or-later
// `bouncelab detect` with other numbers in the detector's models, for tests/bench/ablation.py:
//
//     detect_with [--set NAME=VALUE]... detect RECORDING --out ONSETS.csv [--channel C]
//
// Writes the onsets and prints the length of the recording as `bouncelab detect --json` does; other options of it are
// taken and change nothing.
#include <fmt/format.h>
#include <fmt/os.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/detection/detect.hpp"
#include "model_numbers.hpp"

namespace {

using namespace bouncelab;

int run(const std::vector<std::string_view>& arguments) {
  std::string recording, table;
  detection::DetectionConfig config;
  for (std::size_t k = 0; k + 1 < arguments.size(); ++k) {
    if (arguments[k] == "--set") detection::set_number(arguments[++k]);
    if (arguments[k] == "detect") recording = arguments[++k];
    if (arguments[k] == "--out") table = arguments[++k];
    if (arguments[k] == "--channel") config.channel = std::stoi(std::string(arguments[++k]));
  }
  const detection::Detection found = detection::detect(recording, config);
  auto file = fmt::output_file(table);
  file.print("drop,t_s,sigma_t_s,flags\n");
  for (const Onset& onset : found.onsets)
    file.print("{},{:.9f},{},{}\n", onset.drop, onset.t_s, onset.sigma_t_s.value_or(NAN), onset.flags.text());
  fmt::print("{{\"recordings\": [{{\"duration_s\": {}}}]}}\n", found.summary.duration_s);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
