// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

struct MemoryFitConfig {
  LawKind kind = LawKind::series;
  std::vector<int> orders{2, 4, 5};  ///< of the series: distinct, at most 5 of them
  std::size_t n_draws = 900;         ///< of the posterior, where there are few drops
  std::size_t n_goodness = 99;       ///< replicates of the Anderson-Darling test; 0: none
  std::uint64_t seed = 1;            ///< of draws and replicates
};

/// What the variance q of the contacts' offset says of the surface, q = c s2 (docs/physics.md). Not the number of
/// asperities, nor their radii, nor the rule of contact: every line is a surface that would scatter the same.
struct Roughness {
  Estimate q;  ///< c times the variance, per component, of the contact's tangential offset over R
  double inertia_factor = kSolidBallInertia;  ///< J/(m R^2) of the ball that the following is for
  double s2_no_slip = 0.0;                    ///< q / c, c = 1/(1 + inertia_factor): contacts that stick
  double s2_frictionless = 0.0;               ///< q / c, c = 1/inertia_factor
  double rms_tilt_no_slip_deg = 0.0;          ///< root mean square angle of the contact's normal
  double n_constant_radii = 0.0;              ///< asperities of one radius, no slip
  double lambda_exponential = 0.0;            ///< mean radius over R where radii are exponential, no slip
  double width_uniform_1e6 = 0.0;             ///< width over R where the radii of 1e6 asperities are uniform, no slip
};

/// A test of the model on the data it was fitted to.
struct MemoryTest {
  double z = 0.0;        ///< deviation over its standard error
  double p_value = 1.0;  ///< two-sided
};

/// Do drops differ from each other by more than their impacts say?
struct DropsTest {
  double ratio = 0.0;    ///< of the variance of what drops ask for to that expected of their impacts
  double p_value = 1.0;  ///< of a ratio as large, by samples drawn from the model
};

/// eps(v) from fluctuations that remember: the energy that earlier bounces of a drop took out of the vertical motion
/// sits in a reservoir w (sideways motion and spin), and sets how much the next bounce may scatter (docs/physics.md,
/// 7). Twenty drops so analysed say about as much as thousands of independent impacts; it holds only where the scatter
/// is that of a rough ball, which the tests judge.
struct MemoryFit {
  FitStatus status = FitStatus::too_few_samples;
  std::vector<Note> objections;           ///< why there is no result, or what speaks against it
  std::size_t n = 0;                      ///< impacts used
  std::size_t n_drops = 0;                ///< they are of
  std::size_t n_chains = 0;               ///< pieces of drops without a missing impact
  std::vector<NamedEstimate> parameters;  ///< A2, A4, A5 ... | gamma | eps
  Matrix covariance;                      ///< of `parameters`
  std::vector<NodeEstimate> nodes;
  std::optional<RestitutionLaw> law;
  /// Of the samples: heights of contacts are R s2, and q means surfaces by its inertia. Absent: not known; a solid ball
  /// of the paper's radius is taken.
  std::optional<Ball> ball;
  Roughness roughness;
  Estimate keep;  ///< share of the reservoir that outlasts a bounce, long after the release; 1 without losses
  /// Mean reservoir that the release left, whether it is seen or not: that before the first impacts less what impacts
  /// before those add. Less than 0 where the first fluctuations are smaller than those of a ball at rest.
  std::optional<Estimate> release_m2ps2;
  double loglik = 0.0;
  std::optional<double> loglik_independent;         ///< of the same impacts by two exponentials, where given
  std::optional<AndersonDarling> anderson_darling;  ///< of the probability transforms
  std::array<double, 20> transform_counts{};        ///< impacts by twentieths of the transform
  MemoryTest leak;                                  ///< keep = 1
  /// No reservoir at the release: of the logarithm of that before the first impacts over what impacts alone would make
  /// it. A statement: nothing in the fit depends on it.
  MemoryTest release;
  MemoryTest
      mechanism;        ///< mean offset and width by the same q (from the difference of the slopes and from the widths)
  MemoryTest by_speed;  ///< q the same at every speed; z > 0: fast impacts meet the rougher ball
  std::optional<DropsTest> between_drops;
  /// The model passes: transforms, mechanism, roughness by speed and drops with p above .01, and likelier
  /// than independent samples.
  bool holds = false;
};
Description members_of(const MemoryFit*);
/// Its tests, and its roughness, as objects of their own.
Description members_of_tests();
Description members_of_roughness();

