// SPDX-License-Identifier: GPL-3.0-or-later
/// kernels_bench: the FIR filter of bouncelab::audio, which is compiled for several kinds of processor, against a plain
/// loop compiled as everything else. Prints seconds of one call of each; they take turns, and the least of many counts.
#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "bench_lines.hpp"
#include "bouncelab/audio/dsp.hpp"

namespace {

using Floats = std::vector<float>;

Floats noise(std::size_t n) {
  std::mt19937 generator(1);
  std::normal_distribution<float> normal;
  Floats x(n);
  for (float& value : x) value = normal(generator);
  return x;
}

[[gnu::noinline]] void filter_plainly(const Floats& x, const Floats& taps, Floats& out) {
  std::fill(out.begin(), out.end(), 0.0F);
  for (std::size_t k = 0; k < taps.size(); ++k)
    for (std::size_t n = 0; n < out.size(); ++n) out[n] += taps[k] * x[n + k];
}

}  // namespace

int main() {
  using namespace bouncelab;
  for (const std::size_t n_taps : {34, 50}) {
    const Floats taps = noise(n_taps), x = noise(8192 + n_taps);
    Floats out(8192);
    const bench::Pair least =
        bench::alternating([&] { audio::correlate(x, taps, out); }, [&] { filter_plainly(x, taps, out); });
    const std::string name = "FIR filter of " + std::to_string(n_taps) + " taps over 8192 samples";
    bench::print_line("kernels", name, "bouncelab", least.ours_s, "s");
    bench::print_line("kernels", name, "a plain loop", least.baseline_s, "s");
  }
}
