// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: sound files, the signal processing that synthesis and detection share, annotations of sound editors.
#pragma once

#include "bouncelab/audio/annotations.hpp"  // impact times in sound editors, and back
#include "bouncelab/audio/dsp.hpp"          // Fourier transform, dot products, FIR filters
#include "bouncelab/audio/sound_file.hpp"   // any recording as samples; samples to WAV, RF64, W64, FLAC
