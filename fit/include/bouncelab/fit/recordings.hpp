// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/fit/curve.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// What a difference between recordings is measured by.
enum class WithinUnit {
  samples,     ///< by the scatter of the samples, as if all were independent: there are too few drops
  drops,       ///< by how the drops within the recordings differ: holds also where impacts of a drop go together
  recordings,  ///< of plates some of whose recordings disagree: by how the recordings within the plates differ
};
/// The words of fit.json: "samples", "drops", "recordings".
const char* to_string(WithinUnit unit);

/// Do several recordings follow one curve? An analysis of variance by weighted least squares, of one curve with a
/// constant of eps for each recording (S1), for each drop (S2), or for none (S0), S what is left:
///
///   F = (S0 - S1) / ndf : S1 / ndf_within          samples
///   F = (S0 - S1) / ndf : (S1 - S2) / ndf_within   drops, recordings
///
/// Weights are the inverse variances that the pooled fit and the timing give; a recording's own outliers are left out.
/// For normal scatter F is exact, also where samples are few.
struct RecordingsTest {
  std::size_t n_recordings = 0;   ///< compared: those of three samples or more
  double likelihood_ratio = 0.0;  ///< n ln(S0 / S1), twice the difference of the log-likelihoods of normal scatter
  double f = 0.0;                 ///< F by ndf and ndf_within degrees of freedom if all recordings follow one curve
  double ndf = 0.0, ndf_within = 0.0;
  double p_value = 1.0;
  WithinUnit within = WithinUnit::samples;  ///< drops from ten degrees of freedom between drops on
};
Description members_of(const RecordingsTest*);

/// The recordings of one plate against the curve of the plate.
struct WithinPlate {
  RecordingsTest test;
  std::vector<NamedEstimate> offsets;  ///< of each recording's eps
};

/// One recording alone.
struct RecordingFit {
  std::string recording;
  std::size_t n_drops = 0;
  double v_lo_mps = 0.0, v_hi_mps = 0.0;  ///< of its samples
  std::vector<CurveNode> nodes;        ///< of its own curve: at the nodes of all within its speeds, else their middle
  std::vector<ReleaseHeight> heights;  ///< of its drops, see Curve
  std::vector<NamedEstimate> parameters;  ///< constants as they are stated: see Constants
  bool with_memory = false;
  LawFit law;
  std::optional<Estimate> offset;        ///< of its eps from the curve of all, mean over all samples 0; by the test
  std::optional<WithinPlate> within;     ///< of a plate with several recordings
  std::vector<HistogramFit> histograms;  ///< of its samples about its law; none of more than 100 recordings
};
Description members_of(const RecordingFit*);

/// Recording -> plate. Where there are some, a row is all recordings of a plate, or a recording without one.
using Plates = std::map<std::string, std::string>;

struct Recordings {
  std::optional<RecordingsTest> test;  ///< absent where fewer than two recordings can be compared
  std::vector<RecordingFit> rows;      ///< in order of appearance; empty where there is one recording
  Plates plates;
};

/// The samples of each row, in order of appearance, with its name.
std::vector<std::pair<std::string, RestitutionSamples>> by_row(const RestitutionSamples& samples, const Plates& plates);

/// The rows and the test. Of more than 100 recordings the rows' intervals are by covariance and, from 30 samples on,
/// the scatter goes as a power of v: they take a third of the time.
/// @param samples  finite, v > 0: those of the pooled fit with its outliers, which may be all of one recording
/// @param config   of the pooled fit; its replicates and comparisons are not made again
/// @param pooled   that fit: nodes, form of the scatter
/// @param windows  of the rows' histograms; none of plates, which are fitted as alone afterwards
Recordings compare_recordings(const RestitutionSamples& samples, const LawFitConfig& config, const LawFit& pooled,
                              const HistogramConfig& windows = {}, const Plates& plates = {});

/// Slopes and peak of p(eps): a row for each fitted window of all samples, then of each recording.
/// @param all  windows of all; empty where they are of no one ball
Table slope_table(const std::vector<HistogramFit>& all, const Recordings& recordings);

inline constexpr double kDoubt = 0.01;  ///< p below: they do not follow one curve
bool disagree(const Recordings& recordings);
/// Do the recordings of a plate?
bool disagree_within(const RecordingFit& plate);

/// Drops that are of two balls, or on two floors.
struct KindsOfDrops {
  std::size_t n_lower = 0, n_upper = 0;
  double eps_lower = 0.0, eps_upper = 0.0;  ///< medians of their samples
};
Description members_of(const KindsOfDrops*);

/// Drops fall into two kinds where, at one speed, their medians of eps do: into two groups of at least two drops, each
/// narrower than a third of the gap between them, which is more than three times the scatter about the medians, three
/// times what their slope with speed is not known by, and a tenth of 1 - eps, and where the test of recordings, made of
/// the two groups, has p < 0.01. Two drops are a group each. Drops of one ball on one floor differ by
/// less than single impacts do; what differs by less is in the errors by drop.
/// @param samples  finite, v > 0
std::optional<KindsOfDrops> two_kinds_of_drops(const RestitutionSamples& samples);

/// A drop that has the bounces of another: the same one twice, in copies of a recording or under another number.
struct RepeatedDrop {
  std::string recording, of_recording;
  std::int64_t drop = 0, of_drop = 0;
  std::size_t n_bounces = 0;  ///< that both have
};

/// Drops of which four bounces or more, and four fifths of the shorter drop's, have speed and eps of bounces of another
/// drop to within a tenth of what eps scatters: two drops that are two have less than one such bounce in twenty. None
/// where the timing makes half of the scatter.
/// @param samples  finite, v > 0
std::vector<RepeatedDrop> repeated_drops(const RestitutionSamples& samples);

}  // namespace bouncelab::fit