/// @param samples      ordered by recording, drop, time, finite, v > 0
/// @param independent  the fit that takes them as independent: start, nodes, and samples to leave out
/// @throws InvalidArgument where there are more than 5 orders
MemoryFit fit_memory(const RestitutionSamples& samples, const LawFit& independent, const MemoryFitConfig& config);

struct RoughnessConfig {
  std::size_t n_goodness = 99;  ///< replicates of the Anderson-Darling test; 0: none
  std::uint64_t seed = 1;       ///< of draws and replicates
  int n_threads = 0;            ///< 0: all cores; the result does not depend on it
};

Description members_of(const RoughnessConfig*);

struct RoughnessResult {
  MemoryFit memory;                               ///< with the roughness, of the ball that the samples name
  std::map<std::string, std::size_t> n_left_out;  ///< by reason
};
Description members_of(const RoughnessResult*);

/// The roughness of a ball from how its coefficients of restitution scatter: fit_memory with the series A2, A4, A5, and
/// q translated into surfaces. Samples with a flag, not finite or with v <= 0 are left out and counted.
/// @throws InvalidArgument for more than 1e5 replicates
RoughnessResult measure_roughness(const RestitutionSamples& samples, const RoughnessConfig& config);

/// Surfaces of that q where J = inertia_factor m R^2: q = c s2 with c = 1/(1 + inertia_factor) without slip and c =
/// 1/inertia_factor without friction (docs/physics.md, 7); asperities as sim::contact_offset has them.
/// @param inertia_factor  in (0, 1]
/// @throws InvalidArgument where it is not
Roughness equivalent_surfaces(const Estimate& q, double inertia_factor);

/// Share of the reservoir that a bounce loses: 1 - keep.
Estimate leak_of(const MemoryFit& memory);

/// Successive impacts of one drop, none missing.
struct ImpactChain {
  std::vector<double> v_mps;        ///< normal speed before each impact, > 0
  std::vector<double> v_after_mps;  ///< after it, > -v
  /// Standard errors of the times that these speeds are of: of the impact before the first, of each, of the one after
  /// the last. Empty: the speeds are exact.
  std::vector<double> sigma_t_s;
};

/// A law of restitution as fitted.
struct LawWithErrors {
  RestitutionLaw law;
  std::vector<NamedEstimate> parameters;  ///< A2, A4, A5 ... | gamma | eps
  Matrix covariance;                      ///< of `parameters`; empty: not known
};

/// What the reservoir w (docs/physics.md, section 7) has gained over a chain, from vertical speeds alone.
struct ReservoirGain {
  double gain_m2ps2 = 0.0;
  double path_m2ps2 = 0.0;             ///< S, sum of (v + v')^2
  double timing_se_m2ps2 = 0.0;        ///< from the errors of the times
  double offset_se_m2ps2 = 0.0;        ///< from t^2, of which only the mean 2 q is known
  std::optional<double> law_se_m2ps2;  ///< from the error of the law, which all chains share
};

/// Balance of energy at each impact, with the law at the contact's own speed v_c, which the impulse gives:
///
///   w' - w = v^2 - v'^2 - (1 - eps(v_c)) v_c (v + v'),   (1 + eps(v_c)) v_c = (v + v') (1 + t^2)
///
/// Exact but for t^2, the offset of the contact squared (times c), in a term with the factor 1 - eps: its mean 2 q is
/// taken, with q = sum of gains / (2 sum of S) over all chains, for a reservoir grows by 2 q (v + v')^2 in the mean.
/// Neighbouring impacts share a flight, so that errors of its speed cancel but for 1 - eps^2 of them. To leading order
/// the sum of (eps v)^2 - v'^2. What friction takes from the reservoir is counted as gained.
/// @param gravity_mps2  of the speeds; used for the errors only
/// @return one for each chain
std::vector<ReservoirGain> reservoir_gains(const std::vector<ImpactChain>& chains, const LawWithErrors& law,
                                           double gravity_mps2);

}  // namespace bouncelab::fit
