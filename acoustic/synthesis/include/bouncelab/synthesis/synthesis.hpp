// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: impact times to sound, with its truth.
#pragma once

#include "bouncelab/synthesis/plate.hpp"       // the grounds and their modes
#include "bouncelab/synthesis/synthesize.hpp"  // hours of sound to files, drop by drop
#include "bouncelab/synthesis/synthetic_recording.hpp"  // one recording as a function of time, and its truth; disturbances, hard cases
