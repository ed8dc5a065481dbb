// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: impact times to sound, and sound to impact times.
#pragma once

#include "bouncelab/acoustic/audio_reader.hpp"  // any file that libsndfile reads, as samples
#include "bouncelab/acoustic/audio_writer.hpp"  // samples to WAV, RF64, W64, FLAC
#include "bouncelab/acoustic/detection.hpp"     // sound -> impact times with standard errors
#include "bouncelab/acoustic/hard_cases.hpp"    // recordings that are hard to hear impacts in
#include "bouncelab/acoustic/marks.hpp"         // impact times in sound editors, and back
#include "bouncelab/acoustic/plate.hpp"         // the grounds and their modes
#include "bouncelab/acoustic/score.hpp"         // detected against true times
#include "bouncelab/acoustic/sound.hpp"         // one channel that can be read anywhere
#include "bouncelab/acoustic/synthesis.hpp"     // impact times -> sound and its truth
#include "bouncelab/acoustic/synthesize.hpp"    // hours of it to files, drop by drop
#include "bouncelab/acoustic/wave_preview.hpp"  // a recording small enough to be drawn
