// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: sound to impact times with standard errors.
#pragma once

#include "bouncelab/detection/detect.hpp"        // the detector; detected against true times
#include "bouncelab/detection/wave_preview.hpp"  // a recording reduced for a plot
