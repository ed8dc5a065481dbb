// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "between/offset_model.hpp"
#include "bouncelab/fit/between_recordings.hpp"
#include "law/law_model.hpp"

namespace bouncelab::fit {

/// Which groups there are. Numbers are in order of name.
struct GroupLabels {
  std::vector<std::string> names;
  std::vector<int> of_recording;  ///< -1: not known
  GroupEffect effect = GroupEffect::none;
};

/// The recordings used as rows of the model.
struct Design {
  std::vector<std::size_t> of_row;  ///< number of the recording
  LawModel law;
  std::vector<double> node_v_mps;  ///< at which the pooled law is reported
  std::vector<double> v_ends_mps;  ///< of its curve; empty: one speed
  Eigen::VectorXd base;            ///< of the law's coordinates: what the data's values are differences from
  Eigen::Index n_law = 0;          ///< columns of the law: eps - 1 at its nodes
  OffsetData data;                 ///< of all rows. Columns: law, contrasts of plates, drift
  GroupLabels plates, days;        ///< of_recording by row
  bool has_drift = false;
  Drift drift;                                       ///< without the estimate
  double time_unit = 1.0;                            ///< of the drift's column: days, or recordings, from begin to end
  std::size_t plate_grouping = 0, day_grouping = 0;  ///< in data
  ChiSquareTest shapes;
  double within_rank = 0.0;
  std::vector<Note> notes;

  /// What a plate adds by the fixed effects. @param plate  -1: none
  double plate_constant(const Eigen::VectorXd& beta, int plate) const;
};

/// @param recordings  at least kFewestPooled of them with a law of their own
Design make_design(const std::vector<CampaignRecording>& recordings);

/// Do the rows determine all columns?
bool is_determined(const OffsetData& data);

/// Some of the rows.
OffsetData rows_of(const OffsetData& data, const std::vector<Eigen::Index>& rows);

}  // namespace bouncelab::fit
