// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "stages/validate/detectors.hpp"

namespace bouncelab::stages {

struct DetectorResult {
  std::string name;
  std::vector<Marks> marks;  ///< one for each case
};
std::size_t n_failed(const DetectorResult& result);
/// A line for each recording in which one failed.
std::vector<std::string> failures_of(const std::vector<Case>& cases, const std::vector<DetectorResult>& results);

/// For the terminal: a table's head, a row, and all of it.
std::string heading(const std::string& first);
std::string line_of(const std::string& name, const loop::DetectorScore& score);
std::string text_of(const std::vector<Case>& cases, const std::vector<loop::SweepAxis>& lists,
                    const std::vector<DetectorResult>& results);

/// scores.csv
Table table_of(const std::vector<Case>& cases, const std::vector<DetectorResult>& results);
/// One of `detectors` in validation.json.
Object object_of_result(const std::vector<Case>& cases, const std::vector<loop::SweepAxis>& lists,
                        const DetectorResult& result);
/// The sound of the three recordings in which a detector finds least, with its marks, for the page.
Values worst_of(const std::vector<Case>& cases, const std::vector<loop::TrueTimes>& truths,
                const DetectorResult& result);

}  // namespace bouncelab::stages
