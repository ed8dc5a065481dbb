// SPDX-License-Identifier: GPL-3.0-or-later
/// What a user should know beside a result. Whoever finds it says what it is, with its numbers; the module `report`
/// alone makes words of it, orders, cuts and withholds by kind and severity.
#pragma once

#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"

namespace bouncelab {

enum class Severity {
  no_answer,  ///< there is no answer because of it
  warning,    ///< it may make another answer
  detail      ///< some ask for it
};
/// The words of fit.json: "no_answer", "warning", "detail".
const char* to_string(Severity severity);

/// Of two notes of one severity that of the kind that stands first here is told first. The comments are the numbers, in
/// their order, and behind a semicolon the subject.
enum class NoteKind {
  // what was heard
  no_ball_likely,       ///< odds, begin [s]
  silence,              ///<
  no_three_bounces,     ///< sounds that rise
  sounds_not_of_ball,   ///< sounds that rise
  drops_too_short,      ///< drops, least impacts
  recording_left_out,   ///< ; why
  doubtful_drops,       ///< drops, of drops, odds; where
  contradicted_height,  ///< stated [m], drops, of drops, suggested [m]
  // what was fitted
  recordings_differ,      ///< recordings, p; what runs from where to where
  two_kinds_of_drops,     ///< ; the lower eps and its drops, the upper
  repeated_drops,         ///< bounces; which drops
  eps_above_1,            ///< samples, of samples
  eps_below_0,            ///< samples, of samples
  odd_speeds,             ///< samples, of samples; what to look at
  rows_left_out,          ///< samples, the first; why
  many_intervals_odd,     ///< bounces, of bounces
  mixed_conditions,       ///< samples
  drops_differ,           ///< drops, by [eps], bounces by [eps]
  timing_too_large,       ///< scatter over what the stated errors explain
  scatter_not_as_fitted,  ///< chi^2/ndf, p
  outliers,               ///< bounces
  beyond_speeds,          ///< speed, slowest, fastest [m/s]
  timing_not_as_stated,   ///< seen, stated [us]
  memory_fails,           ///< ; why
  uncertain_air,          ///< ; the remedy
  uncertain_contact,      ///< ; the remedy
  // files
  other_ball,          ///< ; the ball of the samples, and the one that is named
  same_content,        ///< ; the file, and the one that it is the same as
  renamed_recordings,  ///< recordings; the file
  same_drop_in_files,  ///< ; the recording
  of_file,             ///< ; what a reader says of its file
  // how it was heard
  track_taken,         ///< track, of tracks
  lossy_coding,        ///< ; the coding
  gaps_of_time,        ///< gaps
  clipped,             ///< impacts, of impacts
  low_band,            ///< highest frequency [Hz]
  improbable_impacts,  ///< impacts, of impacts
  several_places,      ///< impacts, of impacts
  second_ball,         ///< impacts, begin [s]
  // synthetic sound
  modes_left_out,     ///< modes, lowest [Hz], highest [Hz], rate [Hz]
  synthetic_clipped,  ///< impacts
  drops_left_plate,   ///< drops
  impacts_with_gain,  ///< impacts, of impacts, energy over that released
  // constants of the law
  law_contradicted,     ///< speed [m/s], eps of the curve less the law, ln B
  too_few_samples,      ///< samples, least
  not_a_sphere,         ///<
  not_converged,        ///< gain left in log-likelihood
  not_identifiable,     ///< impacts; constants with their intervals
  one_speed,            ///< least, most [m/s]
  two_terms,            ///< samples
  one_constant,         ///< samples
  no_bootstrap,         ///<
  few_drops,            ///< drops
  one_drop_matters,     ///<
  errors_not_stated,    ///< samples, of samples
  memory_without_ball,  ///< inertia over m R^2, radius [m]
  tied_constants,       ///< correlation; which
  // the fit with memory
  memory_without_law,     ///<
  memory_too_few,         ///< least impacts, least in a row
  memory_not_converged,   ///<
  memory_without_errors,  ///<
  memory_transforms,      ///< p
  memory_mechanism,       ///< p
  memory_by_speed,        ///< p
  memory_between_drops,   ///< p
  memory_unlikelier,      ///<
  // campaigns and groups
  too_few_recordings,     ///< with a law, of recordings, least
  undetermined_campaign,  ///< recordings
  law_of_two_constants,   ///<
  one_speed_of_all,       ///< speed [m/s]
  plates_not_in_law,      ///< plates, recordings
  plates_are_days,        ///<
  few_days,               ///< days
  dates_missing,          ///< recordings, of recordings
  one_date,               ///<
  plates_are_times,       ///<
  rows_without_samples,   ///< rows, of rows; which, the table
  no_row,                 ///< recordings, of recordings; which, the table
  no_ball_named,          ///< recordings, of recordings; which
  other_conditions,       ///< recordings, of recordings; which
  group_too_small,        ///< samples, least; the group
  no_common_speeds,       ///< one ends at, another begins at [m/s]
  group_few_at_common,    ///< samples, from, to [m/s]; the group
  group_without_law,      ///< ; the group
  no_error_of_law,        ///<
  errors_tied,            ///<
  detector_failed,        ///< ; detector, recording, why
};
/// The word of fit.json: "lossy_coding".
const char* to_string(NoteKind kind);

struct Note {
  NoteKind kind = NoteKind::of_file;
  std::vector<double> numbers{};
  std::string subject{};
  std::string recording{};  ///< that it is of; empty: of all, or of the only one
};
Description members_of(const Note*);

}  // namespace bouncelab
