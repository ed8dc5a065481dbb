// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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
#include "bouncelab/fit/curve.hpp"
#include "bouncelab/fit/estimate.hpp"

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

/// Recordings are compared at the speeds of the series R10 (ISO 3), ten a decade: 0.5, 0.63, 0.8, 1, 1.25 m/s and so
/// on.
/// @param k  any: 10^(k/10) m/s, rounded as the series does
double comparison_speed_mps(int k);

/// What is kept of a recording when its samples are let go: eps at the speeds of comparison.
struct RecordingSummary {
  std::string recording;
  std::size_t n = 0;           ///< samples fitted
  std::size_t n_drops = 0;     ///< of the usable samples
  std::size_t n_left_out = 0;  ///< flagged, not finite, or at no positive speed
  std::size_t n_outliers = 0;  ///< more likely lost bounces than scatter
  double scatter = 0.0;        ///< mean distance of eps from eps(v) at the middle of its speeds
  /// `ok`: there are nodes; otherwise `why` not.
  FitStatus status = FitStatus::too_few_samples;
  std::optional<Note> why;
  /// eps (root mean square over bounces, as that of Curve) with its standard error at each speed of comparison that its
  /// samples reach, rising.
  std::vector<NodeEstimate> nodes;
};

/// Samples fewer than these, without those left out, have no curve with an error that could be relied on.
inline constexpr std::size_t kFewestOfASummary = 8;

/// By weighted least squares: the mean of eps as a polynomial in ln v, of the third degree where the speeds span a
/// factor two, of the fourth from a factor four on. Unlike the smooth curve (Curve) it has no prior, which the means of
/// thousands of recordings would share. Weights are those of the fitted scatter. Errors are by drop from 30 drops on:
/// with fewer they are those of independent samples, and what impacts of a drop share counts as a difference between
/// recordings.
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
  double middle = 0.0;            ///< the mean, to which the pooled eps belongs
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
  /// Mean offset from the pooled eps at the reference speed, with the error that the recordings' errors and their
  /// standard deviation tau give; of plates the drift, of days the plates are taken out, of days the drift is not.
  double offset = 0.0, se = 0.0;
};
Description members_of(const GroupRow*);
struct Grouping {
  GroupEffect effect = GroupEffect::none;
  std::optional<StandardDeviation> deviation;  ///< where the effect is random
  std::vector<GroupRow> rows;                  ///< in order of name
};
Description members_of(const Grouping*);

/// Plates whose recordings do not scatter alike, each about its own line in time, as one tau for all takes them to:
/// Bartlett's test by the residuals, p < 0.01.
struct UnequalScatter {
  std::string widest, narrowest;               ///< plates
  double sd_widest = 0.0, sd_narrowest = 0.0;  ///< of eps between their recordings, with the recordings' own errors
  double p_value = 1.0;
};

/// eps of one of several groups, of its recordings alone.
struct GroupRestitution {
  std::string name;    ///< the plate, or the recording
  std::size_t n = 0;   ///< recordings used, outliers left out; of single recordings their drops
  double v_mps = 0.0;  ///< one speed of `nodes`, the same for all groups
  Estimate eps;        ///< there; in the middle of the campaign, as `BetweenRecordings::eps`
  /// Of one more recording (drop) of the group as it would be measured there, with such errors as the others have;
  /// absent where there is one of each.
  std::optional<Interval> prediction95;
  std::vector<NodeEstimate> nodes;  ///< at the speeds of comparison that it reaches
};
Description members_of(const GroupRestitution*);

/// A recording against the others, at the reference speed.
struct RecordingRow {
  std::optional<Note> why_not;  ///< why it is not used; absent: it is
  double eps = 0.0, se = 0.0;   ///< of the recording alone
  double offset = 0.0;          ///< from the pooled eps
  double standardised = 0.0;    ///< off what the other recordings predict of it, over the error of that
  double p_value = 1.0;         ///< of so large a standardised offset in any of all recordings, at most 1
  bool is_outlier = false;      ///< p < 0.05
};

/// What differs within a group, by which differences between groups are judged.
enum class GroupUnit { drops, recordings };
/// "drops", "recordings"
const char* to_string(GroupUnit unit);

/// A group less the reference. Errors and intervals include what differs within the groups.
struct GroupDifference {
  std::string reference, group;
  double v_mps = 0.0;             ///< one of `nodes`
  Estimate eps;                   ///< the difference there
  double ndf = 0.0;               ///< of Student's t; 0: how units of a group differ is not known
  double detectable = 0.0;        ///< a difference there that such data show in four of five experiments
  std::optional<double> p_value;  ///< of a difference there so large by chance; absent: ndf = 0
  std::vector<NodeEstimate> nodes;
};
Description members_of(const GroupDifference*);

