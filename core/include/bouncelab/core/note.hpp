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

/// Of two notes of one severity that of the kind that stands first here is told first, so that the order is that of
/// importance: what makes the answer wrong, what makes it one of another thing, what it misses, what makes its errors
/// wrong. The comments are the numbers, in their order, and behind a semicolon the subject.
enum class NoteKind {
  // nothing was heard
  no_ball_likely,      ///< odds, begin [s]
  silence,             ///<
  no_three_bounces,    ///< sounds that rise
  sounds_not_of_ball,  ///< sounds that rise
  drops_too_short,     ///< drops, least impacts
  // the input is not what it is taken for
  eps_impossible,       ///< samples, of samples
  odd_speeds,           ///< samples, of samples; what to look at
  contradicted_height,  ///< stated [m], drops, of drops, suggested [m]
  // the input is not of one ball
  recording_left_out,  ///< ; why
  recordings_differ,   ///< recordings, p; what runs from where to where
  two_kinds_of_drops,  ///< ; the lower eps and its drops, the upper
  doubtful_drops,      ///< drops, of drops, odds; where
  second_ball,         ///< impacts, begin [s]
  other_ball,          ///< ; the ball of the samples, and the one that is named
  mixed_conditions,    ///< samples
  no_ball_named,       ///< recordings, of recordings; which
  other_conditions,    ///< recordings, of recordings; which
  // what counts once or as several
  repeated_drops,      ///< bounces; which drops
  same_drop_in_files,  ///< ; the recording
  renamed_recordings,  ///< recordings; the file
  same_content,        ///< ; the file, and the one that it is the same as
  // what is left out or missing
  many_intervals_odd,  ///< bounces, of bounces
  rows_left_out,       ///< samples, the first; why
  outliers,            ///< bounces
  gaps_of_time,        ///< gaps
  improbable_impacts,  ///< impacts, of impacts
  // errors and the fit
  memory_fails,           ///< ; why
  drops_differ,           ///< drops, by [eps], bounces by [eps]
  scatter_not_as_fitted,  ///< chi^2/ndf, p
  timing_too_large,       ///< scatter over what the stated errors explain
  timing_not_as_stated,   ///< seen, stated [us]
  // how it was recorded
  lossy_coding,    ///< ; the coding
  clipped,         ///< impacts, of impacts
  of_file,         ///< ; what a reader says of its file
  beyond_speeds,   ///< speed, slowest, fastest [m/s]
  track_taken,     ///< track, of tracks
  low_band,        ///< highest frequency [Hz]
  several_places,  ///< impacts, of impacts
  // synthetic sound
  modes_left_out,     ///< modes, lowest [Hz], highest [Hz], rate [Hz]
  synthetic_clipped,  ///< impacts
  drops_left_plate,   ///< drops
  impacts_with_gain,  ///< impacts, of impacts, energy over that released
  // the answer and its law
  uncertain_air,        ///< ; the remedy
  uncertain_contact,    ///< ; the remedy
  law_contradicted,     ///< speed [m/s], eps of the curve less the law, ln B
  too_few_samples,      ///< samples, least
  not_a_sphere,         ///<
  not_converged,        ///< gain left in log-likelihood
  not_identifiable,     ///< impacts; constants with their intervals
  tied_constants,       ///< correlation; which
  one_speed,            ///< least, most [m/s]
  two_terms,            ///< samples
  one_constant,         ///< samples
  no_bootstrap,         ///<
  few_drops,            ///< ; how few
  errors_not_stated,    ///< samples, of samples
  memory_without_ball,  ///< inertia over m R^2, radius [m]
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
