// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: everything the rooms share. Values and their tables first, then what files and random numbers need.
#pragma once

#include "bouncelab/core/air.hpp"              // density and viscosity
#include "bouncelab/core/ball.hpp"             // material, mass, Hertz contact time
#include "bouncelab/core/csv.hpp"              // tables as files
#include "bouncelab/core/error.hpp"            // what is thrown
#include "bouncelab/core/flags.hpp"            // of onsets and samples
#include "bouncelab/core/impacts.hpp"          // simulate writes, synthesize reads
#include "bouncelab/core/onsets.hpp"           // detect writes, restitution reads
#include "bouncelab/core/output_file.hpp"      // whole or not at all
#include "bouncelab/core/parallel.hpp"         // loops on several threads
#include "bouncelab/core/progress.hpp"         // long computations report here
#include "bouncelab/core/random.hpp"           // counter-based random numbers
#include "bouncelab/core/restitution_law.hpp"  // eps(v)
#include "bouncelab/core/samples.hpp"          // restitution writes, fit reads
#include "bouncelab/core/statistics.hpp"       // medians, quantiles
#include "bouncelab/core/table.hpp"            // columns by name
#include "bouncelab/core/units.hpp"            // pi, g
#include "bouncelab/core/version.hpp"          // version and commit
