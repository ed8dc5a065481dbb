// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/audio/dsp/linear_prediction.hpp"
#include "timing/template_alignment.hpp"

namespace bouncelab::detection {

/// The first template: from one impact after the other, one way after the other, until three quarters of the impacts
/// are alike.
void find_template(TemplateEstimation& e);

/// The same, in the first way alone.
/// @return whether three quarters of the impacts are alike
bool find_template_at_candidates(TemplateEstimation& e);

/// The template anew by the noise's own whitener, from the positions known: what a share of the impacts' power stood
/// for is known from the residuals from here on. Leaves the whitener where fewer impacts are alike by the noise's: it
/// is that of digital silence, or of a codec's gaps in the spectrum, which the impacts fill each in its own way.
void whiten_by_noise(TemplateEstimation& e, const audio::ArModel& noise);

}  // namespace bouncelab::detection
