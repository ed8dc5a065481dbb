// SPDX-License-Identifier: GPL-3.0-or-later
/// synthesis_bench: the synthesizer on one thread, in seconds a second of sound, with all impacts of a drop at one
/// point and each at its own; against the direct sum over impacts and modes.
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "bench_lines.hpp"
#include "bouncelab/acoustic/acoustic.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/restitution_law.hpp"

namespace {

using namespace bouncelab;

constexpr int kDrops = 10, kImpacts = 95;
volatile double sink;  // what is not used is not computed

/// The paper's drops without scatter.
Impacts smooth_drops() {
  Impacts impacts;
  for (int drop = 0; drop < kDrops; ++drop) {
    double v_mps = std::sqrt(2.0 * kDefaultGravity_mps2 * 0.095), t_s = v_mps / kDefaultGravity_mps2;
    for (int k = 0; k < kImpacts; ++k) {
      const double eps = restitution(SeriesLaw{}, v_mps);
      impacts.rows.push_back({drop, k, t_s, v_mps, eps * v_mps, eps, v_mps, eps, -1});
      v_mps *= eps;
      t_s += 2.0 * v_mps / kDefaultGravity_mps2;
    }
  }
  return impacts;
}

/// The same, each impact at a point of its own, on a spiral of 2 cm.
Impacts wandering_drops() {
  Impacts impacts = smooth_drops();
  for (std::size_t k = 0; k < impacts.rows.size(); ++k) {
    const double share = static_cast<double>(k % kImpacts) / kImpacts, angle = 0.7 * static_cast<double>(k);
    ImpactState state;
    state.position_m = {0.02 * share * std::cos(angle), 0.02 * share * std::sin(angle), 0.0};
    impacts.states.push_back(state);
  }
  return impacts;
}

/// Baseline: every impact rings every mode until it has decayed by 1e-11, one sine and one exponential a sample.
double direct_sum_s_per_s(const Impacts& impacts, const synthesis::SynthesisConfig& config) {
  constexpr double kDuration_s = 4.0;
  const synthesis::PlateModes plate(config.ground, config.max_mode_hz);
  std::vector<double> out(static_cast<std::size_t>(kDuration_s * config.rate_hz));
  const double rate_hz = config.rate_hz;
  const double seconds = bench::seconds_of([&] {
    for (const Impact& impact : impacts.rows) {
      if (impact.t_s >= kDuration_s) break;
      for (const synthesis::PlateMode& mode : plate.modes()) {
        const auto first = static_cast<std::size_t>(impact.t_s * rate_hz) + 1;
        const auto n = static_cast<std::size_t>(std::log(1e11) / mode.decay_per_s * rate_hz);
        for (std::size_t k = first; k < std::min(first + n, out.size()); ++k) {
          const double t_s = static_cast<double>(k) / rate_hz - impact.t_s;
          out[k] += impact.v_mps * std::exp(-mode.decay_per_s * t_s) * std::sin(2.0 * kPi * mode.frequency_hz * t_s);
        }
      }
    }
  });
  sink = out.back();
  return seconds / kDuration_s;
}

/// Everything, segment by segment, plate and tables made before.
double synthesis_s_per_s(const Impacts& impacts, const synthesis::SynthesisConfig& config) {
  const auto instrument = synthesis::make_instrument(config);
  double least = 1e300;
  for (int round = 0; round < 3; ++round) {
    double sound_s = 0.0;
    const double seconds = bench::seconds_of([&] {
      const synthesis::SyntheticRecording recording(impacts, config, instrument);
      for (std::int64_t k = 0; k < recording.n_segments(); ++k) sink = recording.segment(k).front();
      sound_s = static_cast<double>(recording.n_frames()) / config.rate_hz;
    });
    least = std::min(least, seconds / sound_s);
  }
  return least;
}

}  // namespace

int main() {
  synthesis::SynthesisConfig config;
  const Impacts one_point = smooth_drops(), many_points = wandering_drops();
  for (const int rate_hz : {44100, 96000}) {
    config.rate_hz = rate_hz;
    config.max_mode_hz = rate_hz < 96000 ? 20.0e3 : 45.0e3;
    const std::string rate = std::to_string(rate_hz) + " Hz";
    const auto print = [&](const char* what, double seconds) {
      bench::print_line("synthesize", rate, what, seconds, "s/s");
    };
    print("one point a drop", synthesis_s_per_s(one_point, config));
    print("direct sum", direct_sum_s_per_s(one_point, config));
    print("a point for each impact", synthesis_s_per_s(many_points, config));
  }
}
