// SPDX-License-Identifier: GPL-3.0-or-later
// Bounces a smooth ball without any file, and asks the law what it did.
#include <bouncelab/core/restitution_law.hpp>
#include <bouncelab/fit/fit.hpp>
#include <bouncelab/sim/sim.hpp>
#include <cstdio>

int main() {
  const bouncelab::SeriesLaw law;
  std::printf("eps(0.6 m/s) = %.5f\n", bouncelab::restitution(law, 0.6));
}
