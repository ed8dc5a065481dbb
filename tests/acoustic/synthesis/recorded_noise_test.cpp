// SPDX-License-Identifier: GPL-3.0-or-later
// The noise of a recording, and the bound that it sets to the times.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "few_impacts.hpp"
#include "scene/background.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"

namespace bouncelab::synthesis {
namespace {

TEST(Synthesis, NoiseIsAsLoudAsTheSnrSays) {
  SynthesisConfig config = quiet();
  config.snr_db = 20.0;
  config.lead_in_s = 3.0;
  for (const double corner_hz : {0.0, 1000.0}) {
    config.noise_corner_hz = corner_hz;
    Impacts two = impacts({0.05, 0.15});
    two.rows[1].v_mps = 0.3;
    two.rows[1].v_after_mps = 0.29;
    const SyntheticRecording recording(two, config);
    const std::vector<double> x = recording.samples();
    const double weakest = recording.truth()[1].amplitude;
    EXPECT_NEAR(recording.truth()[1].snr_db, 20.0, 1e-9);
    EXPECT_NEAR(recording.truth()[0].amplitude, config.peak, 1e-12);
    // 288,000 samples: 0.13% white; a 5 Hz floor leaves some 30 independent values of its slowest third, 10%
    EXPECT_NEAR(rms(std::span(x).first(288000)) / (0.1 * weakest), 1.0, corner_hz > 0.0 ? 0.15 : 0.006);
  }
}

/// Rms error of a matched filter that knows the wave and whitens the noise, over the bound that the truth states.
double matched_filter_error_over_bound(double corner_hz, int n_trials) {
  SynthesisConfig config = quiet();
  config.noise_corner_hz = corner_hz;
  config.lead_in_s = corner_hz > 0.0 ? 0.2 : 0.02;  // the whitening filter has to settle
  config.pause_s = 0.12;                            // what rings on is exp(-20) of the information
  config.levels = Levels{1e-4, 1e-12, 1.0};
  const auto instrument = make_instrument(config);
  const FlickerFilter noise(corner_hz, config.rate_hz);
  const auto wave_at = [&](double offset_samples) {
    return SyntheticRecording(impacts({0.01 + offset_samples / config.rate_hz}), config, instrument).samples();
  };
  // the slope from the wave moved by +-0.05 samples: error (omega 0.05)^2 / 6, at most 0.3%
  constexpr double kMove_samples = 0.05;
  const std::vector<double> ahead = wave_at(-kMove_samples), behind = wave_at(kMove_samples), wave = wave_at(0.0);
  std::vector<double> slope(wave.size());
  for (std::size_t k = 0; k < wave.size(); ++k) slope[k] = (ahead[k] - behind[k]) / (2.0 * kMove_samples);
  noise.whiten(slope);
  double energy = 0.0;
  for (const double s : slope) energy += s * s;
  config.levels->noise_rms = 0.03 * *std::max_element(wave.begin(), wave.end());
  double sum_of_squares = 0.0, bound_s = 0.0;
  for (int trial = 0; trial < n_trials; ++trial) {
    config.seed = static_cast<std::uint64_t>(trial) + 1;
    const SyntheticRecording recording(impacts({0.01}), config, instrument);
    bound_s = recording.truth()[0].sigma_t_s;
    std::vector<double> rest = recording.samples();
    for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= wave[k];
    noise.whiten(rest);
    // one Newton step from the truth: errors are hundredths of a sample, where the likelihood is a parabola
    double shift = 0.0;
    for (std::size_t k = 0; k < rest.size(); ++k) shift += rest[k] * slope[k] / energy;
    sum_of_squares += shift * shift;
  }
  return std::sqrt(sum_of_squares / n_trials) / config.rate_hz / bound_s;
}

TEST(Synthesis, AMatchedFilterThatKnowsTheWaveReachesTheBoundAlsoInFlickerNoise) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  for (const auto& [corner_hz, n_trials] :
       {std::pair{0.0, test::repetitions(200, 2000)}, std::pair{500.0, test::repetitions(40, 400)}})
    // an rms of n trials is known to 1/sqrt(2 n): three of these
    EXPECT_NEAR(matched_filter_error_over_bound(corner_hz, n_trials), 1.0, 3.0 / std::sqrt(2.0 * n_trials))
        << corner_hz;
}

}  // namespace
}  // namespace bouncelab::synthesis
