// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/foreign_options.hpp"

namespace bouncelab::options {

const Description& members_of(const ForeignFileOptions*) {
  using O = ForeignFileOptions;
  static const Description all{
      member<O>(
          "as", [](auto& o) -> auto& { return o.table.as; },
          "What the numbers are; auto: what titles say, or what they look like")
          .one_of({"auto", "times", "intervals"}),
      member<O>(
          "unit", [](auto& o) -> auto& { return o.table.unit; },
          "Their unit; auto: what a title says, or what they look like")
          .one_of({"auto", "s", "ms", "us"}),
      member<O>(
          "columns", [](auto& o) -> auto& { return o.table.columns; },
          "Which columns are what, by title or number from 1 (default: by their titles)")
          .looks_like("t=COLUMN[,drop=COLUMN]"),
      member("tier", &O::tier,
             "Tier of a TextGrid or layer of an .svl, by name or number (default: the one that looks like impacts)")};
  return all;
}

}  // namespace bouncelab::options
