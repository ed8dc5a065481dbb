// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: everything that the other modules share. Values and their tables, numerics, files and random numbers.
#pragma once

#include "bouncelab/core/air.hpp"                      // density, viscosity, drag of a sphere
#include "bouncelab/core/ball.hpp"                     // material, mass, inertia, contact time
#include "bouncelab/core/ball_catalogue.hpp"           // balls and plates by name
#include "bouncelab/core/child_process.hpp"            // readers of foreign files, with limits
#include "bouncelab/core/csv.hpp"                      // tables as files
#include "bouncelab/core/elementary.hpp"               // exp, log, sin ... to the same bits everywhere
#include "bouncelab/core/error.hpp"                    // what is thrown
#include "bouncelab/core/file_bytes.hpp"               // bytes of a file without reading it whole
#include "bouncelab/core/file_plan.hpp"                // no output is an input
#include "bouncelab/core/flags.hpp"                    // of onsets and samples
#include "bouncelab/core/fluctuation.hpp"              // of eps, given the drop's past
#include "bouncelab/core/folder_lock.hpp"              // one run at a time in a folder
#include "bouncelab/core/hertz_pulse.hpp"              // force over time of an impact
#include "bouncelab/core/impacts.hpp"                  // simulate writes, synthesize reads
#include "bouncelab/core/input_file.hpp"               // pipes too
#include "bouncelab/core/interrupts.hpp"               // asked to stop
#include "bouncelab/core/line_reader.hpp"              // of tables of text
#include "bouncelab/core/nearest_name.hpp"             // for names that are not known
#include "bouncelab/core/numerics.hpp"                 // Bessel functions, quadrature, roots
#include "bouncelab/core/onsets.hpp"                   // detect writes, restitution reads
#include "bouncelab/core/output_file.hpp"              // whole or not at all
#include "bouncelab/core/parallel.hpp"                 // loops on several threads
#include "bouncelab/core/printable.hpp"                // names and cells in messages
#include "bouncelab/core/program_output.hpp"           // of other programs, without a shell
#include "bouncelab/core/progress.hpp"                 // long computations report here
#include "bouncelab/core/random.hpp"                   // counter-based random numbers
#include "bouncelab/core/restitution_law.hpp"          // eps(v)
#include "bouncelab/core/restitution_with_memory.hpp"  // a sampler for DEM codes
#include "bouncelab/core/samples.hpp"                  // restitution writes, fit reads
#include "bouncelab/core/scratch_file.hpp"             // what need not stay in memory
#include "bouncelab/core/statistics.hpp"               // medians, quantiles
#include "bouncelab/core/streamed_median.hpp"          // of more values than the memory holds
#include "bouncelab/core/table.hpp"                    // columns by name
#include "bouncelab/core/units.hpp"                    // pi, g
#include "bouncelab/core/utf8.hpp"                     // bytes as text that can be turned back
#include "bouncelab/core/version.hpp"                  // version and commit
