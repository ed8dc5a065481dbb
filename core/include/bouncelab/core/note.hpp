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

/// All kinds, each once. Of two notes of one severity that of the kind that stands first here is told first, so that
/// the order is that of importance: what makes the answer wrong, what makes it one of another thing, what it misses,
/// what makes its errors wrong. The comments are the numbers, in their order, and behind a semicolon the subject.
// clang-format off
#define BOUNCELAB_NOTE_KINDS(kind)                                              \
  /* nothing was heard: */                                                      \
  kind(no_ball_likely) /* odds, begin [s] */                                    \
  kind(silence)                                                                 \
  kind(no_three_bounces) /* sounds that rise */                                 \
  kind(sounds_not_of_ball) /* sounds that rise */                               \
  kind(drops_too_short) /* drops, least impacts */                              \
  /* the input is not what it is taken for: */                                  \
  kind(eps_impossible) /* samples, of samples */                                \
  kind(odd_speeds) /* samples, of samples; what to look at */                   \
  kind(contradicted_height) /* stated [m], drops, of drops, suggested [m] */    \
  /* the input is not of one ball: */                                           \
  kind(recording_left_out) /* ; why */                                          \
  kind(recordings_differ) /* recordings, p; what runs from where to where */    \
  kind(two_kinds_of_drops) /* ; the lower eps and its drops, the upper */       \
  kind(doubtful_drops) /* drops, of drops, odds; where */                       \
  kind(balls_at_once) /* balls, begin [s]; eps of each */                       \
  kind(other_ball) /* ; the ball of the samples, and the one that is named */   \
  kind(mixed_conditions) /* samples */                                          \
  kind(no_ball_named) /* recordings, of recordings; which */                    \
  kind(other_conditions) /* recordings, of recordings; which */                 \
  /* what counts once or as several: */                                         \
  kind(repeated_drops) /* bounces; which drops */                               \
  kind(renamed_recordings) /* recordings; the file */                           \
  kind(same_content) /* ; the file, and the one that it is the same as */       \
  /* what is left out or missing: */                                            \
  kind(many_intervals_odd) /* bounces, of bounces */                            \
  kind(rows_left_out) /* samples, the first; why */                             \
  kind(outliers) /* bounces */                                                  \
  kind(gaps_of_time) /* gaps */                                                 \
  kind(improbable_impacts) /* impacts, of impacts */                            \
  /* errors and the fit: */                                                     \
  kind(memory_fails) /* ; why */                                                \
  kind(drops_differ) /* drops, by [eps], bounces by [eps] */                    \
  kind(scatter_not_as_fitted) /* chi^2/ndf, p */                                \
  kind(timing_too_large) /* scatter over what the stated errors explain */      \
  kind(timing_not_as_stated) /* seen, stated [us] */                            \
  /* how it was recorded: */                                                    \
  kind(lossy_coding) /* ; the coding */                                         \
  kind(clipped) /* impacts, of impacts */                                       \
  kind(of_file) /* ; what a reader says of its file */                          \
  kind(beyond_speeds) /* speed, slowest, fastest [m/s] */                       \
  kind(track_taken) /* track, of tracks */                                      \
  kind(low_band) /* highest frequency [Hz] */                                   \
  kind(several_places) /* impacts, of impacts */                                \
  /* synthetic sound: */                                                        \
  kind(modes_left_out) /* modes, lowest [Hz], highest [Hz], rate [Hz] */        \
  kind(synthetic_clipped) /* impacts */                                         \
  kind(drops_left_plate) /* drops */                                            \
  kind(impacts_with_gain) /* impacts, of impacts, energy over that released */  \
  /* the answer and its law: */                                                 \
  kind(uncertain_air) /* ; the remedy */                                        \
  kind(uncertain_contact) /* ; the remedy */                                    \
  kind(law_contradicted) /* speed [m/s], eps of the curve less the law, ln B */ \
  kind(too_few_samples) /* samples, least */                                    \
  kind(not_a_sphere)                                                            \
  kind(not_converged) /* gain left in log-likelihood */                         \
  kind(not_identifiable) /* impacts; constants with their intervals */          \
  kind(one_speed) /* least, most [m/s] */                                       \
  kind(two_terms) /* samples */                                                 \
  kind(one_constant) /* samples */                                              \
  kind(few_drops) /* ; how few */                                               \
  kind(errors_not_stated) /* samples, of samples */                             \
  kind(memory_without_ball) /* inertia over m R^2, radius [m] */                \
  /* the fit with memory: */                                                    \
  kind(memory_without_law)                                                      \
  kind(memory_too_few) /* least impacts, least in a row */                      \
  kind(memory_not_converged)                                                    \
  kind(memory_without_errors)                                                   \
  kind(memory_transforms) /* p */                                               \
  kind(memory_mechanism) /* p */                                                \
  kind(memory_by_speed) /* p */                                                 \
  kind(memory_between_drops) /* p */                                            \
  kind(memory_unlikelier)                                                       \
  /* campaigns and groups: */                                                   \
  kind(too_few_recordings) /* with a law, of recordings, least */               \
  kind(speed_not_reached) /* speed, of the recording the least, the greatest [m/s] */\
  kind(plates_not_in_model) /* plates, recordings */                            \
  kind(plates_are_days)                                                         \
  kind(few_days) /* days */                                                     \
  kind(dates_missing) /* recordings, of recordings */                           \
  kind(one_date)                                                                \
  kind(plates_are_times)                                                        \
  kind(rows_without_samples) /* rows, of rows; which, the table */              \
  kind(no_row) /* recordings, of recordings; which, the table */                \
  kind(group_too_small) /* samples, least; the group */                         \
  kind(no_common_speeds) /* one ends at, another begins at [m/s] */             \
  kind(no_error_of_law)                                                         \
  kind(detector_failed) /* ; detector, recording, why */
// clang-format on

enum class NoteKind {
#define BOUNCELAB_NOTE_KIND(name) name,
  BOUNCELAB_NOTE_KINDS(BOUNCELAB_NOTE_KIND)
#undef BOUNCELAB_NOTE_KIND
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
