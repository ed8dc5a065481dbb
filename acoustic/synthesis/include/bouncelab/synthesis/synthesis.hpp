// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: impact times to sound, with its truth.
#pragma once

#include "bouncelab/synthesis/disturbances.hpp"         // sounds and interference beside the ball
#include "bouncelab/synthesis/hard_cases.hpp"           // recordings in which impacts are hard to detect
#include "bouncelab/synthesis/plate.hpp"                // the grounds and their modes
#include "bouncelab/synthesis/sensor.hpp"               // piezo and microphone
#include "bouncelab/synthesis/synthesize.hpp"           // hours of sound to files, drop by drop
#include "bouncelab/synthesis/synthetic_recording.hpp"  // one recording as a function of time, and its truth