/// Do groups differ by more than the recordings (or drops) within them do? The difference of two plates is that of the
/// mixed model, with the error that their means have together: the drift which all share moves plates apart that were
/// measured one after the other. That of two recordings is that of their curves, half widths of intervals in
/// quadrature. p, at the middle one of the speeds that all share, is times the number of pairs.
struct GroupDifferences {
  std::optional<Note> why;  ///< why there are no rows; absent where there are
  GroupUnit unit = GroupUnit::drops;
  std::vector<GroupRestitution> groups;
  std::vector<GroupDifference> rows;  ///< every pair
  /// Some pair has p < 0.05, or none has a p: the groups are not known to have one eps.
  bool differ = false;
};
Description members_of(const GroupDifferences*);

/// One speed of a campaign.
struct CampaignNode {
  double v_mps = 0.0;
  std::size_t n = 0;      ///< recordings that reach it
  Estimate eps;           ///< its error includes tau
  Interval prediction95;  ///< of one more recording, as it would be measured
};
Description members_of(const CampaignNode*);

/// What many recordings say together: eps, how much the recordings differ, drift, outliers. All but `nodes` is at the
/// reference speed: that of comparison which most recordings reach, and of several the middle one.
struct BetweenRecordings {
  FitStatus status = FitStatus::too_few_samples;
  std::optional<Note> why;
  std::size_t n_recordings = 0, n_used = 0, n_outliers = 0;  ///< outliers are among the used, and not in the pool
  std::size_t n_samples = 0;                                 ///< fitted, of the recordings used
  double v_mps = 0.0;                                        ///< the reference speed
  Estimate eps;
  Interval prediction95;
  std::vector<CampaignNode> nodes;  ///< speeds that half as many recordings reach, or more
  StandardDeviation tau;            ///< between recordings of one plate and day
  ChiSquareTest heterogeneity;      ///< is tau 0, and is there no drift and no group?
  std::optional<Drift> drift;
  Grouping plates, days;
  std::optional<UnequalScatter> unequal_scatter;
  /// Of plates with several recordings, else (see compare_groups) of few recordings. Where they differ, eps, prediction
  /// and nodes of all are those of none.
  std::optional<GroupDifferences> differences;
  std::vector<RecordingRow> rows;  ///< as the recordings were given
  std::vector<Note> notes;

  bool groups_differ() const { return differences && differences->differ; }
};
/// Status and message apart, which stand before the answer.
Description members_of(const BetweenRecordings*);

/// Recordings needed for a pooled eps with a standard deviation between them.
inline constexpr std::size_t kFewestPooled = 4;

/// Recordings as a mixed linear model, at each speed by itself: a common eps, a straight line in time, an offset of the
/// plate and of the day, an offset of the recording's own of standard deviation tau, and the error of the recording:
///
///   eps_r = eps + slope (t_r - middle) + plate + day + u_r + e_r,   var u_r = tau^2
///
/// eps and slope by generalised least squares; standard deviations by restricted maximum likelihood (Patterson &
/// Thompson, doi:10.1093/biomet/58.3.545); errors of eps and slope include them, with Student's t by Satterthwaite's
/// degrees of freedom (Fai & Cornelius, doi:10.1080/00949659608811740) and never below what the residuals say (Knapp &
/// Hartung, Stat. Med. 22, 2693 (2003), doi:10.1002/sim.1482). Outliers are judged at the reference speed by the model
/// without them, at 5 % for all recordings together, and left out at all speeds. Takes about as long for each recording
/// whatever their number.
///
/// Assumes: offsets are normal but for the outliers, and the errors of the recordings are known.
BetweenRecordings compare_campaign(const std::vector<CampaignRecording>& recordings);

/// comparison.csv: a row a recording, with what its group has where groups differ.
Table to_table(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings);

inline constexpr std::size_t kMostGroups = 4;

/// Recordings with their drops as units, each by its smooth curve (Curve) at the speeds of comparison that all share.
/// With one drop in each there is no p.
/// @param groups  2 to kMostGroups, each a name and its usable samples (no flag, finite, v > 0) at the plate
GroupDifferences compare_groups(const std::vector<std::pair<std::string, RestitutionSamples>>& groups);

/// Below any error of eps: a search for a standard deviation that is 0 ends here.
inline constexpr double kLeastDeviation = 1e-6;

}  // namespace bouncelab::fit
