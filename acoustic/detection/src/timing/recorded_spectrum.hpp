// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "timing/impact_template.hpp"

namespace bouncelab::detection {

/// Root mean square frequency of the impacts as recorded [cycles per sample], of what they have in common: that of the
/// template with the whitener's gain taken off. Background that the impacts do not share, hum and rumble, has no part
/// in it. At least 1e-6.
double recorded_rms_frequency(const ImpactTemplate& learned);

}  // namespace bouncelab::detection
