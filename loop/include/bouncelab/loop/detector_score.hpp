// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab::loop {

/// True impact times of one recording.
struct TrueTimes {
  Onsets onsets;                ///< sigma_t_s is the Cramer-Rao bound of the time, where it is known
  std::vector<double> v_mps{};  ///< speeds of impact, as many as onsets; empty: not known
};

/// Columns of a table of true times: onset_columns(), and of one that synthesize wrote `v_mps` and `travel_time_s`.
std::vector<ColumnSpec> true_time_columns();
/// A detector finds the sound, so its true time is t_s + travel_time_s.
/// @param name  of the file, for messages. @throws FileError as onsets_from_table
TrueTimes true_times_from_table(const Table& table, const std::string& name);

/// True and marked times that belong together.
struct Agreement {
  std::size_t n_true = 0, n_marked = 0, n_found = 0;

  std::optional<double> precision() const;  ///< absent where nothing was marked
  std::optional<double> recall() const;     ///< absent where there is no true time
  /// Harmonic mean of precision and recall, 2 n_found / (n_true + n_marked). Absent where there are neither.
  std::optional<double> f_measure() const;
};

/// Tolerances of DetectorScore::agreement [s].
inline constexpr std::array<double, 4> kTolerances_s{50e-3, 5e-3, 1e-3, 0.1e-3};
/// Of these: the pairs whose errors are scored, so that jitter and recall are of the same ones.
inline constexpr std::size_t kJitterTolerance = 1;

/// How well times that any onset detector marked agree with the true ones: one recording, or several pooled.
/// docs/validation.md has the definitions. A value is absent where there is nothing to take it from.
struct DetectorScore {
  std::size_t n_recordings = 1;
  /// Within 50 ms of the times as marked, matched for the most pairs as mir_eval and MIREX do; within 5, 1 and 0.1 ms
  /// about `offset_s`, nearest pairs first.
  std::array<Agreement, kTolerances_s.size()> agreement;
  /// For each true time the index of its mark, where there is one within 5 ms; of several recordings one after the
  /// other.
  std::vector<std::optional<std::size_t>> match;
  // of these pairs, three at least but for the offset; of several recordings the median of each
  std::optional<double> offset_s;   ///< median of marked less true: a latency, which cancels in intervals
  std::optional<double> jitter_s;   ///< root mean square of marked less true, less the offset
  std::optional<double> typical_s;  ///< 1.4826 times the median of their sizes: a standard deviation without outliers
  std::optional<double> within_law_s;  ///< the same less a + b v^(-1/5), where in the contact an onset is marked
  /// The same with a constant a for each drop, which cancels in intervals too; b is 0 where speeds are not known.
  std::optional<double> within_drops_s;
  std::optional<double> bound_s;                   ///< root mean square of the Cramer-Rao bounds of the impacts found
  std::optional<double> bound_ratio;               ///< within_law_s, else jitter_s, over the bound
  std::optional<double> bound_ratio_within_drops;  ///< within_drops_s over the bound
  std::optional<double> eps_error;  ///< root mean square error of eps = T_(k+1)/T_k of three neighbours found
  // stated errors: intervals between neighbours found, less that law; pooled over recordings
  std::size_t n_stated = 0;                    ///< intervals of which both standard errors are stated
  std::size_t n_covered = 0;                   ///< whose error is within 1.96 of them
  double sum_pull2 = 0.0;                      ///< of (error / standard error)^2
  std::optional<double> largest_pull;          ///< size of the largest error / standard error
  double sum_log_score = 0.0;                  ///< of log_score()
  double without_ball_s = 0.0;                 ///< length of recordings in which nothing strikes [s]
  std::size_t n_invented = 0;                  ///< marks in them
  double duration_s = 0.0, processor_s = 0.0;  ///< of the recordings, and of the detector on them

  std::optional<double> pull() const;      ///< root mean square, 1 where stated errors are right
  std::optional<double> coverage() const;  ///< of 95 % intervals
  /// Mean of -ln(sigma / 1 us) - error^2 / (2 sigma^2) [nats]: largest where errors are small and stated as they are
  /// (Gneiting and Raftery 2007, doi:10.1198/016214506000001437). Beyond 5 sigma, sigma counts as error / 5: an outlier
  /// costs no more than that, and nothing is gained by a smaller sigma.
  std::optional<double> log_score() const;
  std::optional<double> invented_per_hour() const;
  std::optional<double> times_real_time() const;
};
Description members_of(const DetectorScore*);

/// @param marked       with a standard error where the detector states one
/// @param duration_s   of the recording
/// @param processor_s  that the detector took; 0: not known
DetectorScore score_detector(const TrueTimes& truth, const Onsets& marked, double duration_s, double processor_s);

/// Sums of counts, medians of the rest. @param scores  at least one
DetectorScore pooled(const std::vector<DetectorScore>& scores);

}  // namespace bouncelab::loop
