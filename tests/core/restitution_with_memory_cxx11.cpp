// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled as C++11, for this header is to be copied into codes that are.
#include "bouncelab/core/restitution_with_memory.hpp"

#if __cplusplus > 201103L
#error "not C++11"
#endif

double bounce_in_cxx11(double v_mps, double eps, double q, double z1, double z2, double& reservoir_m2ps2) {
  return bouncelab::restitution_with_memory(
      v_mps, [eps](double) { return eps; }, q, z1, z2, reservoir_m2ps2);
}
