// SPDX-License-Identifier: GPL-3.0-or-later
// The detector with other numbers in its models, as a detector for `bouncelab validate` (tests/bench/ablation.py):
//
//     detect_with [--set NAME=VALUE]... [--channel C] RECORDING
//
// prints the time of each impact and its standard error [s].
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>
#include <string_view>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/detection/detect.hpp"
#include "model_numbers.hpp"

int main(int argc, char** argv) {
  using namespace bouncelab;
  try {
    detection::DetectionConfig config;
    for (int k = 1; k + 2 < argc; k += 2) {
      if (std::string_view(argv[k]) == "--channel")
        config.channel = std::stoi(argv[k + 1]);
      else
        detection::set_number(argv[k + 1]);
    }
    for (const Onset& onset : detection::detect(argc > 1 ? argv[argc - 1] : "", config).onsets) {
      fmt::print("{:.9f}", onset.t_s);
      if (onset.sigma_t_s) fmt::print(" {:.4g}", *onset.sigma_t_s);
      fmt::print("\n");
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
