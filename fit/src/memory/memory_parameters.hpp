// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab::fit {

/// The law at one impact.
template <class T>
struct LawAt {
  T eps;
  T slope;  ///< d eps / d v [s/m]
};

/// What all impacts have in common.
template <class T>
struct MemoryParameters {
  T q;        ///< variance of the contacts' offset, per component (docs/physics.md)
  T keep;     ///< share of the reservoir that outlasts a bounce
  T release;  ///< mean reservoir at the release [m^2/s^2]
  T ratio;    ///< 1; of the mean of |t|^2 to 2 q, to test whether both effects of the offset agree
};

}  // namespace bouncelab::fit
