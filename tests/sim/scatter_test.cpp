// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit.h>
#include <gsl/gsl_odeiv2.h>

#include "bouncelab/core/fluctuation.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/restitution_with_memory.hpp"
#include "bouncelab/sim/sim.hpp"
#include "drop_statistics.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"

namespace bouncelab::sim {
namespace {

// What the paper says of the scatter, at the paper's size.

using testing::Laplace;
using testing::laplace;
using testing::sd;

struct Sample {
  std::int64_t drop;
  double v_mps, deviation;  ///< eps~ - eps(v)
};

std::vector<Sample> samples_of(const RadiusLaw& law, std::int64_t n_drops, std::int64_t n_asperities = 1'000'000) {
  SimulationConfig config;
  config.n_drops = n_drops;
  const SimulationResult result = simulate(config, make_surface(config.ball, n_asperities, law, 1));
  std::vector<Sample> samples;
  for (const Impact& impact : result.impacts.rows)
    samples.push_back({impact.drop, impact.v_mps, impact.eps_macro - restitution(config.law, impact.v_mps)});
  return samples;
}

constexpr std::int64_t kGroups = 20;

/// Deviations in ascending order, of all drops or of every twentieth.
std::vector<double> in_window(const std::vector<Sample>& samples, double v_mps, std::int64_t group = -1) {
  std::vector<double> x;
  for (const Sample& s : samples)
    if (std::abs(s.v_mps - v_mps) < 0.05 && (group < 0 || s.drop % kGroups == group)) x.push_back(s.deviation);
  std::sort(x.begin(), x.end());
  return x;
}

/// Standard error of the mode from twenty groups of drops: the impacts of one drop share its spin.
double mode_standard_error(const std::vector<Sample>& samples, double v_mps) {
  std::vector<double> modes;
  for (std::int64_t group = 0; group < kGroups; ++group)
    modes.push_back(laplace(in_window(samples, v_mps, group)).mode);
  return sd(modes) / std::sqrt(static_cast<double>(kGroups - 1));
}

class PaperSize : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { samples_ = new std::vector<Sample>(samples_of(UniformRadii{}, 2320)); }
  static void TearDownTestSuite() { delete samples_; }
  static const std::vector<Sample>* samples_;
};
const std::vector<Sample>* PaperSize::samples_ = nullptr;

TEST_F(PaperSize, ScatterHasTheWidthComputedIndependently) {
  // docs/physics.md, uniform radii, one or two digits given: half a unit of the last
  EXPECT_NEAR(sd(in_window(*samples_, 0.3)), 0.0023, 0.00025);
  EXPECT_NEAR(sd(in_window(*samples_, 0.7)), 0.0008, 0.0001);
  EXPECT_NEAR(sd(in_window(*samples_, 1.0)), 0.0005, 0.0001);
}

TEST_F(PaperSize, ScatterGrowsAsTheSpeedFalls) {
  // at a given spin as 1/v; the spin grows from bounce to bounce besides, so a little faster than 1/v between windows
  const double exponent = std::log(sd(in_window(*samples_, 0.3)) / sd(in_window(*samples_, 0.9))) / std::log(3.0);
  EXPECT_GT(exponent, 1.0);
  EXPECT_LT(exponent, 2.0);
}

TEST_F(PaperSize, PeaksFollowTheLawAndTheLowSideIsLonger) {
  for (int k = 2; k <= 12; ++k) {
    const double v = 0.1 * k;
    const Laplace fit = laplace(in_window(*samples_, v));
    const double se = mode_standard_error(*samples_, v);
    EXPECT_LT(std::abs(fit.mode), 3 * se) << "v = " << v << ", mode off by " << fit.mode;
    if (k >= 3) {
      EXPECT_GT(fit.below, fit.above) << "v = " << v;
    }
  }
}

TEST(Scatter, OfExponentialRadiiIsTensOfTimesWider) {
  // docs/physics.md: .063, .025, .014, from one surface and a run of unstated length; 200,000 impacts of ours give
  // .0683, .0258, .0145. The few highest asperities differ from surface to surface: a tenth is allowed; so many drops
  // keep the noise of this estimate at a percent
  const std::vector<Sample> samples = samples_of(ExponentialRadii{}, 2320);
  EXPECT_NEAR(sd(in_window(samples, 0.3)), 0.063, 0.0063);
  EXPECT_NEAR(sd(in_window(samples, 0.7)), 0.025, 0.0025);
  EXPECT_NEAR(sd(in_window(samples, 1.0)), 0.014, 0.0014);
}

// The sampler for DEM codes against the simulator: what no p(eps|v) can reproduce.

constexpr std::int64_t kAsperities = 71'378;                               // constant radii: s2 = 2/N = 2.8e-5
constexpr double kQ = 5.0 / 7.0 * 2.0 / static_cast<double>(kAsperities);  // c = 5/7: a solid ball without slip
constexpr std::int64_t kBounces = 94;
constexpr double kWindow_mps = 0.6, kHalfWidth_mps = 0.05;

struct Bounce {
  std::int64_t drop;
  double v_mps, deviation;  ///< eps~ - eps(v)
};

struct Drops {
  std::vector<Bounce> bounces;
  std::vector<double> v_end_mps;  ///< of each drop, after 94 bounces

