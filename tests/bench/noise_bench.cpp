// SPDX-License-Identifier: GPL-3.0-or-later
/// noise_bench: the detector on noise in memory, which holds no impact: what every sample costs before there is
/// anything to be timed (its linear prediction, innovations and their energy, candidates).
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "bench_lines.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/detection/detect.hpp"

int main() {
  using namespace bouncelab;
  constexpr int kSeconds = 60;
  for (const int rate_hz : {44100, 96000}) {
    std::mt19937 generator(1);
    std::normal_distribution<float> normal(0.0F, 0.01F);
    std::vector<float> noise(static_cast<std::size_t>(kSeconds) * static_cast<std::size_t>(rate_hz));
    for (float& x : noise) x = normal(generator);
    double seconds = 0.0;
    with_threads(1, [&] { seconds = bench::least_s([&] { detection::detect(noise, rate_hz, "noise"); }, 5, 0.0); });
    bench::print_line("detect", "noise in memory, " + std::to_string(rate_hz) + " Hz", "bouncelab, a sample",
                      seconds / static_cast<double>(noise.size()), "s");
  }
}
