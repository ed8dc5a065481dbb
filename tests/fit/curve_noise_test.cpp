// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/plate_samples.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>

#include "bouncelab/core/random.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kG_mps2 = 9.81, kSigmaT_s = 2e-4, kMiddle = -0.4;
constexpr Eigen::Index kOnsets = 24;

/// Two drops, of one a row is missing: a gap between its impacts.
RestitutionSamples of_two_drops() {
  Random random(3, RandomStream::test, 0);
  RestitutionSamples samples;
  for (std::int64_t drop = 0; drop < 2; ++drop) {
    double v = 1.6;
    for (std::int64_t impact = 1; impact <= (drop == 0 ? 6 : 9); ++impact) {
      RestitutionSample s;
      s.drop = drop;
      s.impact = impact;
      s.v_mps = v;
      s.eps = 0.8 + 0.03 * random.normal();
      const double before_s = 2.0 * v / kG_mps2;
      s.sigma_eps = kSigmaT_s / before_s * std::sqrt(s.eps * s.eps + (1.0 + s.eps) * (1.0 + s.eps) + 1.0);
      s.conditions.gravity_mps2 = kG_mps2;
      if (drop == 0 || impact != 5) samples.push_back(s);
      v *= s.eps;
    }
  }
  return samples;
}

AirAndContact in_vacuum() {
  AirAndContact known;
  known.gravity_mps2 = kG_mps2;
  known.has_drag = known.has_contact = false;
  return known;
}

/// Of errors of the onsets, each eps being the ratio of two intervals.
Eigen::MatrixXd timing_of(const RestitutionSamples& samples) {
  Eigen::MatrixXd by_onset = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(samples.size()), kOnsets);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const RestitutionSample& s = samples[k];
    const auto row = static_cast<Eigen::Index>(k), onset = static_cast<Eigen::Index>(12 * s.drop + s.impact);
    const double before_s = 2.0 * s.v_mps / kG_mps2;
    by_onset(row, onset - 1) = s.eps / before_s;
    by_onset(row, onset) = -(1.0 + s.eps) / before_s;
    by_onset(row, onset + 1) = 1.0 / before_s;
  }
  return kSigmaT_s * kSigmaT_s * by_onset * by_onset.transpose();
}

TEST(PlateSamples, HaveTheCovarianceOfTheErrorsOfTheirOnsets) {
  const RestitutionSamples samples = of_two_drops();
  const PlateSamples plate = plate_samples(samples, in_vacuum(), {});
  const Eigen::MatrixXd timing = timing_of(samples);
  ASSERT_EQ(plate.size(), 14);
  ASSERT_EQ(plate.pieces.size(), 2u);
  EXPECT_EQ(plate.n_drops, 2u);
  for (const PlateSamples::Piece& piece : plate.pieces)
    for (Eigen::Index i = 0; i < piece.n; ++i)
      for (Eigen::Index lag = 0; lag <= 2; ++lag) {
        const double expected = i + lag < piece.n ? timing(piece.begin + i, piece.begin + i + lag) : 0.0;
        EXPECT_NEAR(plate.timing(piece.begin + i, lag), expected, 1e-12 * timing.maxCoeff()) << i << " " << lag;
      }
}

TEST(PlateSamples, OfATableOfSpeedsHaveErrorsOfTheirOwn) {
  RestitutionSamples samples = of_two_drops();
  for (RestitutionSample& s : samples) s.conditions.gravity_mps2.reset();
  const PlateSamples plate = plate_samples(samples, in_vacuum(), {});
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    EXPECT_NEAR(plate.timing(row, 0), *samples[k].sigma_eps * *samples[k].sigma_eps, 1e-15);
    EXPECT_EQ(plate.timing(row, 1), 0.0);
    EXPECT_EQ(plate.timing(row, 2), 0.0);
    EXPECT_EQ(plate.eps[row], samples[k].eps);
  }
}

TEST(CurveNoise, GramIsTheDenseOneWhateverDropsShare) {
  const RestitutionSamples samples = of_two_drops();
  const PlateSamples plate = plate_samples(samples, in_vacuum(), {});
  const Eigen::Index n = plate.size();
  Random random(4, RandomStream::test, 0);
  Eigen::MatrixXd columns(n, 3);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < 3; ++j) columns(i, j) = random.normal();
  Eigen::VectorXd inflation = Eigen::VectorXd::Ones(n);
  inflation[3] = 100.0;
  for (const Noise& noise : {Noise{std::log(0.004), 0.0, 0.0, 1.0}, Noise{std::log(0.004), 0.5, 0.0, 1.0},
                             Noise{std::log(0.004), 1.0, 0.7, 1.0}, Noise{std::log(0.004), 0.5, 2.8, 0.8},
                             Noise{std::log(1e-6), 0.0, 1e3, 1.0}}) {
    Eigen::MatrixXd covariance = timing_of(samples);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) {
        if (samples[static_cast<std::size_t>(i)].drop != samples[static_cast<std::size_t>(j)].drop) continue;
        const double apart = std::abs(plate.impact[i] - plate.impact[j]);
        const double sizes = std::exp(2.0 * noise.ln_s - noise.power * (plate.x[i] + plate.x[j] - 2.0 * kMiddle));
        covariance(i, j) +=
            sizes * (noise.rho * noise.rho * std::pow(noise.phi, apart) + (i == j ? inflation[i] : 0.0));
      }
    const Eigen::LLT<Eigen::MatrixXd> root(covariance);
    const Eigen::MatrixXd expected = columns.transpose() * root.solve(columns);
    const Gram gram = gram_of(plate, kMiddle, inflation, columns, noise);
    // rounding times the condition, which is that of the timing, some 1e3
    EXPECT_LT((gram.of - expected).norm(), 1e-9 * expected.norm()) << noise.power << " " << noise.rho;
    EXPECT_NEAR(gram.ln_det, 2.0 * root.matrixLLT().diagonal().array().log().sum(), 1e-9);
  }
}

TEST(CurveNoise, VarianceIsThatOfABounceOfAnyDrop) {
  const Noise noise{std::log(0.004), 0.5, 2.0, 1.0};
  EXPECT_NEAR(noise.variance(0.0), 5.0 * 16e-6, 1e-15);
  EXPECT_NEAR(noise.variance(std::log(4.0)), 5.0 * 4e-6, 1e-15);  // as v^(-1/2): half the size at four times the speed
}

TEST(CurveNoise, LikelySIsWhereEvidenceAndPriorAreLargestAndAsWide) {
  // normal about ln 0.02 with 0.1; the prior, of 1.2 about ln 0.005, shifts it by a hundredth of the distance
  const auto evidence = [](const Noise& noise) { return -0.5 * std::pow((noise.ln_s - std::log(0.02)) / 0.1, 2); };
  const LikelyNoise likely = with_likely_s({std::log(0.3), 0.0, 0.0, 1.0, 0.0}, 1.0, 50, evidence);
  const double precision = 1.0 / 0.01 + 1.0 / 1.44;
  EXPECT_NEAR(likely.noise.ln_s, (std::log(0.02) / 0.01 + std::log(0.005) / 1.44) / precision, 1e-6);
  EXPECT_NEAR(likely.ln_s_sd, 1.0 / std::sqrt(precision), 1e-6);
}

}  // namespace
}  // namespace bouncelab::fit