  /// Rising slope of the two exponentials at 0.6 m/s.
  testing::Estimate rising_slope() const {
    return testing::by_drop(20, [&](const std::function<bool(std::int64_t)>& counts) {
      std::vector<double> x;
      for (const Bounce& b : bounces)
        if (std::abs(b.v_mps - kWindow_mps) < kHalfWidth_mps && counts(b.drop)) x.push_back(b.deviation);
      std::sort(x.begin(), x.end());
      return 1.0 / testing::laplace(x).below;
    });
  }
};

Drops simulated(double height_m, double lowest_m, std::int64_t n_drops) {
  SimulationConfig config;
  config.drop_height_min_m = lowest_m;
  config.drop_height_max_m = height_m;
  config.n_drops = n_drops;
  config.n_impacts_max = kBounces + 1;
  config.n_threads = 1;
  const Surface surface = make_surface(config.ball, kAsperities, ConstantRadii{}, 1);
  Drops drops;
  for (const Impact& i : simulate(config, surface).impacts.rows) {
    drops.bounces.push_back({i.drop, i.v_mps, i.eps_macro - restitution(config.law, i.v_mps)});
    if (i.impact == kBounces) drops.v_end_mps.push_back(i.v_mps);
  }
  return drops;
}

Drops sampled(double height_m, double lowest_m, std::int64_t n_drops) {
  const SeriesLaw law;
  const auto eps = [&](double v_mps) { return restitution(law, v_mps); };
  Drops drops;
  for (std::int64_t drop = 0; drop < n_drops; ++drop) {
    Random random(7, RandomStream::test, static_cast<std::uint64_t>(drop));
    double v = std::sqrt(2.0 * kDefaultGravity_mps2 * random.uniform(lowest_m, height_m)), w = 0.0;
    for (std::int64_t k = 0; k < kBounces; ++k) {
      const double z1 = random.normal(), z2 = random.normal();
      const double e = restitution_with_memory(v, eps, kQ, z1, z2, w);
      drops.bounces.push_back({drop, v, e - eps(v)});
      v *= e;
    }
    drops.v_end_mps.push_back(v);
  }
  return drops;
}

/// Standard error of a standard deviation, with the fourth moment that the values have.
double se_of_sd(const std::vector<double>& x) {
  const double m = testing::mean(x), s = testing::sd(x);
  double fourth = 0.0;
  for (const double value : x) fourth += std::pow((value - m) / s, 4) / static_cast<double>(x.size());
  return 0.5 * s * std::sqrt((fourth - 1.0) / static_cast<double>(x.size()));
}

void expect_same(const Drops& a, const Drops& b) {
  const double n = 1.0 / static_cast<double>(a.v_end_mps.size()), m = 1.0 / static_cast<double>(b.v_end_mps.size());
  const double sd_a = testing::sd(a.v_end_mps), sd_b = testing::sd(b.v_end_mps);
  // four standard errors each: one such comparison in 16,000 fails at random
  EXPECT_NEAR(testing::mean(a.v_end_mps), testing::mean(b.v_end_mps),
              4.0 * std::sqrt(sd_a * sd_a * n + sd_b * sd_b * m));
  EXPECT_NEAR(sd_a, sd_b, 4.0 * std::hypot(se_of_sd(a.v_end_mps), se_of_sd(b.v_end_mps)));
  const testing::Estimate slope_a = a.rising_slope(), slope_b = b.rising_slope();
  EXPECT_NEAR(slope_a.value, slope_b.value, 4.0 * std::hypot(slope_a.se, slope_b.se));
}

TEST(RestitutionWithMemory, ReproducesTheSimulatedDropsFromOneHeightAndFromSeveral) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  const auto n = test::repetitions<std::int64_t>(300, 1500);
  expect_same(simulated(0.1, 0.09, n), sampled(0.1, 0.09, 4 * n));
  if (n < 1000) return;
  expect_same(simulated(0.1, 0.1, n), sampled(0.1, 0.1, 4 * n));
  expect_same(simulated(1.0, 1.0, n), sampled(1.0, 1.0, 4 * n));
}

/// Viscoelastic spheres: x'' = -(x^(3/2) + b sqrt(x) x'), scaled so that x'(0) = 1; b = gamma v^(1/5).
int contact(double, const double y[], double dydt[], void* parameter) {
  const double b = *static_cast<const double*>(parameter);
  const double root = std::sqrt(std::max(0.0, y[0]));
  dydt[0] = y[1];
  dydt[1] = -root * (y[0] + b * y[1]);
  return GSL_SUCCESS;
}

