// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/foreign_options.hpp"

namespace bouncelab::options {

Description members_of(const ForeignFileOptions*) {
  using O = ForeignFileOptions;
  static constexpr Member all[]{
      member<&O::table, &ForeignOptions::as>("as",
                                             "What the numbers are; auto: what titles say, or what they look like")
          .one_of("auto,times,intervals"),
      member<&O::table, &ForeignOptions::unit>("unit", "Their unit; auto: what a title says, or what they look like")
          .one_of("auto,s,ms,us"),
      member<&O::table, &ForeignOptions::columns>(
          "columns", "Which columns are what, by title or number from 1 (default: by their titles)")
          .looks_like("t=COLUMN[,drop=COLUMN]"),
      member<&O::tier>(
          "tier",
          "Tier of a TextGrid or layer of an .svl, by name or number (default: the one that looks like impacts)")};
  return all;
}

}  // namespace bouncelab::options
