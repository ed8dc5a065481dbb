// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// When a recording was made.
struct RecordingDate {
  double day = 0.0;               ///< days since 1970-01-01 00:00; noon where no time was given
  std::int64_t calendar_day = 0;  ///< the day as it was written, days since 1970-01-01
};

/// A date, or a date and a time, as ISO 8601 writes them: 2026-11-23, 2026-11-23T14:05, 2026-11-23 14:05:30.5,
/// 20261123T140530; with Z or +01:00 behind the time `day` is that of UTC, else as written.
/// @return absent where the text is anything else, or no day of the calendar between 1990 and 2100
std::optional<RecordingDate> date_from_iso(std::string_view text);

/// The last date in a name of a file: YYYY-MM-DD, YYYY_MM_DD or YYYYMMDD, without a digit before it; a time may follow
/// at once or after a T, an underscore, a hyphen, a point or a blank, as HHMM, HHMMSS, HH-MM or HH-MM-SS; between its
/// numbers also a colon, a point, an underscore or an h. What follows and is no time of day is passed over (a counter
/// 0012 is taken for 00:12).
/// @return absent where there is no day of the calendar between 1990 and 2100
std::optional<RecordingDate> date_in_name(std::string_view name);

/// "2026-11-23"
std::string day_in_words(std::int64_t calendar_day);

/// "2026-11-23T14:05:30": the time of `day`, to the second.
std::string iso_in_words(const RecordingDate& date);

/// What is kept of a recording when its samples are let go: values of its own law eps(v) with their covariance. Three
/// of them within its speeds are sufficient for the three constants of the law.
struct RecordingSummary {
  std::string recording;
  std::size_t n = 0;           ///< samples fitted
  std::size_t n_drops = 0;     ///< of the usable samples
  std::size_t n_left_out = 0;  ///< flagged, not finite, or at no positive speed
  std::size_t n_outliers = 0;  ///< more likely lost bounces than scatter
  double scatter = 0.0;        ///< mean distance of eps from eps(v) at the middle of its speeds
  /// `ok`: v, eps and covariance are there; otherwise `why` not.
  FitStatus status = FitStatus::too_few_samples;
  std::optional<Note> why;
  std::size_t n_nodes = 0;  ///< 3; 1 where its speeds differ by less than a fifth
  std::array<double, 3> v_mps{}, eps{};
  std::array<std::array<double, 3>, 3> covariance{};
};

/// Samples fewer than these, without those left out, have no law with an error that could be relied on.
inline constexpr std::size_t kFewestOfASummary = 8;

/// By fit_law with errors by covariance. Errors are by drop from 30 drops on: the covariance of three values from M
/// drops, inverted, is wrong by about 3/M. With fewer they are by sample, or where samples are fewer than 30 a
/// parameter those of the fitted scatter; what impacts of a drop share then counts as a difference between recordings.
/// @param samples  all of one recording, of at least one sample
RecordingSummary summarize_recording(const RestitutionSamples& samples);

/// Where and when a recording was made, as far as it is known.
struct RecordingOrigin {
  std::string plate;  ///< empty: not known
  std::optional<RecordingDate> date;
};

struct CampaignRecording {
  RecordingSummary summary;
  RecordingOrigin origin;
};

/// How much eps differs from recording to recording, or from group to group, beyond the errors of each.
struct StandardDeviation {
  double value = 0.0;
  Interval ci95;  ///< by the profile of the restricted likelihood
};
Description members_of(const StandardDeviation*);

/// eps over the campaign, as a straight line.
struct Drift {
  bool by_date = true;  ///< false: too few dates are known, and the recordings are taken in their order
  Estimate slope;       ///< of eps per day, or per recording
  double p_value = 1.0;
  double begin = 0.0, end = 0.0;  ///< of the campaign: days since 1970-01-01, or 0 and the number of the last recording
  double middle = 0.0;            ///< the mean, to which the pooled law belongs
};
Description members_of(const Drift*);

enum class GroupEffect {
  none,    ///< not in the model: why, is in the notes
  fixed,   ///< two to four groups: a constant for each, their mean 0
  random,  ///< a standard deviation between groups: from five on, where five recordings are not the first of theirs
};
const char* to_string(GroupEffect effect);

