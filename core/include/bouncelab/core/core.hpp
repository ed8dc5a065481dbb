// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: everything that the other modules share. Values and their tables, numerics, files and random numbers.
#pragma once

#include "bouncelab/core/ball.hpp"  // materials, balls and plates by name; contact time and force by Hertz; drag, gravity
#include "bouncelab/core/child_process.hpp"            // decoders and other programs, with limits
#include "bouncelab/core/elementary.hpp"               // exp, log, sin ... to the same bits everywhere
#include "bouncelab/core/error.hpp"                    // what is thrown
#include "bouncelab/core/file_bytes.hpp"               // bytes of a file without reading it whole
#include "bouncelab/core/file_plan.hpp"                // no output is an input
#include "bouncelab/core/fluctuation.hpp"              // of eps, given the drop's past
#include "bouncelab/core/folder_lock.hpp"              // one run at a time in a folder
#include "bouncelab/core/impacts.hpp"                  // simulate writes, synthesize reads
#include "bouncelab/core/input_file.hpp"               // pipes too
#include "bouncelab/core/interrupts.hpp"               // asked to stop
#include "bouncelab/core/numerics.hpp"                 // Bessel functions, quadrature, roots
#include "bouncelab/core/onsets.hpp"                   // detect writes, restitution reads; their flags
#include "bouncelab/core/output_file.hpp"              // whole or not at all
#include "bouncelab/core/parallel.hpp"                 // loops on several threads; long computations report
#include "bouncelab/core/random.hpp"                   // counter-based random numbers
#include "bouncelab/core/restitution_law.hpp"          // eps(v)
#include "bouncelab/core/restitution_with_memory.hpp"  // a sampler for DEM codes
#include "bouncelab/core/samples.hpp"                  // restitution writes, fit reads
#include "bouncelab/core/scratch_file.hpp"             // what need not stay in memory
#include "bouncelab/core/statistics.hpp"               // medians, quantiles
#include "bouncelab/core/table.hpp"                    // columns by name, in memory and as CSV
#include "bouncelab/core/text.hpp"  // text from outside as messages show it; UTF-8; names that were probably meant
#include "bouncelab/core/vector_clones.hpp"  // loops for the widest registers of the processor
#include "bouncelab/core/version.hpp"        // version and commit
