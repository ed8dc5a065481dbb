// SPDX-License-Identifier: GPL-3.0-or-later
// Where a sound begins that does not begin at once: in steps, behind a codec's noise.
#include <gtest/gtest.h>
#include <sndfile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "support/bouncing_sound.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::detection {
namespace {

using test::BouncingSound;
using Levels = std::array<double, test::kThudModes>;

TEST(FirstArrivals, AreFoundWhereEachSoundRisesInTwoSteps) {
  // the floor first, a wall's louder answer 3.2 ms later: which of them stands out changes from impact to impact
  int n_late = 0;
  int n_impacts = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    BouncingSound b;
    b.rate_hz = 44100.0;
    b.first_flight_s = 0.7;
    b.eps = 0.82;
    b.eps_scatter = 0.01;
    b.n_impacts = 10;
    b.seed = seed;
    const std::vector<double> truth = test::impact_times(b);
    std::vector<float> x(static_cast<std::size_t>((truth.back() + 0.5) * b.rate_hz));
    Random random(seed, RandomStream::test, 2);
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const double v = std::pow(b.eps, static_cast<double>(k));
      Levels floor{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};  // about, since the ball turns
      Levels wall{1.0, -1.0, 1.0, -1.0, 1.0, 1.0};
      for (double& level : floor) level += 0.3 * random.normal();
      for (double& level : wall) level += 0.3 * random.normal();
      test::add_modal_sound(x, b.rate_hz, truth[k], 0.1 * v, test::thud(floor));
      test::add_modal_sound(x, b.rate_hz, truth[k] + 3.2e-3, 0.25 * v, test::thud(wall));
    }
    test::add_low_noise(x, 0.025, seed);
    const Detection d = detect(x, b.rate_hz, "steps");
    n_impacts += b.n_impacts;
    for (const double t_s : truth)
      n_late += std::none_of(d.onsets.begin(), d.onsets.end(),
                             [&](const Onset& onset) { return std::abs(onset.t_s - t_s) < 2e-3; });
  }
  // 6 are: the noise hides their first arrival. Where each impact chooses for itself, 17 are.
  EXPECT_LE(n_late, n_impacts / 20);
}

/// As a phone keeps it.
void write_vorbis(const std::filesystem::path& path, const std::vector<float>& x, double rate_hz, double quality) {
  SF_INFO info{};
  info.samplerate = static_cast<int>(rate_hz);
  info.channels = 1;
  info.format = SF_FORMAT_OGG | SF_FORMAT_VORBIS;
  SNDFILE* file = sf_open(path.c_str(), SFM_WRITE, &info);
  ASSERT_NE(file, nullptr) << sf_strerror(nullptr);
  sf_command(file, SFC_SET_VBR_ENCODING_QUALITY, &quality, sizeof quality);
  constexpr std::size_t kAtOnce = 4096;  // libsndfile overflows its stack with all at once
  for (std::size_t at = 0; at < x.size(); at += kAtOnce)
    sf_write_float(file, x.data() + at, static_cast<sf_count_t>(std::min(kAtOnce, x.size() - at)));
  sf_close(file);
}

TEST(FirstArrivals, AreNotTheNoiseThatACodecPutsInFrontOfThem) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    BouncingSound b;
    b.rate_hz = 44100.0;
    b.eps = 0.93;
    b.n_impacts = 25;
    b.noise_rms = 3e-5;
    b.seed = seed;
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.ogg";
    write_vorbis(path, render(b), b.rate_hz, 0.2);
    const Detection d = detect(path);
    const std::vector<double> truth = test::impact_times(b);
    ASSERT_GE(d.onsets.size(), truth.size()) << "seed " << seed;
    for (std::size_t k = 0; k < truth.size(); ++k)
      EXPECT_NEAR(d.onsets[k].t_s, truth[k], 1e-3) << "seed " << seed << ", impact " << k;
  }
}

}  // namespace
}  // namespace bouncelab::detection
