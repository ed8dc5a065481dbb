// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/detection/detect.hpp"
#include "candidates/candidates.hpp"
#include "contact/contact_time.hpp"
#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "tracking/tracker.hpp"
#include "whitening/linear_prediction.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// The values beyond which a converter or an amplifier gives none, full scale or less.
struct ClippingLimits {
  float lowest = -INFINITY, highest = INFINITY;  ///< infinite where the recording has no such limit

  /// Whether the recording reaches one of them within 5 ms after t_s [s].
  bool are_reached(const audio::AudioSource& sound, double t_s) const;
};

/// A limit is the largest value of a recording, or the smallest, if more than one impact reaches it, and below full
/// scale stays at it for two samples: two crests may be equal by chance, or two samples of the crest of a slow wave.
/// @param impacts_s  times of the impacts [s]
ClippingLimits find_clipping_limits(const audio::AudioSource& sound, const std::vector<double>& impacts_s);

/// A band of a recording's frequencies, or all of them, and the drops that were found there.
struct BandOfDrops {
  audio::AudioSource sound;                 ///< in the band
  std::optional<audio::AudioSource> whole;  ///< the sound as recorded; absent where the band is all of it
  ArModel noise;                            ///< of the band
  std::vector<Candidate> candidates;
  std::vector<Track> tracks;  ///< of these candidates
  ClippingLimits limits;      ///< of the sound as recorded
  /// root mean square frequency of the impacts in the whole sound [Hz]; absent where it is the template's own
  std::optional<double> recorded_rms_hz;

  /// The sound as recorded, in which a converter's limit shows.
  const audio::AudioSource& recorded() const { return whole ? *whole : sound; }
};

/// One track, timed.
struct TimedDrop {
  std::vector<TimedImpact> impacts;
  std::optional<double> peak;  ///< of the template as recorded; absent where the drop was timed without template
  std::optional<ContactEvidence> contact;
  double reference_scaling = 0.0;   ///< v^(-1/5) of its strongest impacts
  double correlation = 0.0;         ///< of its template with the impacts
  std::optional<LearnedWave> wave;  ///< its template as recorded
  std::optional<double> rms_hz;     ///< of the impacts as recorded
};

/// Template of the impacts of some tracks of a recording.
/// @param white  of the band's sound
std::optional<ImpactTemplate> template_of(const BandOfDrops& band, const std::vector<Track>& tracks, WhiteSound& white);

/// Times one track: its impacts by the template, their speeds, g T / 2, the contact time by their band levels,
/// and then the impacts that overlap, jointly.
/// @param learned  null = none: then the times are those of the candidates
/// @param end_s    the next track, or the end of the recording [s]
/// @param white    of the band's sound
TimedDrop time_drop(const BandOfDrops& band, const Track& track, const ImpactTemplate* learned, double end_s,
                    double gravity_mps2, WhiteSound& white);

/// Speeds g T / 2 from the flight before each impact; where that is not known, from the one after it over eps.
void set_speeds(double gravity_mps2, std::vector<TimedImpact>& impacts);

/// Marks the impacts at which the recording is at its limit.
void mark_clipped(const BandOfDrops& band, std::vector<TimedImpact>& impacts);

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
