// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/memory_draws.hpp"

#include <cmath>

#include "bouncelab/core/restitution_with_memory.hpp"

namespace bouncelab::fit {

Chain draw_chain(const Chain& like, const RestitutionLaw& law, const MemoryParameters<double>& parameters,
                 double height_sd_m, Random& random) {
  Chain chain = like;
  const auto eps = [&](double v_mps) { return restitution(law, v_mps); };
  const auto draw_height_m = [&] { return -height_sd_m * random.exponential(); };
  const auto draw_timing = [&](double variance) { return std::sqrt(variance) * random.normal(); };
  const ChainImpact& first = like.impacts.front();
  double w = (2.0 * parameters.q * like.s_before + parameters.release) * random.exponential(), v = first.v_mps;
  double height_before = draw_height_m(), height = draw_height_m();
  double timing_before = draw_timing(first.timing_before), timing = draw_timing(first.timing);
  // errors are those of `like`: the drawn speeds differ too little to scale them anew
  for (ChainImpact& m : chain.impacts) {
    m.v_mps = v + m.height_mps * (height - height_before) + timing - timing_before;
    const double z1 = random.normal(), z2 = random.normal();
    const double eps_drawn = restitution_with_memory(v, eps, parameters.q, z1, z2, w), v_after = eps_drawn * v;
    w *= kept(parameters, m);
    // a next contact that is higher by this, in speed, is met earlier and at twice as much less
    const double height_next = draw_height_m(), timing_next = draw_timing(m.timing_after);
    const double rise = m.height_mps / eps_drawn * (height_next - height);
    m.v_after_mps = v_after - rise + timing_next - timing;
    v = v_after - 2.0 * rise;
    height_before = height;
    height = height_next;
    timing_before = timing;
    timing = timing_next;
  }
  return chain;
}

}  // namespace bouncelab::fit
