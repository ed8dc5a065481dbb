// SPDX-License-Identifier: GPL-3.0-or-later
// eps(v) as one smooth curve: what it says of drops that differ, of one drop, and of laws beside it.
#include "curve/smooth_curve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/fit.hpp"
#include "support/statistics.hpp"

namespace bouncelab::fit {
namespace {

/// Drops from 2 m/s or so without air, by eps(drop, v) and a normal scatter.
RestitutionSamples drops_by(const std::function<double(int, double)>& eps, int n_drops, int n_bounces, double scatter,
                            std::uint64_t seed) {
  RestitutionSamples samples;
  Random random(seed, RandomStream::test, 61);
  for (int drop = 0; drop < n_drops; ++drop) {
    double v = 1.8 + 0.4 * random.uniform();
    for (int k = 0; k < n_bounces; ++k) {
      RestitutionSample s;
      s.drop = drop;
      s.impact = k;
      s.v_mps = v;
      s.eps = eps(drop, v) + scatter * random.normal();
      v *= s.eps;
      samples.push_back(s);
    }
  }
  return samples;
}

SmoothCurve smooth(const RestitutionSamples& samples) {
  AirAndContact none;
  none.has_drag = none.has_contact = false;
  return {samples, {none}, {}};
}

FitResult fitted_by(const RestitutionSamples& samples, LawKind kind) {
  FitConfig config;
  config.law.kind = kind;
  config.n_goodness = 0;
  return fit_all(samples, config);
}

TEST(SmoothCurve, OfTwoDropsThatDifferHasAnIntervalOverBoth) {
  const RestitutionSamples samples = drops_by([](int drop, double) { return drop == 0 ? 0.85 : 0.80; }, 2, 10, 1e-5, 1);
  const Curve curve = smooth(samples).curve();
  EXPECT_EQ(curve.n_drops, 2u);
  const Estimate& eps = curve.nodes.at(1).eps;
  // two means .05 apart tell of a third ball or drop at best to .035, and that by two of them
  EXPECT_LT(eps.ci95->lo, 0.825 - 0.02);
  EXPECT_GT(eps.ci95->hi, 0.825 + 0.02);
  EXPECT_NEAR(eps.value, 0.825, 0.02);
  ASSERT_TRUE(curve.scatter_of_drops);
  EXPECT_GT(*curve.scatter_of_drops, 100.0 * curve.scatter);
}

TEST(SmoothCurve, OfDropsThatAreEqualToTheLastDigitIsTheirEps) {
  for (const double eps : {0.2, 0.5, 0.9})
    for (const int n_bounces : {4, 6, 12}) {
      const Curve curve = smooth(drops_by([&](int, double) { return eps; }, 8, n_bounces, 0.0, 1)).curve();
      for (const CurveNode& node : curve.nodes) EXPECT_NEAR(node.eps.value, eps, 1e-6) << eps << ", " << n_bounces;
      for (const CurvePoint& point : curve.points) EXPECT_NEAR(point.y, eps, 1e-4) << eps << ", " << n_bounces;
    }
}

TEST(SmoothCurve, OfManyDropsThatDifferHasTheErrorOfTheirMean) {
  Random random(7, RandomStream::test, 0);
  double mean = 0.0, squares = 0.0;
  std::vector<double> of_drop(30);
  for (double& eps : of_drop) eps = 0.8 + 0.01 * random.normal(), mean += eps / 30.0;
  for (const double eps : of_drop) squares += (eps - mean) * (eps - mean) / 29.0;
  const Curve curve =
      smooth(drops_by([&](int drop, double) { return of_drop[static_cast<std::size_t>(drop)]; }, 30, 10, 1e-3, 2))
          .curve();
  // drops count, not bounces: how 30 of them differ is known to an eighth, and a third covers grids of it
  EXPECT_NEAR(*curve.nodes.at(1).eps.se / std::sqrt(squares / 30.0), 1.0, 0.33);
  EXPECT_NEAR(*curve.scatter_of_drops / std::sqrt(squares), 1.0, 0.33);
  EXPECT_NEAR(curve.scatter / 1e-3, 1.0, 0.2);  // of 270 degrees of freedom: four standard errors
}

TEST(SmoothCurve, OfOneDropIsOfThatDrop) {
  const Curve curve = smooth(drops_by([](int, double) { return 0.8; }, 1, 12, 0.004, 3)).curve();
  EXPECT_EQ(curve.n_drops, 1u);
  EXPECT_FALSE(curve.scatter_of_drops);
}

TEST(SmoothCurve, StatesTheRootMeanSquareAndTheMean) {
  const Curve curve = smooth(drops_by([](int, double) { return 0.6; }, 20, 10, 0.1, 4)).curve();
  const Estimate &rms = curve.nodes.at(1).eps, &mean = curve.nodes.at(1).mean;
  // 200 that scatter by .1; the curve may bend
  EXPECT_NEAR(rms.value, std::hypot(0.6, 0.1), 4.0 * *rms.se);
  EXPECT_NEAR(mean.value, 0.6, 4.0 * *mean.se);
  EXPECT_NEAR(std::sqrt(curve.covariance.at(1).at(1)) / *mean.se, 1.0, 0.1);  // half of the interval that holds 68 %
  EXPECT_NEAR(rms.value - mean.value, std::hypot(0.6, 0.1) - 0.6, 2e-3);      // the variance to a tenth, twice
}

TEST(SmoothCurve, BetweenPointsAndNodesIsOneCurve) {
  const Curve curve = smooth(drops_by([](int, double v) { return 0.8 - 0.03 * std::log(v); }, 5, 12, 0.003, 5)).curve();
  ASSERT_EQ(curve.points.size(), 13u);
  ASSERT_EQ(curve.end_changes.size(), 2u);
  const double middle = curve.nodes.at(1).eps.value;
  EXPECT_NEAR(curve.end_changes[0].value, curve.points.front().y - middle, 1e-4);  // medians of sums
  EXPECT_NEAR(curve.end_changes[1].value, curve.points.back().y - middle, 1e-4);
  for (const CurveNode& node : curve.nodes) {
    const auto after =
        std::find_if(curve.points.begin(), curve.points.end(), [&](const CurvePoint& p) { return p.x >= node.v_mps; });
    ASSERT_TRUE(after != curve.points.begin() && after != curve.points.end());
    EXPECT_LE(node.eps.value, std::max(after->y, (after - 1)->y) + 1e-4);
    EXPECT_GE(node.eps.value, std::min(after->y, (after - 1)->y) - 1e-4);
  }
}

double viscoelastic_eps(double v) { return restitution(ViscoelasticLaw{0.15}, v); }

/// Flat, then falling as what yields does.
double kinked(double v) { return 0.85 * std::pow(std::max(1.0, v / 0.8), -0.25); }

TEST(LawBesideTheCurve, ThatIsRightHasNoMisfit) {
  for (int run = 0; run < test::repetitions(2, 40); ++run) {
    const RestitutionSamples samples = drops_by([](int, double v) { return viscoelastic_eps(v); }, 10, 12, 0.004,
                                                10 + static_cast<std::uint64_t>(run));
    const FitResult result = fitted_by(samples, LawKind::viscoelastic);
    ASSERT_TRUE(result.law.misfit) << run;
    EXPECT_LT(result.law.misfit->ln_bayes_factor, kStrongBayesFactor) << run;
    EXPECT_EQ(result.constants.status, FitStatus::ok) << run;
    EXPECT_EQ(result.constants.parameters.size(), 1u);
  }
}

TEST(LawBesideTheCurve, ThatIsWrongHasAMisfitAndNoConstants) {
  for (int run = 0; run < test::repetitions(2, 40); ++run) {
    const RestitutionSamples samples =
        drops_by([](int, double v) { return kinked(v); }, 10, 12, 0.004, 60 + static_cast<std::uint64_t>(run));
    const FitResult result = fitted_by(samples, LawKind::constant);
    ASSERT_TRUE(result.law.misfit) << run;
    EXPECT_GT(result.law.misfit->ln_bayes_factor, kStrongBayesFactor) << run;
    EXPECT_EQ(result.constants.status, FitStatus::not_applicable);
    EXPECT_TRUE(result.constants.parameters.empty() && result.constants.covariance.empty());
    ASSERT_TRUE(result.constants.why);
    EXPECT_EQ(result.constants.why->kind, NoteKind::law_contradicted);
    // the curve is there all the same
    ASSERT_TRUE(result.curve);
    for (const CurveNode& node : result.curve->nodes)
      EXPECT_NEAR(node.eps.value, std::hypot(kinked(node.v_mps), 0.004), 4.0 * *node.eps.se) << run;
    // where it is off, and to which side: constants lie in the middle of what falls
    const LawMisfit& misfit = *result.law.misfit;
    const double constant = result.law.parameters.at(0).estimate.value;
    EXPECT_GT(misfit.off * (kinked(misfit.v_mps) - constant), 0.0) << run << " at " << misfit.v_mps;
  }
}

}  // namespace
}  // namespace bouncelab::fit
