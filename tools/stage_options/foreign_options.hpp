// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "bouncelab/core/foreign_table.hpp"

namespace bouncelab::options {

/// What the user says of a file of times or marks that this program did not write.
struct ForeignFileOptions {
  ForeignOptions table;
  std::string tier;       ///< of a TextGrid, layer of an .svl; empty: the one that looks most like impacts
  bool renumber = false;  ///< marks: number the impacts of each drop anew
  std::string recording;  ///< that marks belong to; empty: as they say
};
/// Without the last two, which are options of convert alone.
Description members_of(const ForeignFileOptions*);

}  // namespace bouncelab::options
