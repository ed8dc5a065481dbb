// SPDX-License-Identifier: GPL-3.0-or-later
#include "plate/bessel.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bouncelab::synthesis {
namespace {

// the standard library's own errors are a few 1e-14 at the larger arguments
TEST(Bessel, FunctionsAreThoseOfTheStandardLibrary) {
  for (const int n : {0, 1, 2, 7, 30})
    for (const double x : {0.0, 1e-3, 0.4, 2.0, 9.7, 31.0, 120.0}) {
      EXPECT_NEAR(bessel_j(n, x), std::cyl_bessel_j(n, x), 1e-13) << n << " " << x;
      const double i = std::cyl_bessel_i(n, x);
      EXPECT_NEAR(bessel_i(n, x), i, 1e-12 * i) << n << " " << x;
    }
}

}  // namespace
}  // namespace bouncelab::synthesis
