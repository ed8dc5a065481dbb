// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_likelihood.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "law/law_data.hpp"

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
  for (const ScatterKind kind : {ScatterKind::normal_laplace, ScatterKind::asymmetric_laplace,
                                 ScatterKind::symmetric_laplace, ScatterKind::normal})
    for (const std::size_t n_terms : {1, 3}) {
      const LawLikelihood likelihood(data, model,
                                     {kind, n_terms, 0.3, kind == ScatterKind::normal ? 0.0 : 0.01, std::log(0.001)});
      Eigen::VectorXd theta = Eigen::VectorXd::Zero(likelihood.n_parameters());
      theta.head(2) << 0.949, 0.946;
      theta[2] = std::log(0.0015);
      if (likelihood.scatter().is_two_sided()) theta[2 + static_cast<Eigen::Index>(n_terms)] = std::log(0.001);
      if (n_terms == 3) theta[3] = -0.3, theta[4] = 0.1;
      if (kind == ScatterKind::normal_laplace) theta[theta.size() - 1] = 0.2;
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
            << static_cast<int>(kind) << " " << n_terms << " " << i;
      }
    }
}

/// Families without priors: what their drops have adds up to the whole.
struct WithoutPriors {
  ScatterKind kind;
  LawKind law;
  std::size_t n_terms;
};
constexpr std::array<WithoutPriors, 4> kWithoutPriors{{{ScatterKind::normal, LawKind::series, 1},
                                                       {ScatterKind::normal, LawKind::viscoelastic, 3},
                                                       {ScatterKind::symmetric_laplace, LawKind::series, 3},
                                                       {ScatterKind::symmetric_laplace, LawKind::viscoelastic, 2}}};

Eigen::VectorXd theta_of(const WithoutPriors& family, const LawModel& model) {
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(model.n_parameters() + static_cast<Eigen::Index>(family.n_terms));
  if (family.law == LawKind::series)
    theta.head(2) << 0.949, 0.946;
  else
    theta[0] = std::log(0.006);
  theta[model.n_parameters()] = std::log(0.0015);
  if (family.n_terms > 1) theta[model.n_parameters() + 1] = -0.3;
  return theta;
}

TEST(LawLikelihood, ScoresAndInformationOfTheDropsAddUp) {
  LawData data = few_samples();
  for (std::size_t k = 0; k < data.size(); ++k) data.drop[k] = k % 7;
  for (const WithoutPriors& family : kWithoutPriors) {
    const LawModel model = make_law_model(family.law, {2, 4}, data.v_mps);
    const LawLikelihood likelihood(data, model, {family.kind, family.n_terms, 0.3});
    const Eigen::VectorXd theta = theta_of(family, model);
    Eigen::VectorXd gradient;
    likelihood(theta, &gradient);
    const Eigen::MatrixXd by_drop = likelihood.scores_by_drop(theta), by_sample = likelihood.scores_by_sample(theta);
    ASSERT_EQ(by_drop.cols(), 7);
    ASSERT_EQ(by_sample.cols(), 60);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(theta.size(), theta.size());
    for (const Eigen::MatrixXd& of_drop : likelihood.information_by_drop(theta)) sum += of_drop;
    const Eigen::MatrixXd all = likelihood.information(theta);
    for (Eigen::Index i = 0; i < theta.size(); ++i) {
      // sums of 60 terms in another order
      const double rounding = 1e-13 * by_sample.row(i).cwiseAbs().sum();
      EXPECT_NEAR(by_drop.row(i).sum(), gradient[i], rounding) << i;
      EXPECT_NEAR(by_sample.row(i).sum(), gradient[i], rounding) << i;
      for (Eigen::Index j = 0; j < theta.size(); ++j)
        EXPECT_NEAR(sum(i, j), all(i, j), 1e-12 * std::sqrt(all(i, i) * all(j, j))) << i << j;
    }
  }
}

