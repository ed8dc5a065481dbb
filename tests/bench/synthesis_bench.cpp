// SPDX-License-Identifier: GPL-3.0-or-later
/// Speed of the synthesizer on one thread, against sound and against a direct sum over impacts and modes; memory.
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bouncelab/acoustic/acoustic.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/units.hpp"

namespace {

using namespace bouncelab;

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double peak_memory_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

Impacts smooth_drops(int n_drops) {
  Impacts impacts;
  for (int drop = 0; drop < n_drops; ++drop) {
    double v_mps = std::sqrt(2.0 * kDefaultGravity_mps2 * 0.095), t_s = v_mps / kDefaultGravity_mps2;
    for (int k = 0; k < 95; ++k) {
      const double eps = restitution(SeriesLaw{}, v_mps);
      impacts.rows.push_back({drop, k, t_s, v_mps, eps * v_mps, eps, v_mps, eps, -1});
      v_mps *= eps;
      t_s += 2.0 * v_mps / kDefaultGravity_mps2;
    }
  }
  return impacts;
}

/// Baseline: every impact rings every mode until it has decayed by 1e-11, one sine and one exponential a sample.
double direct_sum_s_per_s_of_sound(const Impacts& impacts, const synthesis::SynthesisConfig& config,
                                   double duration_s) {
  const synthesis::PlateModes plate(config.ground, config.max_mode_hz);
  std::vector<double> out(static_cast<std::size_t>(duration_s * config.rate_hz));
  const double rate_hz = config.rate_hz, begin_s = now_s();
  for (const Impact& impact : impacts.rows) {
    if (impact.t_s >= duration_s) break;
    for (const synthesis::PlateMode& mode : plate.modes()) {
      const auto first = static_cast<std::size_t>(impact.t_s * rate_hz) + 1;
      const auto n = static_cast<std::size_t>(std::log(1e11) / mode.decay_per_s * rate_hz);
      for (std::size_t k = first; k < std::min(first + n, out.size()); ++k) {
        const double t_s = static_cast<double>(k) / rate_hz - impact.t_s;
        out[k] += impact.v_mps * std::exp(-mode.decay_per_s * t_s) * std::sin(2.0 * kPi * mode.frequency_hz * t_s);
      }
    }
  }
  return (now_s() - begin_s) / duration_s;
}

/// Renders everything, segment by segment; returns seconds per second of sound.
double synthesis_s_per_s_of_sound(const Impacts& impacts, const synthesis::SynthesisConfig& config, double& sum) {
  const auto instrument = synthesis::make_instrument(config);
  const double begin_s = now_s();
  const synthesis::SyntheticRecording recording(impacts, config, instrument);
  for (std::int64_t k = 0; k < recording.n_segments(); ++k) sum += recording.segment(k).front();
  return (now_s() - begin_s) * config.rate_hz / static_cast<double>(recording.n_frames());
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
  std::printf("%6.1f min of sound with %lld impacts to a file: peak memory of the process %.1f MiB\n",
              result.duration_s / 60.0, static_cast<long long>(result.n_impacts), peak_memory_mib());
}

}  // namespace

int main() {
  synthesis::SynthesisConfig config;
  double sum = 0.0;
  const Impacts ten = smooth_drops(10);
  for (const double max_mode_hz : {27.0e3, 45.0e3}) {
    config.max_mode_hz = max_mode_hz;
    const std::size_t n_modes = synthesis::PlateModes(config.ground, max_mode_hz).modes().size();
    const double ours = synthesis_s_per_s_of_sound(ten, config, sum);
    const double direct = direct_sum_s_per_s_of_sound(ten, config, 8.0);
    std::printf(
        "96 kHz, %zu modes: %.0f x real time on one thread, %.0f x faster than the direct sum (modes only, no noise)\n",
        n_modes, 1.0 / ours, direct / ours);
  }
  // one drop after the other, with levels given: what a long loop does in memory
  config.max_mode_hz = 45.0e3;
  const auto instrument = synthesis::make_instrument(config);
  config.levels = synthesis::SyntheticRecording(ten, config, instrument).levels();
  const double begin_s = now_s();
  double sound_s = 0.0;
  for (int drop = 0; drop < 20; ++drop) {
    const synthesis::SyntheticRecording one(smooth_drops(1), synthesis::config_of_drop(config, *config.levels, drop),
                                            instrument);
    for (std::int64_t k = 0; k < one.n_segments(); ++k) sum += one.segment(k).front();
    sound_s += static_cast<double>(one.n_frames()) / config.rate_hz;
  }
  std::printf("96 kHz, %zu modes, a recording a drop: %.0f x real time on one thread\n",
              synthesis::PlateModes(config.ground, config.max_mode_hz).modes().size(), sound_s / (now_s() - begin_s));
  config.levels.reset();
  for (const int n_drops : {5, 300, 3000}) print_memory(n_drops, config);
  return std::isfinite(sum) ? 0 : 1;
}
