// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/normal_laplace_block.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/vector_clones.hpp"
#include "law/scaled_erfc.hpp"

// Loops without branches: what is not wanted of a sample is computed and not taken.

namespace bouncelab::fit {
namespace {

/// Sides as T1 and T2 see them, and what is first known: all of a sample that is far from the peak.
struct PartsBlock {
  Block a_tau, c_tau, z, u1, u2;
  Block exponent, sum, share_above, hazard;
};

BOUNCELAB_VECTOR_CLONES void far_parts(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                                       const double* inverse_tau, PartsBlock& __restrict p) {
  for (std::size_t k = 0; k < n; ++k) {
    const double a_tau = tau[k] * sides.inverse_above[k], c_tau = tau[k] * sides.inverse_below[k];
    const double z = d[k] * inverse_tau[k];
    const double u1 = a_tau - z, u2 = c_tau + z;
    const double above = a_tau * (0.5 * a_tau - z), below = c_tau * (0.5 * c_tau + z);
    const double beside = -0.5 * z * z - kLogSqrt2Pi;
    p.a_tau[k] = a_tau;
    p.c_tau[k] = c_tau;
    p.z[k] = z;
    p.u1[k] = u1;
    p.u2[k] = u2;
    const double not_above = u2 < 0.0 ? below : beside;
    p.exponent[k] = u1 < 0.0 ? above : not_above;
    p.sum[k] = 1.0;
    p.share_above[k] = u1 < 0.0 ? 1.0 : 0.0;
    p.hazard[k] = 0.0;
  }
}

/// Samples near the peak, gathered.
struct NearBlock {
  std::size_t n = 0;
  std::array<std::size_t, kBlockSize> of;
  Block u1, u2, exp1, exp2;  ///< exp1, exp2: first the arguments
  Block sum, share_above, hazard;
};

/// The smaller of u1 and u2 of each sample, and the largest of these in each lane: of exact times few samples are near
/// the peak, and in most lanes none.
/// @param p  those that fill up the block are far off
BOUNCELAB_VECTOR_CLONES void nearness(const PartsBlock& p, Block& __restrict least,
                                      std::array<double, kLanes>& __restrict largest) {
  for (std::size_t k = 0; k < kBlockSize; ++k) least[k] = p.u1[k] < p.u2[k] ? p.u1[k] : p.u2[k];
  Lanes most, here;
  std::memcpy(&most, least.data(), sizeof most);
  for (std::size_t k = kLanes; k < kBlockSize; k += kLanes) {
    std::memcpy(&here, least.data() + k, sizeof here);
    most = most < here ? here : most;
  }
  std::memcpy(largest.data(), &most, sizeof most);
}

void gather(const PartsBlock& p, NearBlock& near) {
  Block least;
  std::array<double, kLanes> largest;
  nearness(p, least, largest);
  near.n = 0;
  for (std::size_t l = 0; l < kLanes; ++l) {
    if (!(largest[l] >= -kFar)) continue;
    for (std::size_t k = l; k < kBlockSize; k += kLanes) {
      near.of[near.n] = k;
      near.n += least[k] >= -kFar ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < near.n; ++i) {
    near.u1[i] = p.u1[near.of[i]];
    near.u2[i] = p.u2[near.of[i]];
  }
}

/// Of phi(u) where u < 0, of the factor of Mills' ratio near 0.
inline double exp_argument(double u) {
  const double x = u * kInvSqrt2;
  const double small = x <= cody::kNearReach ? x * x : 0.0;
  return u < 0.0 ? -0.5 * u * u : small;
}

struct Mills {
  double ratio;  ///< of |u|; where that is near 0 and u < 0 not known
  double tail;   ///< 1 - Phi(|u|), for u < 0
  double normal;
};

/// @param e  exp(exp_argument(u))
inline Mills mills(double u, double e) {
  const double x = std::abs(u) * kInvSqrt2;
  const double erfc_near = cody::erfc_near(x), middle = cody::scaled_erfc_middle(x), far = cody::scaled_erfc_far(x);
  const double beyond = x <= cody::kMiddleReach ? middle : far;
  const double ratio = kSqrtHalfPi * (x <= cody::kNearReach ? e * erfc_near : beyond);
  const double normal = e / kSqrt2Pi;
  return {ratio, x > cody::kNearReach ? normal * (kSqrtHalfPi * beyond) : 0.5 * erfc_near, normal};
}

BOUNCELAB_VECTOR_CLONES void exp_arguments(NearBlock& near) {
  for (std::size_t i = 0; i < near.n; ++i) {
    near.exp1[i] = exp_argument(near.u1[i]);
    near.exp2[i] = exp_argument(near.u2[i]);
  }
}

BOUNCELAB_VECTOR_CLONES void near_parts(NearBlock& near) {
  for (std::size_t i = 0; i < near.n; ++i) {
    const double u1 = near.u1[i], u2 = near.u2[i];
    const Mills m1 = mills(u1, near.exp1[i]), m2 = mills(u2, near.exp2[i]);
    const bool is_above = u1 < 0.0;
    // one side beyond its exponential's start: that one whole less its tail, the other by its ratio
    const double normal = is_above ? m1.normal : m2.normal;
    const double whole = 1.0 - (is_above ? m1.tail : m2.tail);
    const double other = normal * (is_above ? m2.ratio : m1.ratio);
    const double sum_beyond = whole + other, share_beyond = whole / sum_beyond;
    const double mirrored = 1.0 - share_beyond;
    const double sum_beside = m1.ratio + m2.ratio;
    const bool is_beyond = is_above || u2 < 0.0;
    const double sum = is_beyond ? sum_beyond : sum_beside;
    const double share_of_beyond = is_above ? share_beyond : mirrored, share_beside = m1.ratio / sum_beside;
    near.sum[i] = sum;
    near.share_above[i] = is_beyond ? share_of_beyond : share_beside;
    near.hazard[i] = (is_beyond ? normal : 1.0) / sum;
  }
}

void scatter(const NearBlock& near, PartsBlock& p) {
  for (std::size_t i = 0; i < near.n; ++i) {
    const std::size_t k = near.of[i];
    p.sum[k] = near.sum[i];
    p.share_above[k] = near.share_above[i];
    p.hazard[k] = near.hazard[i];
  }
}

BOUNCELAB_VECTOR_CLONES void negate(std::size_t n, const Block& x, Block& __restrict to) {
  for (std::size_t k = 0; k < n; ++k) to[k] = -x[k];
}

/// @param inverse  of exp(exponent); 0 where there is no background
BOUNCELAB_VECTOR_CLONES void densities(std::size_t n, const SidesBlock& sides, const PartsBlock& p,
                                       const Block& inverse, double background, DensityBlock& __restrict f) {
  const double vanishing = background > 0.0 ? kVanished : -HUGE_VAL;
  for (std::size_t k = 0; k < n; ++k) {
    const double density = p.sum[k] * sides.inverse_width[k];
    const double sum = density + background * inverse[k];
    const bool vanished = p.exponent[k] < vanishing;
    // without a background exactly 1
    const double part = density / sum, share = vanished ? 0.0 : part;
    const double a_tau = p.a_tau[k], c_tau = p.c_tau[k], z = p.z[k], hazard = p.hazard[k];
    const double w1 = p.share_above[k], w2 = 1.0 - w1;
    const double d_location = w1 * sides.inverse_above[k] - w2 * sides.inverse_below[k];
    // as in normal_laplace() of one
    const double curvature =
        a_tau * c_tau * (1.0 - (sides.b_above[k] - sides.b_below[k]) * d_location) - hazard * (a_tau + c_tau);
    const double by_log_below = -share * (1.0 - sides.p_above[k] + c_tau * ((c_tau + z) * w2 - hazard));
    const double by_log_above = -share * (sides.p_above[k] + a_tau * ((a_tau - z) * w1 - hazard));
    const double by_location = share * d_location, by_log_tau = share * curvature;
    f.exponent[k] = vanished ? 0.0 : p.exponent[k];
    f.factor[k] = vanished ? background : sum;
    f.d_location[k] = vanished ? 0.0 : by_location;
    f.d_log_below[k] = vanished ? 0.0 : by_log_below;
    f.d_log_above[k] = vanished ? 0.0 : by_log_above;
    f.d_log_tau[k] = vanished ? 0.0 : by_log_tau;
  }
}

}  // namespace

BOUNCELAB_VECTOR_CLONES void complete_sides(std::size_t n, SidesBlock& sides) {
  for (std::size_t k = 0; k < n; ++k) {
    const double below = sides.b_below[k], above = sides.b_above[k];
    const double sum = below + above, product = below * above;
    const double inverse = 1.0 / (sum * product);  // one division serves all
    sides.inverse_below[k] = inverse * sum * above;
    sides.inverse_above[k] = inverse * sum * below;
    sides.p_above[k] = inverse * product * above;
    sides.inverse_width[k] = inverse * product;
  }
}

namespace {

void parts(std::size_t n, const double* d, const SidesBlock& sides, const double* tau, const double* inverse_tau,
           PartsBlock& p) {
  far_parts(n, d, sides, tau, inverse_tau, p);
  for (Block* u : {&p.u1, &p.u2}) std::fill(u->begin() + static_cast<std::ptrdiff_t>(n), u->end(), -HUGE_VAL);
  NearBlock near;
  gather(p, near);
  if (near.n == 0) return;
  exp_arguments(near);
  exp_each(std::span(near.exp1).first(near.n));
  exp_each(std::span(near.exp2).first(near.n));
  near_parts(near);
  scatter(near, p);
}

BOUNCELAB_VECTOR_CLONES void normal_cdfs(std::size_t n, const double* density_arguments, double* z) {
  for (std::size_t k = 0; k < n; ++k) {
    const double tail = mills(-std::abs(z[k]), density_arguments[k]).tail;
    z[k] = z[k] < 0.0 ? tail : 1.0 - tail;
  }
}

}  // namespace

void normal_cdf_each(std::span<double> z) {
  Block e;
  for (std::size_t begin = 0; begin < z.size(); begin += kBlockSize) {
    const std::size_t n = std::min(kBlockSize, z.size() - begin);
    double* const at = z.data() + begin;
    for (std::size_t k = 0; k < n; ++k) e[k] = -0.5 * at[k] * at[k];
    exp_each(std::span(e).first(n));
    normal_cdfs(n, e.data(), at);
  }
}

void normal_laplace_cdf(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                        const double* inverse_tau, double* cdf) {
  PartsBlock p;
  parts(n, d, sides, tau, inverse_tau, p);
  for (std::size_t k = 0; k < n; ++k) cdf[k] = p.z[k];
  normal_cdf_each({cdf, n});
  exp_each(std::span(p.exponent).first(n));
  // integrate by parts: F = Phi(z) - p_above T1 + p_below T2
  for (std::size_t k = 0; k < n; ++k) {
    const double of_both = (1.0 - sides.p_above[k]) * (1.0 - p.share_above[k]) - sides.p_above[k] * p.share_above[k];
    cdf[k] += p.exponent[k] * p.sum[k] * of_both;
  }
}

void normal_laplace(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                    const double* inverse_tau, double background, DensityBlock& f) {
  PartsBlock p;
  parts(n, d, sides, tau, inverse_tau, p);
  Block inverse;
  if (background > 0.0) {
    negate(n, p.exponent, inverse);
    exp_each(std::span(inverse).first(n));
  } else {
    inverse.fill(0.0);
  }
  densities(n, sides, p, inverse, background, f);
}

}  // namespace bouncelab::fit
