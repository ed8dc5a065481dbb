// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab::synthesis {

/// J_n(x) and I_n(x), n >= 0, 0 <= x < 700, by backward recurrence (Miller's algorithm; Olver et al., NIST Handbook
/// (2010), 10.74(iv)): sums and products only, the same bits on every processor. Errors below 1e-15 of the largest
/// J_k(x) and of I_n(x).
double bessel_j(int n, double x);
double bessel_i(int n, double x);

}  // namespace bouncelab::synthesis
