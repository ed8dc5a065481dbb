// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/chains.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {
namespace {

bool same_drop(const RestitutionSample& a, const RestitutionSample& b) {
  return a.drop == b.drop && a.recording == b.recording;
}

double gravity_of(const RestitutionSample& s) { return s.conditions.gravity_mps2.value_or(kDefaultGravity_mps2); }

/// (1 + e)^2 v^2 of the impacts before one of speed v, number `impact` of its drop.
double s_before(double v_mps, std::int64_t impact, const RestitutionLaw& law) {
  double sum = 0.0;
  for (std::int64_t k = 0; k < impact; ++k) {
    v_mps /= restitution(law, v_mps / restitution(law, v_mps));
    sum += square((1.0 + restitution(law, v_mps)) * v_mps);
  }
  return sum;
}

/// Variances of the times of impacts, from what samples state of v and eps: with s_i the variance at impact i and T_i
/// the interval before it, (2 sigma_v / g)^2 = s_i + s_{i-1} and (T_i sigma_eps)^2 = s_{i+1} + (1 + eps)^2 s_i +
/// eps^2 s_{i-1}; three unknowns for two equations of one sample, and one more equation from the next.
/// @return of the impact before the first sample, then of each sample, then of the one after the last [s^2]
std::vector<double> time_variances(std::span<const RestitutionSample> chain) {
  const auto of_eps = [](const RestitutionSample& s) {
    return square(s.sigma_eps.value_or(0.0) * 2.0 * s.v_mps / gravity_of(s));
  };
  /// Were all three times as good as each other.
  const auto alike = [&](const RestitutionSample& s) {
    return of_eps(s) / (1.0 + square(1.0 + s.eps) + square(s.eps));
  };
  const auto pair = [&](const RestitutionSample& s) {
    const double sigma = s.sigma_v_mps.value_or(0.0);
    return sigma > 0.0 ? square(2.0 * sigma / gravity_of(s)) : 2.0 * alike(s);
  };
  std::vector<double> variances{0.0};
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const RestitutionSample& s = chain[k];
    variances.push_back(
        k + 1 == chain.size() || !s.sigma_v_mps || !s.sigma_eps
            ? alike(s)
            : std::clamp((of_eps(s) - pair(chain[k + 1]) - square(s.eps) * pair(s)) / (2.0 * s.eps), 0.0, pair(s)));
  }
  variances.front() = std::max(0.0, pair(chain.front()) - variances[1]);
  const RestitutionSample& last = chain.back();
  const double here = variances.back(), before = variances[variances.size() - 2];
  variances.push_back(std::max(0.0, of_eps(last) - square(1.0 + last.eps) * here - square(last.eps) * before));
  return variances;
}

/// Whether b is the next impact of a. Tables may number their rows where they know nothing of drops; but no flight
/// changes the speed so much.
bool follows(const RestitutionSample& a, const RestitutionSample& b) {
  constexpr double kMost = 1.5;
  const double ratio = b.v_mps / (a.eps * a.v_mps);
  return b.impact == a.impact + 1 && ratio < kMost && ratio * kMost > 1.0;
}

Chain chain_of(const RestitutionSamples& samples, std::size_t begin, std::size_t end, const RestitutionLaw& law) {
  Chain chain;
  const std::vector<double> variances = time_variances(std::span(samples).subspan(begin, end - begin));
  for (std::size_t k = begin; k < end; ++k) {
    const RestitutionSample& s = samples[k];
    const double half_g = 0.5 * gravity_of(s), scale = square(half_g);
    const double* v = &variances[k - begin];
    ChainImpact m{k, s.v_mps, s.eps * s.v_mps, scale * v[0], scale * v[1], scale * v[2], half_g / s.v_mps, {}};
    for (std::size_t j = 0; j < kSlipTimes; ++j)
      m.soon[j] = expm1(1.0 / kSlipTime[j]) * exp(-static_cast<double>(s.impact) / kSlipTime[j]);
    chain.impacts.push_back(m);
  }
  chain.s_before = s_before(samples[begin].v_mps, samples[begin].impact, law);
  return chain;
}

}  // namespace

Chains chains_of(const RestitutionSamples& samples, const std::vector<std::size_t>& left_out,
                 const RestitutionLaw& law) {
  Chains result;
  if (!samples.empty()) result.ball = samples.front().conditions.ball.value_or(Ball{});
  // the first impact of a ball at rest cannot scatter above eps(v) at all: an edge, which a height of release that is
  // a little off would put at the wrong place
  const auto out = [&](std::size_t k) {
    return samples[k].impact == 0 || !samples[k].flags.empty() || !(samples[k].eps > 0.0) ||
           std::binary_search(left_out.begin(), left_out.end(), k);
  };
  for (std::size_t k = 0; k < samples.size();) {
    if (k > 0 && !same_drop(samples[k - 1], samples[k])) ++result.n_drops;
    if (out(k)) {
      ++k;
      continue;
    }
    std::size_t end = k + 1;
    while (end < samples.size() && same_drop(samples[k], samples[end]) && !out(end) &&
           follows(samples[end - 1], samples[end]))
      ++end;
    Chain chain = chain_of(samples, k, end, law);
    chain.drop = result.n_drops;
    result.n_impacts += end - k;
    result.chains.push_back(std::move(chain));
    k = end;
  }
  if (!samples.empty()) ++result.n_drops;
  if (!result.chains.empty())
    result.least_s_before =
        std::min_element(result.chains.begin(), result.chains.end(), [](const Chain& a, const Chain& b) {
          return a.s_before < b.s_before;
        })->s_before;
  return result;
}

Chains thinned_chains(const Chains& all, std::size_t n_most) {
  const std::size_t stride = (all.n_impacts + n_most - 1) / n_most;
  Chains few;
  few.ball = all.ball;
  few.n_drops = all.n_drops;
  few.least_s_before = all.least_s_before;
  for (std::size_t c = 0; c < all.chains.size(); c += stride) {
    few.chains.push_back(all.chains[c]);
    few.n_impacts += all.chains[c].impacts.size();
  }
  return few;
}

}  // namespace bouncelab::fit
