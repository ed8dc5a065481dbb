// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/drop_timer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "contact/band_levels.hpp"
#include "delay/impact_timer.hpp"
#include "delay/track_timer.hpp"
#include "drops/drops_model.hpp"
#include "drops/overlap_separation.hpp"
#include "template/impact_template.hpp"

namespace bouncelab::detection {
namespace {

/// Times of the candidates, where there is no template.
std::vector<TimedImpact> times_of_candidates(const BandOfDrops& band, const Track& track) {
  std::vector<TimedImpact> impacts;
  for (const TrackImpact& of_track : track.impacts) {
    const Candidate& c = band.candidates[of_track.candidate];
    TimedImpact impact;
    impact.impact = of_track.impact;
    impact.probability = of_track.probability;
    impact.fit.t_s = c.t_s;
    impact.fit.sigma_s = kDrops.sigma_of_reach * c.reach_s;
    impacts.push_back(impact);
  }
  return impacts;
}

/// v^(-1/5) of the impacts that a template mostly is the mean of.
double scaling_of_strongest(const std::vector<TimedImpact>& impacts) {
  double sum = 0.0;
  double weight = 1e-300;
  for (const TimedImpact& impact : impacts) {
    const double amplitude = impact.fit.amplitude;
    sum += amplitude * amplitude * pow(impact.v_mps, -0.2);
    weight += amplitude * amplitude;
  }
  return sum / weight;
}

}  // namespace

void mark_clipped(const BandOfDrops& band, std::vector<TimedImpact>& impacts) {
  for (TimedImpact& impact : impacts) impact.clipped = band.limits.are_reached(band.recorded(), impact.fit.t_s);
}

void set_speeds(double gravity_mps2, std::vector<TimedImpact>& impacts) {
  const auto flight_s = [&](std::size_t k) {  // between impact k - 1 and k; 0 where one is missing between them
    return impacts[k].impact == impacts[k - 1].impact + 1 ? impacts[k].fit.t_s - impacts[k - 1].fit.t_s : 0.0;
  };
  for (std::size_t k = 1; k < impacts.size(); ++k) impacts[k].v_mps = 0.5 * gravity_mps2 * flight_s(k);
  for (std::size_t k = 0; k + 1 < impacts.size(); ++k)
    if (impacts[k].v_mps == 0.0 && flight_s(k + 1) > 0.0) {
      const double next_s = k + 2 < impacts.size() ? flight_s(k + 2) : 0.0;
      const double eps = next_s > 0.0 ? std::clamp(next_s / flight_s(k + 1), 0.3, 1.0) : 1.0;
      impacts[k].v_mps = 0.5 * gravity_mps2 * flight_s(k + 1) / eps;
    }
}

std::optional<ImpactTemplate> template_of(const BandOfDrops& band, const std::vector<Track>& tracks,
                                          WhiteSound& white) {
  std::vector<Candidate> impacts;
  std::vector<bool> clipped;
  for (const Track& track : tracks)
    for (const TrackImpact& impact : track.impacts) {
      impacts.push_back(band.candidates[impact.candidate]);
      clipped.push_back(band.limits.are_reached(band.recorded(), impacts.back().t_s));
    }
  return estimate_template(white, band.noise, impacts, clipped);
}

TimedDrop time_drop(const BandOfDrops& band, const Track& track, const ImpactTemplate* learned, double end_s,
                    double gravity_mps2, WhiteSound& white) {
  TimedDrop drop;
  drop.impacts = learned != nullptr ? time_track(white, *learned, track, band.candidates, end_s)
                                    : times_of_candidates(band, track);
  set_speeds(gravity_mps2, drop.impacts);
  mark_clipped(band, drop.impacts);
  if (learned == nullptr) return drop;
  drop.peak = learned->peak;
  drop.correlation = learned->correlation;
  drop.wave = learned->wave;
  // a band says nothing of the frequencies beyond it
  drop.rms_hz = band.recorded_rms_hz ? *band.recorded_rms_hz : recorded_rms_frequency(*learned) * band.sound.rate_hz;
  std::vector<TimedImpact> all;
  std::vector<TimedImpact> clear;
  for (const TimedImpact& impact : drop.impacts) {
    if (!(impact.v_mps > 0.0)) continue;
    all.push_back(impact);
    if (!impact.overlap && !impact.inferred && !impact.doubtful && !impact.clipped) clear.push_back(impact);
  }
  drop.contact = fit_contact(measure_levels(white, *learned, clear));
  drop.reference_scaling = scaling_of_strongest(clear.empty() ? all : clear);
  std::vector<ContactEvidence> evidence;
  if (drop.contact) evidence.push_back(*drop.contact);
  const ContactLaw law = pool_contacts(evidence, assumed_contact(*drop.rms_hz));
  if (separate_overlaps(white, *learned, law, drop.reference_scaling, drop.impacts))
    mark_clipped(band, drop.impacts);  // at their new times
  return drop;
}

}  // namespace bouncelab::detection