/// -x' at the end of contact, which is when the force vanishes, x + b x' = 0, not when x does: no attraction.
double restitution_by_integration(double b) {
  gsl_odeiv2_system system{contact, nullptr, 2, &b};
  gsl_odeiv2_step* step = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, 2);
  gsl_odeiv2_control* control = gsl_odeiv2_control_y_new(1e-16, 1e-15);
  gsl_odeiv2_evolve* evolve = gsl_odeiv2_evolve_alloc(2);
  // over the first instant sqrt(x) is not smooth: x = t - 4 b t^(5/2) / 15, x' = 1 - 2 b t^(3/2) / 3 to O(t^(7/2))
  const double t0 = 1e-6;
  double t = t0, h = 1e-6;
  double y[2] = {t0 - 4.0 / 15.0 * b * std::pow(t0, 2.5), 1.0 - 2.0 / 3.0 * b * std::pow(t0, 1.5)};
  double y_before[2] = {y[0], y[1]}, t_before = t;
  while (y[0] + b * y[1] > 0.0) {
    y_before[0] = y[0];
    y_before[1] = y[1];
    t_before = t;
    gsl_odeiv2_evolve_apply(evolve, control, step, &system, &t, 10.0, &h, y);
  }
  // halve the last step until the force's zero is found
  double lo = 0.0, hi = t - t_before;
  double end[2] = {y[0], y[1]}, error[2];
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (lo + hi);
    end[0] = y_before[0];
    end[1] = y_before[1];
    gsl_odeiv2_step_apply(step, t_before, middle, end, error, nullptr, nullptr, &system);
    (end[0] + b * end[1] > 0.0 ? lo : hi) = middle;
  }
  gsl_odeiv2_evolve_free(evolve);
  gsl_odeiv2_control_free(control);
  gsl_odeiv2_step_free(step);
  return -end[1];
}

/// Least squares for C_first ... C_last in eps - known terms = sum C_i x^i, at Chebyshev points.
std::vector<double> fitted(int first, int last, double x_lo, double x_hi, const std::vector<double>& known) {
  constexpr int kPoints = 60;
  const auto n = static_cast<std::size_t>(last - first + 1);
  gsl_matrix* a = gsl_matrix_alloc(kPoints, n);
  gsl_vector* right = gsl_vector_alloc(kPoints);
  gsl_vector* c = gsl_vector_alloc(n);
  gsl_matrix* covariance = gsl_matrix_alloc(n, n);
  for (std::size_t p = 0; p < kPoints; ++p) {
    const double x = 0.5 * (x_lo + x_hi) +
                     0.5 * (x_hi - x_lo) * std::cos(3.14159265358979 * (static_cast<double>(p) + 0.5) / kPoints);
    double rest = restitution_by_integration(x * x) - 1.0;
    for (std::size_t i = 0; i < known.size(); ++i) rest -= known[i] * std::pow(x, static_cast<double>(i));
    gsl_vector_set(right, p, rest / std::pow(x, first));  // errors of eps are alike: weights x^first keep columns alike
    for (std::size_t k = 0; k < n; ++k) gsl_matrix_set(a, p, k, std::pow(x, static_cast<double>(k)));
  }
  gsl_multifit_linear_workspace* work = gsl_multifit_linear_alloc(kPoints, n);
  double chi2 = 0.0;
  gsl_multifit_linear(a, right, c, covariance, &chi2, work);
  std::vector<double> result;
  for (std::size_t k = 0; k < n; ++k) result.push_back(gsl_vector_get(c, k));
  gsl_multifit_linear_free(work);
  gsl_matrix_free(covariance);
  gsl_vector_free(c);
  gsl_vector_free(right);
  gsl_matrix_free(a);
  return result;
}

TEST(ViscoelasticContact, CoefficientsOfTheSeriesFollowFromTheContactEquationToTheDigitsThatTheDerivationSupports) {
  // the two after C_2 have closed forms: the derivation's own test. Then five digits of C_6, three of C_7, two of C_8,
  // one of C_9, the sign of C_10: what changes with the range and the number of terms, rounded up
  const std::vector<double> closed = fitted(4, 17, 0.12, 0.75, {0.0, 0.0, kViscoelasticC[2], 0.0});
  EXPECT_NEAR(closed[0], kViscoelasticC[4], 1e-6);
  EXPECT_NEAR(closed[1], kViscoelasticC[5], 1e-4);
  const std::vector<double> exact{0.0, 0.0, kViscoelasticC[2], 0.0, kViscoelasticC[4], kViscoelasticC[5]};
  const std::vector<double> c = fitted(6, 17, 0.12, 0.75, exact);
  const double supported[] = {2e-6, 1e-4, 1e-3, 1e-2, 6e-2};
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(c[k], kViscoelasticC[k + 6], supported[k]) << "C_" << k + 6;
}

}  // namespace

}  // namespace bouncelab::sim
