// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: sound files, the signal processing that synthesis and detection share, annotations of sound editors.
#pragma once

#include "bouncelab/audio/annotations.hpp"   // impact times in sound editors, and back
#include "bouncelab/audio/audio_reader.hpp"  // any recording, as samples
#include "bouncelab/audio/audio_writer.hpp"  // samples to WAV, RF64, W64, FLAC
#include "bouncelab/audio/dsp/kernels.hpp"   // dot products, FIR filters
#include "bouncelab/audio/dsp/real_fft.hpp"  // Fourier transform of real signals