/// The recordings of one plate, or of one day.
struct GroupRow {
  std::string name;
  std::size_t n = 0;  ///< recordings used, outliers left out
  /// Mean offset from the pooled law of the whole, with the error that the recordings' errors and their standard
  /// deviation tau give; of plates (BetweenRecordings::of_plates) the drift, of days the plates are taken out, of days
  /// the drift is not.
  double offset = 0.0, se = 0.0;
};
Description members_of(const GroupRow*);
struct Grouping {
  GroupEffect effect = GroupEffect::none;
  std::optional<StandardDeviation> deviation;  ///< where the effect is random
  std::vector<GroupRow> rows;                  ///< in order of name
};
Description members_of(const Grouping*);

/// eps of one of several groups that differ, of its recordings alone.
struct GroupRestitution {
  std::string name;    ///< the plate, or the recording
  std::size_t n = 0;   ///< recordings used, outliers left out; of single recordings their drops
  double v_mps = 0.0;  ///< the speed, one for all groups
  Estimate eps;        ///< in the middle of the campaign, as `BetweenRecordings::eps`
  /// Of one more recording (drop) of the group as it would be measured, with such errors as the others have; absent
  /// where there is one of each.
  std::optional<Interval> prediction95;
};
Description members_of(const GroupRestitution*);

/// A recording against the others.
struct RecordingRow {
  bool is_used = false;        ///< its own law has values; if not, the summary has why
  double eps = 0.0, se = 0.0;  ///< at the reference speed, by the pooled law's shape; error of the recording
  double offset = 0.0;         ///< from the pooled law
  double standardised = 0.0;   ///< off what the other recordings predict of it, over the error of that
  double p_value = 1.0;        ///< of so large a standardised offset in any of all recordings, at most 1
  bool is_outlier = false;     ///< p < 0.05
};

/// What many recordings say together: the pooled law, how much the recordings differ, drift, outliers.
struct BetweenRecordings {
  FitStatus status = FitStatus::too_few_samples;
  std::optional<Note> why;
  std::size_t n_recordings = 0, n_used = 0, n_outliers = 0;  ///< outliers are among the used, and not in the pool
  std::size_t n_samples = 0;                                 ///< fitted, of the recordings used
  LawKind kind = LawKind::series;
  double v_mps = 0.0;                     ///< the reference speed
  Estimate eps;                           ///< of the pooled law there; its error includes tau
  Interval prediction95;                  ///< of one more recording there, as it would be measured
  std::vector<NamedEstimate> parameters;  ///< A2, A4, A5; fewer where the speeds do not determine them
  Matrix correlation;                     ///< of `parameters`
  std::vector<NodeEstimate> nodes;
  std::vector<CurvePoint> curve;  ///< with the 95 % band of the pooled law
  std::vector<Interval> curve_prediction95;
  StandardDeviation tau;        ///< between recordings of one plate and day
  ChiSquareTest heterogeneity;  ///< is tau 0, and is there no drift and no group?
  ChiSquareTest shapes;         ///< do the recordings' curves differ by constants only?
  std::optional<Drift> drift;
  Grouping plates, days;
  std::vector<GroupRestitution> of_plates;  ///< each, whether they differ or not
  /// differing_groups(): where there are some, eps, prediction and constants of the pooled law are those of none.
  std::vector<GroupRestitution> groups;
  std::vector<RecordingRow> rows;  ///< as the recordings were given
  std::vector<Note> notes;
};
/// Status and message apart, which stand before the answer.
Description members_of(const BetweenRecordings*);

/// Recordings needed for a pooled law with a standard deviation between them.
inline constexpr std::size_t kFewestPooled = 4;

