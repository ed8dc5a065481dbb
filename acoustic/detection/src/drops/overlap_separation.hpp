// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/contact_time.hpp"
#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// Joint estimation of impacts whose sounds overlap: the amplitudes of all by linear least squares (ringing.hpp), then
/// the time of each flagged one with the sound of the others subtracted; in turns, until none moves by a fifth of its
/// standard error. Slow impacts have longer contacts than those of the template and so fewer high frequencies: each is
/// compared with the template times P(f tau_1 u) / P(f tau_1 u_0), P the spectrum of Hertz's pulse, u = v^(-1/5).
/// @param law               hertz_tau_1_s 0 = the template as it is
/// @param template_scaling  u_0, v^(-1/5) of the impacts that the template is the mean of
/// @param impacts           of one track, in time order; v_mps 0 = the template as it is
/// @return whether there were any
bool separate_overlaps(WhiteSound& white, const ImpactTemplate& learned, const ContactLaw& law, double template_scaling,
                       std::vector<TimedImpact>& impacts);

}  // namespace bouncelab::detection
