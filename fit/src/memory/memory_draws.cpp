// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/memory_draws.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {
namespace {

/// What one contact makes of a ball of vertical speed v and reservoir w.
struct Rebound {
  double v_after_mps, reservoir_m2ps2, offset_square;
};

/// Exact for one asperity (docs/physics.md): effective mass 1/(1 + t^2), eps at the contact's speed of approach,
/// contacts as frequent as they are approached fast.
Rebound rebound(double v_mps, double w, const RestitutionLaw& law, double q, Random& random) {
  const double across = std::sqrt(w), spread = std::sqrt(q);
  double t_x = 0.0, t_y = 0.0, approach = 0.0;
  do {
    t_x = spread * random.normal();
    t_y = spread * random.normal();
    approach = 1.0 + t_x * across / v_mps;
  } while (random.uniform() * (1.0 + 6.0 * spread * across / v_mps) > approach);
  const double offset_square = square(t_x) + square(t_y), e = restitution(law, v_mps * approach);
  const double after_and_before = (1.0 + e) * approach / (1.0 + offset_square);  // over v
  const double v_after = (after_and_before - 1.0) * v_mps;
  const double dissipated = (1.0 - e) / (1.0 + e) * square(after_and_before * v_mps) * (1.0 + offset_square);
  return {v_after, std::max(0.0, w + square(v_mps) - square(v_after) - dissipated), offset_square};
}

}  // namespace

Chain draw_chain(const Chain& like, const RestitutionLaw& law, const MemoryParameters<double>& parameters,
                 double ball_radius_m, Random& random) {
  Chain chain = like;
  const double mean = 2.0 * parameters.q * like.s_before + parameters.release;
  double w = mean * random.exponential(), v = like.impacts.front().v_mps;
  // errors are in speeds, of half of g times a time; the drawn speeds differ too little to scale them anew
  const auto height_of = [&](const Rebound& contact, const ChainImpact& m) {
    return -0.5 * ball_radius_m * (1.0 + kSolidBallInertia) * contact.offset_square * m.height_mps;
  };
  double timing_before = std::sqrt(like.impacts.front().timing_before) * random.normal();
  double timing = std::sqrt(like.impacts.front().timing) * random.normal();
  double height_before = -ball_radius_m * (1.0 + kSolidBallInertia) * parameters.q * random.exponential() *
                         like.impacts.front().height_mps;
  Rebound contact = rebound(v, w, law, parameters.q, random);
  double height = height_of(contact, like.impacts.front());
  for (std::size_t k = 0; k < chain.impacts.size(); ++k) {
    ChainImpact& m = chain.impacts[k];
    // v = m + d, v' = m' - H/e + D + H' - D' (filter.hpp); heights in g h / (2 v)
    m.v_mps = v + height + timing - height_before - timing_before;
    const double v_after = contact.v_after_mps, scale = v / v_after;
    const double timing_next = std::sqrt(m.timing_after) * random.normal();
    w = parameters.keep * contact.reservoir_m2ps2;
    Rebound next = rebound(v_after, w, law, parameters.q, random);
    const double next_height =
        -0.5 * ball_radius_m * (1.0 + kSolidBallInertia) * next.offset_square * m.height_mps * scale;
    // the next contact's height is part of the speed it is approached with
    const double next_v = v_after - 2.0 * (next_height - height * scale);
    m.v_after_mps = v_after + height * scale - next_height - timing + timing_next;
    // at the speed that height leaves
    next.v_after_mps += next_v - v_after;
    v = next_v;
    contact = next;
    timing_before = timing;
    timing = timing_next;
    height_before = height * scale;
    height = next_height;
  }
  return chain;
}

}  // namespace bouncelab::fit
