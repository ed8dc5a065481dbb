// SPDX-License-Identifier: GPL-3.0-or-later
#include "few_samples.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/random.hpp"
#include "law/normal_laplace.hpp"

namespace bouncelab::testing {
namespace {

double two_exponentials(double below, double above, Random& random) {
  return random.uniform() < above / (above + below) ? above * random.exponential() : -below * random.exponential();
}

double draw(FewScatter scatter, Random& random) {
  constexpr double kNormalPart = 0.0010, kBelow = 0.0010, kAbove = 0.0005;
  switch (scatter) {
    case FewScatter::normal:
    case FewScatter::one_lost:
      return 0.0015 * random.normal();
    case FewScatter::laplace:
      return two_exponentials(0.0012, 0.0012, random);
    case FewScatter::asymmetric:
      return two_exponentials(0.0016, 0.0010, random);
    case FewScatter::strong_asymmetry:
      return two_exponentials(0.0020, 0.0008, random);
    case FewScatter::student_t3: {
      double chi2 = 0.0;
      for (int i = 0; i < 3; ++i) chi2 += std::pow(random.normal(), 2);
      return 0.0012 * random.normal() / std::sqrt(chi2 / 3.0);
    }
    case FewScatter::asymmetric_normal: {
      const double size = std::sqrt(kBelow * kAbove);
      return two_exponentials(kBelow, kAbove, random) + kNormalPart * random.normal() -
             size * fit::mode_offset(std::log(kAbove / kBelow), std::log(kNormalPart / size)).value;
    }
  }
  return 0.0;
}

}  // namespace

const char* to_string(FewScatter scatter) {
  constexpr std::array kNames{"normal",   "Laplace",          "asymmetric Laplace", "Student t(3)",
                              "one lost", "strong asymmetry", "asymmetric, normal"};
  return kNames[static_cast<std::size_t>(scatter)];
}

double few_samples_eps(double v_mps) { return 0.9505 - 0.008 * v_mps; }

RestitutionSamples few_samples(FewScatter scatter, std::size_t n, std::uint64_t seed) {
  constexpr double kFrom_mps = 0.08, kTo_mps = 0.95;
  Random random(seed, RandomStream::test, 1000 * n + static_cast<std::uint64_t>(scatter));
  RestitutionSamples samples(n);
  for (std::size_t k = 0; k < n; ++k) {
    RestitutionSample& s = samples[k];
    s.impact = static_cast<std::int64_t>(k);
    s.v_mps = kFrom_mps * std::pow(kTo_mps / kFrom_mps, static_cast<double>(k) / static_cast<double>(n - 1));
    s.eps = few_samples_eps(s.v_mps) + draw(scatter, random);
  }
  if (scatter == FewScatter::one_lost)
    samples[std::min(n - 1, static_cast<std::size_t>(random.uniform() * static_cast<double>(n)))].eps -= 0.02;
  return samples;
}

}  // namespace bouncelab::testing
