// SPDX-License-Identifier: GPL-3.0-or-later
/// synthesis_bench: the synthesizer on one thread, in seconds a second of sound: one drop at one point, many points,
/// noise alone; against the direct sum over impacts and modes; and its peak memory.
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
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

void print_line(const std::string& of, const char* what, double value, const char* unit) {
  bench::print_line("synthesize", of, what, value, unit);
}

/// The paper's drops without scatter.
Impacts smooth_drops(int n_drops) {
  Impacts impacts;
  for (int drop = 0; drop < n_drops; ++drop) {
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
Impacts wandering_drops(int n_drops) {
  Impacts impacts = smooth_drops(n_drops);
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

/// A recording for each drop, with levels given, rounded as in a file: what a long loop does in memory.
double drop_by_drop_s_per_s(const Impacts& all, synthesis::SynthesisConfig config) {
  const auto instrument = synthesis::make_instrument(config);
  config.levels = synthesis::SyntheticRecording(all, config, instrument).levels();
  double sound_s = 0.0;
  const double seconds = bench::seconds_of([&] {
    for (int drop = 0; drop < 2 * kDrops; ++drop) {
      const synthesis::SyntheticRecording one(smooth_drops(1), synthesis::config_of_drop(config, *config.levels, drop),
                                              instrument);
      sink = one.samples_as_read_back().front();
      sound_s += static_cast<double>(one.n_frames()) / config.rate_hz;
    }
  });
  return seconds / sound_s;
}

/// Of segments long after the last impact has decayed.
double noise_s_per_s(synthesis::SynthesisConfig config) {
  config.pause_s = 120.0;
  const synthesis::SyntheticRecording recording(smooth_drops(1), config);
  const std::int64_t last = recording.n_segments() - 2;
  const double seconds = bench::least_s([&] { sink = recording.segment(last).front(); }, 10, 0.0);
  return seconds * config.rate_hz / static_cast<double>(recording.segment_frames());
}

/// Through a file at 8 kHz: the impacts are as many as at any rate.
void print_memory(int n_drops, synthesis::SynthesisConfig config) {
  config.rate_hz = 8000;
  config.encoding = audio::SampleEncoding::pcm16;
  const Impacts one = smooth_drops(1);
  const synthesis::DropSource drops = [&one, n_drops](std::int64_t k, Impacts& drop) {
    drop = one;
    for (Impact& impact : drop.rows) impact.drop = k;
    return k < n_drops;
  };
  const std::filesystem::path out =
      std::filesystem::temp_directory_path() / ("synthesis_bench_" + std::to_string(::getpid()) + ".wav");
  const synthesis::SynthesisResult result = synthesis::synthesize(drops, config, out, true);
  std::filesystem::remove(out);
  const std::string name = std::to_string(result.n_impacts) + " impacts to a file";
  print_line(name, "sound", result.duration_s, "s");
  print_line(name, "peak memory so far", bench::peak_bytes(), "B");
}

}  // namespace

int main() {
  synthesis::SynthesisConfig config;
  for (const int n_drops : {5, 1000}) print_memory(n_drops, config);
  const Impacts one_point = smooth_drops(kDrops), many_points = wandering_drops(kDrops);
  for (const int rate_hz : {44100, 96000}) {
    config.rate_hz = rate_hz;
    config.max_mode_hz = rate_hz < 96000 ? 20.0e3 : 45.0e3;
    const std::string rate = std::to_string(rate_hz) + " Hz";
    print_line(rate, "modes",
               static_cast<double>(synthesis::PlateModes(config.ground, config.max_mode_hz).modes().size()), "1");
    print_line(rate, "one point a drop", synthesis_s_per_s(one_point, config), "s/s");
    print_line(rate, "direct sum", direct_sum_s_per_s(one_point, config), "s/s");
    print_line(rate, "a point for each impact", synthesis_s_per_s(many_points, config), "s/s");
    print_line(rate, "a recording for each drop", drop_by_drop_s_per_s(one_point, config), "s/s");
    print_line(rate, "noise alone", noise_s_per_s(config), "s/s");
  }
}
