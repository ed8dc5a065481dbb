// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"

namespace bouncelab::fit {

struct RestitutionConfig {
  double gravity_mps2 = kDefaultGravity_mps2;  ///< > 0 [m/s^2]
  std::optional<Ball> ball;                    ///< for its drag and contact time, of which the fit takes account
  std::optional<Material> plate;               ///< likewise
  double air_kgpm3 = Air{}.density_kgpm3;      ///< density of the air, >= 0; 0: none [kg/m^3]
  bool instant_contacts = false;               ///< as in a simulation
  double wave_speed_mps = 2500.0;              ///< of the sound, for the error budget; 343 for a microphone
  /// Height of the ball's lowest point over the plate at release [m], > 0: then the first impact of each drop counts,
  /// v_0 = sqrt(2 g h). Only where impact 0 was detected.
  std::optional<double> drop_height_m;
  /// Standard errors of times and heights that state none, > 0. Absent: their digits are the least, and the fit finds
  /// how much larger they are; a drop height is exact then.
  std::optional<double> sigma_t_s, sigma_height_m;
};
/// What people set: not ball and plate.
Description members_of(const RestitutionConfig*);

/// What became of the onsets.
struct RestitutionCounts {
  std::size_t n_onsets = 0;
  std::size_t n_drops = 0;
  std::size_t n_samples = 0;
  std::size_t n_flagged = 0;         ///< samples that carry a flag; they stay in the table and out of the fit
  std::optional<double> eps_median;  ///< of the samples without a flag; absent where there are none
  /// Places where the chain of one drop was broken, by reason
  std::map<Flag, std::size_t> breaks;
  /// Drops whose flights contradict the height given: their first impact is left out. And the height that these suggest
  /// [m], the median of them.
  std::size_t n_heights_contradicted = 0;
  std::optional<double> height_suggested_m;
};
Description members_of(const RestitutionCounts*);

struct Restitution {
  RestitutionSamples samples;  ///< ordered as the onsets
  RestitutionCounts counts;
};

/// Coefficients of restitution from successive impact times (eq. 2 of the paper), drop by drop.
///
///   eps_i = T_{i+1} / T_i,   v_i = g T_i / 2,   T_i = t_i - t_{i-1}
///
/// Errors to first order from the onsets' own: with s_i the standard error of t_i,
///
///   var eps_i = [ s_{i+1}^2 + (1 + eps)^2 s_i^2 + eps^2 s_{i-1}^2 ] / T_i^2,   var v_i = (g/2)^2 (s_i^2 + s_{i-1}^2)
///
/// absent where one of the three is. Neighbours share onsets: lag one correlates by about -2/3, lag two by +1/6.
///
/// A sample needs three successive impacts. The chain of a drop is broken, there and nowhere else, by an onset
/// flagged `improbable` or `inferred`, by a `doubtful` one without standard error, and by a jump in the column
/// `impact`. An onset flagged `overlap`, `clipped` or, with a standard error, `doubtful` breaks nothing: the detector
/// times it with a standard error of its own, which covers all places where a doubtful one may have been. Where the
/// ratio of two neighbouring intervals leaves the median ratio m of its drop, and the ratio before or after it, by more
/// than a factor sqrt(1 + m), an impact was missed (or one invented) between them: the factor is half-way, on a log
/// scale, to what one missing impact does. Such a sample and its neighbours that share the wrong interval stay in the
/// table, flagged `missing_impact` or `extra_impact`. (Needs at least 5 samples in the drop.)
///
/// These are ratios of intervals: what drag and contact time do to them the fit takes into account (at_the_plate).
/// Nothing is clamped.
/// @param onsets  ordered by recording, drop, time; finite, strictly increasing within a drop [s], and so are their
///                numbers `impact`: 0, 1, 2 ...
/// @throws InvalidArgument where a member of `config` is out of the range that members_of states, a property of the
/// ball
///         is not positive, times or numbers do not increase
Restitution restitution_samples(const Onsets& onsets, const RestitutionConfig& config);

/// Speeds and coefficients at the plate: launch speed of a flight over landing speed of the one before, with the most
/// likely drag and contact time of the ball that is named. Samples of none, and those whose intervals hold neither,
/// stay as they are.
RestitutionSamples at_the_plate(RestitutionSamples samples);
/// The same with what a fit found (Curve). @param kappa_per_m, contact_s  absent: there is none
RestitutionSamples at_the_plate(RestitutionSamples samples, std::optional<double> kappa_per_m,
                                std::optional<double> contact_s);

/// The same of a table in pieces, in the memory that its longest drop needs: the same samples and counts, but for the
/// median of eps, which the caller has to take.
class RestitutionInPieces {
 public:
  /// @throws InvalidArgument as restitution_samples
  explicit RestitutionInPieces(const RestitutionConfig& config);
  /// The next onsets, cut anywhere. @return samples of the drops that have ended
  RestitutionSamples add(Onsets onsets);
  /// After the last onsets. @return samples of the last drop
  RestitutionSamples finish();
  /// Once finished; without eps_median.
  const RestitutionCounts& counts() const { return counts_; }

 private:
  void end_drop(RestitutionSamples& samples);

  RestitutionConfig config_;
  SampleConditions conditions_;
  Onsets drop_;  // as far as it has come
  RestitutionCounts counts_;
  std::vector<double> heights_m_;  // that drops suggest against the one given
};

/// The interval after one impact: measured, and as a law predicts it from the interval before.
struct IntervalPrediction {
  std::int64_t impact = 0;
  double measured_s = 0.0;            ///< eps T, with the eps of the sample
  std::optional<double> predicted_s;  ///< eps(v) T, with that of the law; absent without a law
  std::optional<double> sigma_s;  ///< standard error of measured_s from the timing; absent where the sample has none
};
Description members_of(const IntervalPrediction*);

/// T_{k+1} = eps T_k with T_k = 2 v / g, for the samples of one drop.
/// @param gravity_mps2  > 0, as the samples were made with
/// @return in the order of the samples
std::vector<IntervalPrediction> predict_intervals(const RestitutionSamples& samples, const std::string& recording,
                                                  std::int64_t drop, const std::optional<RestitutionLaw>& law,
                                                  double gravity_mps2);

/// Samples that were left out, by reason: how many, and the number of the first, from 1.
struct LeftOut {
  std::map<std::string, std::size_t> n, first;
};

/// Samples without those that are left out: a copy only where there are such, since a sample is some hundred bytes.
class PartOfSamples {
 public:
  /// @param all       must outlive this
  /// @param left_out  indices, increasing
  PartOfSamples(const RestitutionSamples& all, const std::vector<std::size_t>& left_out);
  const RestitutionSamples& operator*() const { return part_ ? *part_ : all_; }
  const RestitutionSamples* operator->() const { return &**this; }

 private:
  const RestitutionSamples& all_;
  std::optional<RestitutionSamples> part_;
};

/// Those without a flag, finite, with v > 0 and flights longer than the contacts of a named ball, in their order.
/// @param samples  must outlive the result
PartOfSamples usable_samples(const RestitutionSamples& samples, LeftOut& left_out);

}  // namespace bouncelab::fit
