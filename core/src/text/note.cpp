// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/note.hpp"

#include <array>

namespace bouncelab {
namespace {

/// In the order of NoteKind.
constexpr std::array kNames{"no_ball_likely",
                            "silence",
                            "no_three_bounces",
                            "sounds_not_of_ball",
                            "drops_too_short",
                            "eps_impossible",
                            "odd_speeds",
                            "contradicted_height",
                            "recording_left_out",
                            "recordings_differ",
                            "two_kinds_of_drops",
                            "doubtful_drops",
                            "second_ball",
                            "other_ball",
                            "mixed_conditions",
                            "no_ball_named",
                            "other_conditions",
                            "repeated_drops",
                            "same_drop_in_files",
                            "renamed_recordings",
                            "same_content",
                            "many_intervals_odd",
                            "rows_left_out",
                            "outliers",
                            "gaps_of_time",
                            "improbable_impacts",
                            "memory_fails",
                            "drops_differ",
                            "scatter_not_as_fitted",
                            "timing_too_large",
                            "timing_not_as_stated",
                            "lossy_coding",
                            "clipped",
                            "of_file",
                            "beyond_speeds",
                            "track_taken",
                            "low_band",
                            "several_places",
                            "modes_left_out",
                            "synthetic_clipped",
                            "drops_left_plate",
                            "impacts_with_gain",
                            "uncertain_air",
                            "uncertain_contact",
                            "law_contradicted",
                            "too_few_samples",
                            "not_a_sphere",
                            "not_converged",
                            "not_identifiable",
                            "tied_constants",
                            "one_speed",
                            "two_terms",
                            "one_constant",
                            "no_bootstrap",
                            "few_drops",
                            "errors_not_stated",
                            "memory_without_ball",
                            "memory_without_law",
                            "memory_too_few",
                            "memory_not_converged",
                            "memory_without_errors",
                            "memory_transforms",
                            "memory_mechanism",
                            "memory_by_speed",
                            "memory_between_drops",
                            "memory_unlikelier",
                            "too_few_recordings",
                            "undetermined_campaign",
                            "law_of_two_constants",
                            "one_speed_of_all",
                            "plates_not_in_law",
                            "plates_are_days",
                            "few_days",
                            "dates_missing",
                            "one_date",
                            "plates_are_times",
                            "rows_without_samples",
                            "no_row",
                            "group_too_small",
                            "no_common_speeds",
                            "group_few_at_common",
                            "group_without_law",
                            "no_error_of_law",
                            "errors_tied",
                            "detector_failed"};
static_assert(kNames.size() == static_cast<std::size_t>(NoteKind::detector_failed) + 1);

}  // namespace

const char* to_string(NoteKind kind) { return kNames[static_cast<std::size_t>(kind)]; }

Description members_of(const Note*) {
  static constexpr Member all[]{
      member<&Note::kind>("kind", "What it is"), member<&Note::numbers>("numbers", "Its numbers"),
      member<&Note::subject>("subject", "What it is about"),
      member<&Note::recording>("recording", "The recording that it is of; empty: of all, or of the only one")};
  return all;
}

const char* to_string(Severity severity) {
  switch (severity) {
    case Severity::no_answer:
      return "no_answer";
    case Severity::warning:
      return "warning";
    case Severity::detail:
      break;
  }
  return "detail";
}

}  // namespace bouncelab
