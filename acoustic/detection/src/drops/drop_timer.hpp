// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/detection/detect.hpp"
#include "candidates/candidates.hpp"
#include "contact/contact_time.hpp"
#include "delay/timed_impact.hpp"
#include "model_number.hpp"
#include "template/impact_template.hpp"
#include "tracking/tracker.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {

/// The numbers of drops, of their overlapping impacts and of the bands they are timed in (docs/detector.md, "Times").
struct DropsModel {
  double sigma_of_reach = 0.25;   ///< standard error of a candidate's time over its reach, where there is no template
  std::size_t own_template = 12;  ///< impacts from which a drop has a template of its own, with noise 11 dB down
  double little_move = 0.2;       ///< standard errors, by which the last round of a separation moves no impact
  double clearly_less = 0.5;      ///< of the error in a low band, which a whole band's must be to be taken

  // alignment of templates
  std::ptrdiff_t bins_of_shape = 8;  ///< of the spectrum, some 350 Hz, in which few modes sound
  std::ptrdiff_t most_shapes = 2;    ///< that the templates are sums of there; no more than half as many as templates

  // impacts of a drop that only another band shows
  std::size_t fewest_shared = 5;   ///< impacts that both bands have
  double most_delay_s = 8e-3;      ///< of one band's times against another's: a quarter of a cycle at 30 Hz
  double same_of_interval = 0.25;  ///< nearer to an impact than that part of the intervals beside it is the same one
  std::size_t nearest_shared = 9;  ///< that give the delay
  double least_of_flight = 0.5;    ///< nearer to its neighbours than that is another place of theirs
};

BOUNCELAB_MODEL DropsModel kDrops;

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
  std::optional<ContactFit> contact;
  double reference_scaling = 0.0;   ///< v^(-1/5) of its strongest impacts
  double correlation = 0.0;         ///< of its template with the impacts
  std::optional<LearnedWave> wave;  ///< its template as recorded
  std::optional<double> rms_hz;     ///< of the impacts as recorded
  double noise_variance = 0.0;      ///< in the band that it is timed in
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

/// Joint estimation of impacts whose sounds overlap: the amplitudes of all by linear least squares (Ringing), then
/// the time of each flagged one with the sound of the others subtracted; in turns, until none moves by a fifth of its
/// standard error.
/// @param impacts  of one track, in time order
/// @return whether there were any
bool separate_overlaps(WhiteSound& white, const ImpactTemplate& learned, std::vector<TimedImpact>& impacts);

/// Adds to a drop the impacts that only another band of the same sound shows: one band may hide in echoes, in clutter
/// or in a codec's noise what another shows, above all at the end of a drop, and which of them was selected says
/// nothing of the ball.
///
/// The two are the same drop where they share five impacts and half of those of the shorter one. Impacts of the other
/// band whose numbers the drop lacks are added, with times moved by the median difference of the nine nearest shared
/// impacts, whose error enters `sigma_s`; where the two bands number the shared impacts on either side differently,
/// none is. One that the drop has elsewhere is put there where its error is half as large. What the other band has by
/// prediction alone is added only where its template explains half of the impacts' energy and that of the drop does
/// not, which else would have shown it. Sets no speeds.
/// @param begin_s, end_s  the last impact of the drop before and the first of the next one: none is added beyond
/// @return how many were added
std::size_t add_impacts_of_other_band(const TimedDrop& other, double begin_s, double end_s, TimedDrop& drop);

struct TimedRecording {
  Onsets onsets;
  std::optional<LearnedWave> wave;  ///< of the longest track
  bool is_full_band = true;  ///< timed in the sound as recorded, though the impacts may have been found in a band
  std::optional<double> contact_time_at_1_mps_s;
  std::optional<double> contact_time_sigma_s;
};

/// Times all tracks. Each of a dozen impacts or more has a template of its own, since each drop strikes the plate at
/// another place; shorter ones share that of the recording. What was found in a low band is timed in the whole sound
/// where that halves the errors. The contact-time law is pooled over all drops: one ball.
/// What other bands show of the same drops is added (add_impacts_of_other_band).
/// @param band         the one that was selected
/// @param other_bands  of the same sound, with tracks of their own
/// @param n_threads    that time tracks; the bands' sounds may be read by so many
/// @param name         goes into the column `recording`
TimedRecording time_recording(const BandOfDrops& band, const std::vector<BandOfDrops>& other_bands, double gravity_mps2,
                              int n_threads, const std::string& name);

}  // namespace bouncelab::detection
