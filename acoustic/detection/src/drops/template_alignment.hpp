// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/audio/dsp.hpp"

namespace bouncelab::detection {

/// How much later than the start of contact that each template shows its modes begin, against the other templates
/// [samples].
///
/// Where a ball strikes elsewhere the modes of a plate sound with other amplitudes, of either sign, but with the same
/// phases. So W^2/|W| is alike in all templates, which tells to some hundred nanoseconds what is later than what; then
/// templates are sums of few shapes with real factors in each eight bins, whichever modes sound there, which tells
/// tens.
/// @param modes  spectra of the templates, whitened without a delay, from the start of contact on; in bins from 0 to
///               the Nyquist frequency whose numbers, less one, differ by powers of two
/// @param reach  the largest shift [samples]
std::vector<double> align_templates(std::vector<audio::Spectrum> modes, double reach);

}  // namespace bouncelab::detection
