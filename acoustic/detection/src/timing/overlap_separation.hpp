// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "contact/contact_time.hpp"
#include "timing/impact_template.hpp"
#include "timing/track_timer.hpp"

namespace bouncelab::detection {

/// Times anew the impacts whose sounds reach into each other, each by all of its sound once that of its neighbours,
/// earlier and later, is taken away, until nothing moves any more. Slow impacts last longer and sound duller than those
/// that the wave was learned from: each is given the wave times P(f tau_1 u) / P(f tau_1 reference_scaling), with
/// Hertz's pulse.
/// @param u    v^(-1/5) of each onset; 0 = not known
/// @param reference_scaling  of the learned wave
void separate_overlaps(const audio::AudioSource& sound, const ImpactTemplate& wave,
                       const std::optional<ContactLaw>& law, const std::vector<double>& u, double reference_scaling,
                       std::vector<TimedTrackImpact>& onsets);

}  // namespace bouncelab::detection
