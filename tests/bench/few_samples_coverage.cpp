// SPDX-License-Identifier: GPL-3.0-or-later
// Are the intervals of eps(v) honest when there are few samples, and when the scatter is not what the fit assumes?
// few_samples_coverage [REPLICATES [FIRST_SEED [N ...]]]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "../fit/few_samples.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace {

using namespace bouncelab;

const std::vector<double> kSpeeds_mps{0.12, 0.3, 0.7};

struct Cell {
  double n = 0.0, covered = 0.0, pull = 0.0, pull2 = 0.0, width = 0.0, failed = 0.0;
};

Cell cell(testing::FewScatter scatter, std::size_t n, std::size_t n_replicates, std::size_t first_seed) {
  std::vector<fit::LawFit> fits(n_replicates);
  parallel_for(n_replicates, 0, [&](std::size_t i) {
    fit::LawFitConfig config;
    config.node_speeds_mps = kSpeeds_mps;
    fits[i] = fit::fit_law(testing::few_samples(scatter, n, first_seed + i), config);
  });
  Cell sum;
  for (const fit::LawFit& fit : fits) {
    if (fit.nodes.empty()) ++sum.failed;
    for (const fit::NodeEstimate& node : fit.nodes) {
      const double truth = testing::few_samples_eps(node.v_mps), pull = (node.eps.value - truth) / *node.eps.se;
      ++sum.n;
      sum.covered += node.eps.ci95->lo <= truth && truth <= node.eps.ci95->hi ? 1.0 : 0.0;
      sum.pull += pull;
      sum.pull2 += pull * pull;
      sum.width += node.eps.ci95->hi - node.eps.ci95->lo;
    }
  }
  return sum;
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t n_replicates = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 300;
  const std::size_t first_seed = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1;
  std::vector<std::size_t> numbers;
  for (int i = 3; i < argc; ++i) numbers.push_back(std::strtoul(argv[i], nullptr, 10));
  if (numbers.empty()) numbers = {8, 12, 40, 150, 1000};
  with_threads(0, [&] {
    for (const std::size_t n : numbers)
      for (const auto scatter : testing::kFewScatters) {
        if (getenv("ONLY") && !strchr(getenv("ONLY"), '0' + static_cast<int>(scatter))) continue;
        const Cell c = cell(scatter, n, n_replicates, first_seed);
        const double mean = c.pull / c.n;
        std::printf("n %5zu %-19s 95 %% intervals cover %.3f, pull mean %+.2f, sd %.2f, width %.5f, failed %.0f\n", n,
                    to_string(scatter), c.covered / c.n, mean, std::sqrt(c.pull2 / c.n - mean * mean), c.width / c.n,
                    c.failed);
        std::fflush(stdout);
      }
  });
}
