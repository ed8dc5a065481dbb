// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_likelihood.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "law/law_model.hpp"

namespace bouncelab::fit {
namespace {

LawData few_samples() {
  Random random(7, RandomStream::test, 0);
  LawData data;
  for (int k = 0; k < 60; ++k) {
    const double v = 0.1 * std::pow(10.0, k / 59.0);
    data.v_mps.push_back(v);
    data.eps.push_back(0.95 - 0.01 * v + 0.002 * random.normal());
    data.tau.push_back(0.0005 / v);
    data.drop.push_back(0);
  }
  data.eps[20] -= 0.05;  // a lost bounce
  return data;
}

TEST(LawLikelihood, GradientIsThatOfItsValueForEveryFamily) {
  const LawData data = few_samples();
  const LawModel model = make_law_model(LawKind::series, {2, 4}, data.v_mps);
  for (const bool has_normal_part : {true, false})
    for (const std::size_t n_terms : {1, 3}) {
      const LawLikelihood likelihood(data, model, {has_normal_part, n_terms, 0.3, 0.01, std::log(0.001)});
      Eigen::VectorXd theta = Eigen::VectorXd::Zero(likelihood.n_parameters());
      theta.head(2) << 0.949, 0.946;
      theta[2] = std::log(0.0015);
      theta[2 + static_cast<Eigen::Index>(n_terms)] = std::log(0.001);
      if (n_terms == 3) theta[3] = -0.3, theta[4] = 0.1;
      if (has_normal_part) theta[theta.size() - 1] = 0.2;
      Eigen::VectorXd gradient;
      likelihood(theta, &gradient);
      for (Eigen::Index i = 0; i < theta.size(); ++i) {
        const double h = i < 2 ? 1e-8 : 1e-5;
        Eigen::VectorXd ahead = theta, behind = theta;
        ahead[i] += h;
        behind[i] -= h;
        const double slope = (likelihood(ahead, nullptr) - likelihood(behind, nullptr)) / (2.0 * h);
        // rounding of the sum, 1e-13, over h; the cubic between the knots of the peak's offset is good to 1e-7
        EXPECT_NEAR(gradient[i], slope, i < 2 ? 2e-4 * (1.0 + std::abs(slope)) : 1e-5 * (1.0 + std::abs(slope)))
            << has_normal_part << " " << n_terms << " " << i;
      }
    }
}

TEST(LawLikelihood, OnlyTheLostBounceIsProbablyLost) {
  const LawData data = few_samples();
  const LawModel model = make_law_model(LawKind::series, {2, 4}, data.v_mps);
  const LawLikelihood likelihood(data, model, {false, 1, 0.3, 0.01});
  Eigen::VectorXd theta(4);
  theta << 0.949, 0.946, std::log(0.0015), std::log(0.0015);
  const std::vector<double> p = likelihood.probabilities_of_lost(theta);
  for (std::size_t k = 0; k < data.size(); ++k) {
    EXPECT_GE(p[k], 0.0) << k;
    EXPECT_LE(p[k], 1.0) << k;
    EXPECT_EQ(p[k] > 0.5, k == 20) << k;
  }
}

TEST(LawLikelihood, InformationIsTheMeanSquareOfTheScores) {
  // over many draws from the density itself
  Random random(3, RandomStream::test, 1);
  LawData data;
  constexpr int kDraws = 40000;
  const double below = 0.0015, above = 0.001, rho = 0.2, tau = 0.0004,
               normal = std::sqrt(below * above) * std::exp(rho);
  for (int k = 0; k < kDraws; ++k) {
    data.v_mps.push_back(0.5);
    const double side =
        random.uniform() < above / (above + below) ? above * random.exponential() : -below * random.exponential();
    data.eps.push_back(0.95 + side + normal * random.normal() + tau * random.normal() -
                       std::sqrt(below * above) * mode_offset(std::log(above / below), rho).value);
    data.tau.push_back(tau);
    data.drop.push_back(static_cast<std::size_t>(k));
  }
  const LawModel model = make_law_model(LawKind::constant, {}, data.v_mps);
  const LawLikelihood likelihood(data, model, {true, 1, 0.5});
  Eigen::VectorXd theta(4);
  theta << 0.95, std::log(below), std::log(above), rho;
  const Eigen::MatrixXd scores = likelihood.scores_by_drop(theta);
  const Eigen::Matrix4d expected = likelihood.information_of(theta, 0);
  const Eigen::Matrix4d found = scores * scores.transpose() / kDraws;
  const Eigen::Vector4d mean = scores.rowwise().mean();
  for (Eigen::Index i = 0; i < 4; ++i) {
    EXPECT_NEAR(mean[i] / std::sqrt(expected(i, i)), 0.0, 4.0 / std::sqrt(kDraws)) << i;
    for (Eigen::Index j = 0; j <= i; ++j)
      EXPECT_NEAR(found(i, j) / std::sqrt(expected(i, i) * expected(j, j)),
                  expected(i, j) / std::sqrt(expected(i, i) * expected(j, j)), 0.05)
          << i << j;
  }
}

}  // namespace
}  // namespace bouncelab::fit