TEST(LawLikelihood, InformationOfADropIsTakenFromSomeOfVeryManySamples) {
  constexpr std::size_t kDrops = 300, kImpacts = 100;
  LawData data;
  for (std::size_t k = 0; k < kDrops * kImpacts; ++k) {
    const double v = 0.1 * std::pow(10.0, static_cast<double>(k) / (kDrops * kImpacts - 1));
    data.v_mps.push_back(v);
    data.eps.push_back(0.95 - 0.01 * v);
    data.tau.push_back(0.0005 / v);
    data.drop.push_back(k * 7919 % kDrops);  // each has one of every 300 in a row
  }
  const WithoutPriors family = kWithoutPriors[2];
  const LawModel model = make_law_model(family.law, {2, 4}, data.v_mps);
  const ScatterFamily scatter{family.kind, family.n_terms, 0.3};
  const Eigen::VectorXd theta = theta_of(family, model);
  const std::vector<Eigen::MatrixXd> by_drop = LawLikelihood(data, model, scatter).information_by_drop(theta);
  ASSERT_EQ(by_drop.size(), kDrops);
  for (const std::size_t drop : {std::size_t{0}, std::size_t{1}, kDrops - 1}) {
    LawData of_drop;
    for (std::size_t k = 0; k < data.size(); ++k) {
      if (data.drop[k] != drop) continue;
      of_drop.v_mps.push_back(data.v_mps[k]);
      of_drop.eps.push_back(data.eps[k]);
      of_drop.tau.push_back(data.tau[k]);
      of_drop.drop.push_back(0);
    }
    const Eigen::MatrixXd whole = LawLikelihood(of_drop, model, scatter).information(theta);
    // every third of a hundred, each for itself and its neighbours: the last is nobody's, and in the sum of
    // log(v / v_ref)^4, where the fastest count most and timing hides the slow, it is a twelfth
    for (Eigen::Index i = 0; i < theta.size(); ++i)
      for (Eigen::Index j = 0; j < theta.size(); ++j)
        EXPECT_NEAR(by_drop[drop](i, j), whole(i, j), 0.1 * std::sqrt(whole(i, i) * whole(j, j)))
            << drop << " " << i << j;
  }
}

/// By differences of the gradient over a small part of a standard error.
Eigen::MatrixXd curvature_by_gradients(const LawLikelihood& likelihood, const Eigen::VectorXd& theta) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd h(theta.size(), theta.size());
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    Eigen::VectorXd ahead = theta, behind = theta, of_ahead, of_behind;
    ahead[i] += kStep;
    behind[i] -= kStep;
    likelihood(ahead, &of_ahead);
    likelihood(behind, &of_behind);
    h.col(i) = (of_behind - of_ahead) / (2.0 * kStep);
  }
  return h;
}

TEST(LawLikelihood, ObservedInformationIsTheCurvatureOfTheLogLikelihood) {
  constexpr std::size_t kTimes = 200;  // so often the few samples: the differences are over 1 % of the scatter's width
  const LawData few = few_samples();
  LawData data;
  for (std::size_t k = 0; k < few.size() * kTimes; ++k) {
    const std::size_t i = k / kTimes;
    data.v_mps.push_back(few.v_mps[i]);
    data.eps.push_back(few.eps[i]);
    data.tau.push_back(0.0015);  // as wide as the scatter: without kinks
    data.drop.push_back(k % 7);
  }
  for (const ScatterKind kind : {ScatterKind::normal_laplace, ScatterKind::asymmetric_laplace,
                                 ScatterKind::symmetric_laplace, ScatterKind::normal}) {
    for (const LawKind law : {LawKind::series, LawKind::viscoelastic}) {
      const LawModel model = make_law_model(law, {2, 4}, data.v_mps);
      const ScatterFamily family{kind, 2, 0.3, 0.01};
      const LawLikelihood likelihood(data, model, family);
      Eigen::VectorXd theta = Eigen::VectorXd::Zero(likelihood.n_parameters());
      const Eigen::Index n_law = model.n_parameters();
      if (law == LawKind::series)
        theta.head(2) << 0.949, 0.946;
      else
        theta[0] = std::log(0.006);
      for (Eigen::Index i = n_law; i + 1 < theta.size(); i += 2) {
        theta[i] = std::log(i == n_law ? 0.0015 : 0.002);
        theta[i + 1] = -0.3;
      }
      if (kind == ScatterKind::normal_laplace) theta[theta.size() - 1] = 0.2;
      const Eigen::MatrixXd found = likelihood.observed_information(theta);
      const Eigen::MatrixXd expected = curvature_by_gradients(likelihood, theta);
      const Eigen::VectorXd size = likelihood.information(theta).diagonal().cwiseSqrt();
      // third and fourth derivatives over the 1 %, squared, and kinks of the peak's interpolation between knots
      for (Eigen::Index i = 0; i < theta.size(); ++i)
        for (Eigen::Index j = 0; j < theta.size(); ++j)
          EXPECT_NEAR(found(i, j) / (size[i] * size[j]), expected(i, j) / (size[i] * size[j]),
                      1e-3 * (1.0 + std::abs(expected(i, j)) / (size[i] * size[j])))
              << to_string(law) << static_cast<int>(kind) << i << j;
    }
  }
}

