// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// One impact of one drop, as simulated. Lab frame, z up, plate at z = 0.
struct Impact {
  std::int64_t drop = 0;       ///< number of the drop, from 0
  std::int64_t impact = 0;     ///< number of the impact within its drop, from 0
  double t_s = 0.0;            ///< begin of contact, from the release of this drop
  double v_mps = 0.0;          ///< downward normal speed of the centre before the impact; positive when falling
  double v_after_mps = 0.0;    ///< upward normal speed of the centre after it
  double eps_macro = 0.0;      ///< v_after / v, eq. 12 of the paper; may exceed 1 or be negative
  double v_contact_mps = 0.0;  ///< normal approach speed at the point of contact
  double eps_contact = 0.0;    ///< eps(v_contact), the law's value
  std::int64_t asperity = -1;  ///< index into the surface; -1: the smooth sphere
};

/// Position, orientation and velocities at the instant of contact.
struct ImpactState {
  std::array<double, 3> position_m{};             ///< centre of the ball
  std::array<double, 4> orientation{1, 0, 0, 0};  ///< body -> lab, unit quaternion (w, x, y, z)
  std::array<double, 3> velocity_mps{};           ///< of the centre, before
  std::array<double, 3> spin_radps{};             ///< angular velocity in the lab frame, before
  std::array<double, 3> velocity_after_mps{};     ///< of the centre, after
  std::array<double, 3> spin_after_radps{};       ///< angular velocity in the lab frame, after
  std::array<double, 3> energy_j{};               ///< kinetic: vertical, horizontal, rotational; before
  std::array<double, 3> energy_after_j{};         ///< the same, after
  double dissipated_j = 0.0, created_j = 0.0;     ///< before + created = after + dissipated; one of the two is 0
};

/// Impacts of any number of drops, ordered by drop and time.
struct Impacts {
  std::vector<Impact> rows;
  std::vector<ImpactState> states;  ///< empty, or one for each row
};

const RowColumns<Impact>& columns_of(const Impact*);
const RowColumns<ImpactState>& columns_of(const ImpactState*);
/// The `impacts` table of docs/formats.md; with the state columns where states are present.
Table to_table(const Impacts& impacts);

/// Columns that impacts_from_table understands: `drop`, `impact`, `t_s`, `v_mps` and `v_after_mps` are required.
std::vector<ColumnSpec> impact_columns();

/// Checks what the table promises: numbers in the ranges of impact_columns(), times that increase within each drop,
/// drops in order.
/// @param name  of the file, for messages
/// @throws FileError naming the first offending row by its line
Impacts impacts_from_table(const Table& table, const std::string& name);

}  // namespace bouncelab