/// Recordings as a mixed linear model: each has the pooled law, a straight line in time, an offset of its plate and its
/// day, an offset of its own of standard deviation tau, and the errors of its own law:
///
///   eps_r(v) = eps(v; A) + slope (t_r - middle) + plate + day + u_r,   var u_r = tau^2
///
/// A and slope by generalised least squares; standard deviations by restricted maximum likelihood (Patterson &
/// Thompson, doi:10.1093/biomet/58.3.545); errors of A and slope include them, with Student's t by Satterthwaite's
/// degrees of freedom (Fai & Cornelius, doi:10.1080/00949659608811740) and never below what the residuals say (Knapp &
/// Hartung, Stat. Med. 22, 2693 (2003), doi:10.1002/sim.1482). Where the recordings' curves differ in shape by more
/// than their errors, these are widened by Birge's ratio. Outliers are judged by the model without them, at 5 % for all
/// recordings together, and left out of it. Takes about as long for each recording whatever their number.
///
/// Assumes: offsets are normal but for the outliers, the errors of the recordings' own laws are known, and a recording
/// differs from the others by a constant.
BetweenRecordings compare_campaign(const std::vector<CampaignRecording>& recordings);

/// comparison.csv: a row a recording, with what its group has where groups differ.
Table to_table(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings);

/// What differs within a group, by which differences between groups are judged.
enum class GroupUnit { drops, recordings };
/// "drops", "recordings"
const char* to_string(GroupUnit unit);

/// The law of one group (the recordings of a plate, or one recording) at speeds common to all groups. Its errors are
/// those of independent samples.
struct GroupLaw {
  std::string name;
  std::size_t n = 0;  ///< samples fitted
  std::size_t n_units = 0;
  std::vector<NodeEstimate> nodes;
  std::vector<NamedEstimate> parameters;
};
Description members_of(const GroupLaw*);

/// A group less the reference. Errors and intervals include what differs within the groups.
struct GroupDifference {
  std::string reference, group;
  Estimate offset;                ///< of eps, as a constant at all speeds
  double detectable = 0.0;        ///< an offset that such data show in four of five experiments
  std::optional<double> p_value;  ///< of so large an offset by chance, times the number of pairs; absent: ndf = 0
  std::vector<NodeEstimate> nodes;
  std::vector<NamedEstimate> parameters;
};
Description members_of(const GroupDifference*);

struct GroupDifferences {
  std::optional<Note> why;  ///< why there are no rows; absent where there are
  GroupUnit unit = GroupUnit::drops;
  double ndf = 0.0;                 ///< units less groups; 0: how units of a group differ is not known
  std::optional<double> deviation;  ///< of eps between units of a group, standard deviation; 0: none seen
  std::vector<GroupLaw> groups;
  std::vector<GroupRestitution> alone;  ///< of each group, at the middle node
  std::vector<GroupDifference> rows;    ///< every pair
};
Description members_of(const GroupDifferences*);

inline constexpr std::size_t kMostGroups = 4;

/// Do groups differ by more than the drops (or recordings) within them do? By the table of RecordingsTest: a mean of
/// eps for each group about one curve (S1), for each unit (S2), samples weighted by their inverse variances,
///
///   q = (S1 - S2) / (units - groups),   variance of an offset = q times that of independent samples, q at least 1,
///
/// and the offset of two groups over its root is Student's t with units - groups degrees of freedom. tau, by which
/// units differ beyond the scatter, by moments (DerSimonian & Laird, doi:10.1016/0197-2456(86)90046-2). What differs
/// within the groups enters the errors of nodes and constants as a constant offset of eps. The offset is of the means,
/// nodes and constants are those of the laws, of the peak.
///
/// The unit is the recording where some group has several, else the drop. With one unit in each group errors are those
/// of independent samples and there is no p.
/// @param groups  2 to kMostGroups, each a name and its usable samples (no flag, finite, v > 0)
GroupDifferences compare_groups(const std::vector<std::pair<std::string, RestitutionSamples>>& groups);

/// Below any error of eps: a search for a standard deviation that is 0 ends here.
inline constexpr double kLeastDeviation = 1e-6;

/// eps by group; empty where groups are not seen to differ. They differ where some pair of `differences` has p < 0.05,
/// or one recording (drop) each, so that it is not known. Without differences (five plates, a hundred recordings) where
/// the standard deviation between plates leaves 0 out, or two plates are three standard errors apart.
std::vector<GroupRestitution> differing_groups(const BetweenRecordings& between,
                                               const std::optional<GroupDifferences>& differences);

}  // namespace bouncelab::fit
