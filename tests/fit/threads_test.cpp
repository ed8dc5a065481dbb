// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "bouncelab/fit/calibration.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/json.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

/// Threads that the process has, those included that wait for work.
int n_threads_now() {
  return static_cast<int>(std::distance(std::filesystem::directory_iterator("/proc/self/task"), {}));
}

/// Runs the work and counts the threads that there are while it reports its progress.
template <class Work>
void expect_threads(int n, const Work& work) {
  int n_most = 0;
  work([&](double, double) { n_most = std::max(n_most, n_threads_now()); });
  EXPECT_LE(n_most, n);
  EXPECT_GE(n_most, std::min(n, 2));
}

FitConfig config_with(int n_threads) {
  FitConfig config;
  config.n_threads = n_threads;
  config.n_goodness = 9;
  config.law.n_bootstrap = 9;
  return config;
}

TEST(FitThreads, OfFitAllAreNoMoreThanItMayStart) {
  const auto samples = testing::independent_samples({}, 5000, 0.2, 1.4, 1e-4);
  for (const int n : {1, 3})
    expect_threads(n, [&](const ProgressCallback& progress) { fit_all(samples, config_with(n), progress); });
}

TEST(FitThreads, OfCalibrateAreNoMoreThanItMayStart) {
  CalibrationConfig config;
  config.n_samples = 5000;
  config.n_seeds = 2;
  for (config.n_threads = 1; config.n_threads <= 3; config.n_threads += 2)
    expect_threads(config.n_threads, [&](const ProgressCallback& progress) { calibrate(config, progress); });
}

TEST(FitThreads, TheResultDoesNotDependOnTheirNumber) {
  const auto samples = testing::independent_samples({}, 5000, 0.2, 1.4, 1e-4);
  const std::string one = to_json(fit_all(samples, config_with(1)));
  EXPECT_EQ(to_json(fit_all(samples, config_with(3))), one);
  EXPECT_EQ(to_json(fit_all(samples, config_with(8))), one);
}

}  // namespace
}  // namespace bouncelab::fit
