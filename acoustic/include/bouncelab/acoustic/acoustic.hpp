// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: impact times to sound, and sound to impact times.
#pragma once

#include "bouncelab/audio/audio.hpp"          // sound files, signal processing, annotations of sound editors
#include "bouncelab/detection/detection.hpp"  // sound -> impact times with standard errors
#include "bouncelab/synthesis/synthesis.hpp"  // impact times -> sound
