// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: everything that the other modules share. Values and their tables, numerics, files and random numbers.
#pragma once

#include <string_view>

#include "bouncelab/core/ball.hpp"  // materials, balls and plates by name; contact time and force by Hertz; drag, gravity
#include "bouncelab/core/elementary.hpp"       // exp, log, sin ... to the same bits everywhere; vector registers
#include "bouncelab/core/error.hpp"            // what is thrown
#include "bouncelab/core/files.hpp"            // pipes too; outputs whole or not at all; other programs, with limits
#include "bouncelab/core/fluctuation.hpp"      // of eps, given the drop's past
#include "bouncelab/core/impacts.hpp"          // simulate writes, synthesize reads
#include "bouncelab/core/numerics.hpp"         // Bessel functions, quadrature, roots, medians
#include "bouncelab/core/onsets.hpp"           // detect writes, restitution reads; their flags
#include "bouncelab/core/parallel.hpp"         // loops on several threads; progress; asked to stop
#include "bouncelab/core/random.hpp"           // counter-based random numbers
#include "bouncelab/core/restitution_law.hpp"  // eps(v)
#include "bouncelab/core/restitution_with_memory.hpp"  // a sampler for DEM codes
#include "bouncelab/core/samples.hpp"                  // restitution writes, fit reads
#include "bouncelab/core/table.hpp"                    // columns by name, in memory and as CSV
#include "bouncelab/core/text.hpp"  // text from outside as messages show it; UTF-8; names that were probably meant

namespace bouncelab {

/// Version of the release, e.g. "0.1.0".
std::string_view version();
/// Commit the build was configured from, short hash, "+" appended where the tree had changes; "unknown" outside git.
std::string_view commit();

}  // namespace bouncelab
