// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "between/offset_model.hpp"

namespace bouncelab::fit {

/// The model on the rows that are no outliers, and every row against it.
struct Judged {
  std::vector<Eigen::Index> kept;  ///< rows
  OffsetData data;                 ///< of these
  Deviations deviations{};
  struct Row {
    double standardised = 0.0;
    double p_value = 1.0;  ///< times the number of rows, at most 1
    bool is_outlier = false;
  };
  std::vector<Row> rows;  ///< of all
};

/// Outliers are rows whose distance from what the others predict, with the standard deviations of the others, has
/// p < 0.05 by Student's t after Bonferroni's correction for the number of rows. They are left out, and all are judged
/// anew, until none changes: rows beyond the level although they widen the standard deviations themselves at once, and
/// of the others that which is furthest off, by a fit without it. No more than a quarter of the rows become outliers.
Judged judge(const OffsetData& data);

}  // namespace bouncelab::fit