TEST(LawLikelihood, OnlyTheLostBounceIsProbablyLost) {
  const LawData data = few_samples();
  const LawModel model = make_law_model(LawKind::series, {2, 4}, data.v_mps);
  const LawLikelihood likelihood(data, model, {ScatterKind::asymmetric_laplace, 1, 0.3, 0.01});
  Eigen::VectorXd theta(4);
  theta << 0.949, 0.946, std::log(0.0015), std::log(0.0015);
  const std::vector<double> p = likelihood.probabilities_of_lost(theta);
  for (std::size_t k = 0; k < data.size(); ++k) {
    EXPECT_GE(p[k], 0.0) << k;
    EXPECT_LE(p[k], 1.0) << k;
    EXPECT_EQ(p[k] > 0.5, k == 20) << k;
  }
}

TEST(LawLikelihood, ScoreOfTheLocationOfSomeSamplesIsTheSumOfTheirs) {
  const LawData data = few_samples();
  const LawModel model = make_law_model(LawKind::constant, {}, data.v_mps);
  std::vector<std::size_t> some;
  for (std::size_t k = 0; k < data.size(); k += 3) some.push_back(k);
  for (const ScatterKind kind : {ScatterKind::normal_laplace, ScatterKind::asymmetric_laplace, ScatterKind::normal}) {
    const LawLikelihood likelihood(data, model, {kind, 1, 0.3, kind == ScatterKind::normal ? 0.0 : 0.01});
    Eigen::VectorXd theta = Eigen::VectorXd::Constant(likelihood.n_parameters(), std::log(0.0015));
    theta[0] = 0.946;
    if (kind == ScatterKind::normal_laplace) theta[theta.size() - 1] = 0.2;
    const double offset = 0.001;
    const auto found = likelihood.location_score(likelihood.gathered(theta, some), offset);
    theta[0] += offset;
    const std::vector<double> by_location = likelihood.derivatives(theta).by_location;
    double sum = 0.0, squares = 0.0;
    for (const std::size_t k : some) sum += by_location[k], squares += by_location[k] * by_location[k];
    // sums of 20 terms in another order, residuals rounded
    EXPECT_NEAR(found.sum, sum, 1e-10 * std::sqrt(squares));
    EXPECT_NEAR(found.squares, squares, 1e-10 * squares);
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
  const LawLikelihood likelihood(data, model, {ScatterKind::normal_laplace, 1, 0.5});
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

const std::vector<double> kSpeeds{0.01, 0.25, 0.6, 1.0, 1.2, 3.7, 20.0};

TEST(Columns, AreWhatOneSampleAfterTheOtherGives) {
  // exponentials of logarithms below 10: some ten units in the last place
  constexpr double kRounding = 3e-15;
  const std::vector<double> powers = powers_of(kSpeeds, 0.4);
  ScatterModel scatter;
  scatter.v_ref_mps = 0.5;
  scatter.log_below = {-7.0, -1.2, 0.1};
  scatter.log_above = {-7.1, -1.0};
  const ScaleColumns b = scales_at(scatter, kSpeeds);
  for (std::size_t k = 0; k < kSpeeds.size(); ++k) {
    EXPECT_NEAR(powers[k] / std::pow(kSpeeds[k], 0.4), 1.0, kRounding);
    EXPECT_NEAR(b.below[k] / scatter.below(kSpeeds[k]), 1.0, kRounding);
    EXPECT_NEAR(b.above[k] / scatter.above(kSpeeds[k]), 1.0, kRounding);
  }
  for (const RestitutionLaw& law :
       {RestitutionLaw(SeriesLaw{}), RestitutionLaw(ViscoelasticLaw{0.02}), RestitutionLaw(ConstantLaw{0.9}),
        RestitutionLaw(TableLaw{{0.1, 1.0}, {0.99, 0.9}})}) {
    const std::vector<double> eps = restitutions(law, kSpeeds);
    for (std::size_t k = 0; k < kSpeeds.size(); ++k) EXPECT_NEAR(eps[k], restitution(law, kSpeeds[k]), kRounding);
  }
}

TEST(Columns, DropsAreNumberedAsTheyAreMet) {
  DropNumbers numbers;
  const auto number_of = [&](const RestitutionSample& sample) { return numbers.of(sample); };
  RestitutionSample a, b, c;
  a.drop = 7;
  b.drop = 3;
  c.drop = 7;
  c.recording = "other";
  EXPECT_EQ(number_of(a), 0u);
  EXPECT_EQ(number_of(a), 0u);
  EXPECT_EQ(number_of(b), 1u);
  EXPECT_EQ(number_of(c), 2u);
  EXPECT_EQ(number_of(a), 0u);
}

}  // namespace
}  // namespace bouncelab::fit
