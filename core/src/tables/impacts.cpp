// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/impacts.hpp"

#include <cmath>

#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

constexpr double kLargestEps = 1e6;  // more is no coefficient of restitution

constexpr Range kState{-1e9, 1e9, false, false};  // metres, m/s, rad/s, joules

/// The k-th number of an array of a state.
template <auto member, std::size_t k>
RowColumn<ImpactState> at(std::string name, std::string text) {
  return column<ImpactState>(
      std::move(name), [](auto& s) -> auto& { return (s.*member)[k]; }, std::move(text), kState);
}

/// Columns of energies, without which states are whole.
bool is_energy(const std::string& name) { return name.ends_with("_j"); }

}  // namespace

const RowColumns<Impact>& columns_of(const Impact*) {
  using I = Impact;
  constexpr double kFastest_mps = 1e4;
  constexpr Range kSpeeds_mps{-kFastest_mps, kFastest_mps};
  static const RowColumns<I> all{
      column("drop", &I::drop, "Number of the drop", kIndexRange).required(),
      column("impact", &I::impact, "Number of the impact within its drop", kIndexRange).required(),
      column("t_s", &I::t_s, "Start of contact, from the release of this drop", known(kTimeRange_s)).required(),
      column("v_mps", &I::v_mps, "Downward normal speed of the centre before the impact, > 0",
             known(positive_up_to(kFastest_mps)))
          .required(),
      column("v_after_mps", &I::v_after_mps,
             "Upward normal speed of the centre after it; may exceed `v_mps` or be negative", known(kSpeeds_mps))
          .required(),
      column("eps_macro", &I::eps_macro, "`v_after_mps / v_mps`, never clamped").only_written(),
      column("v_contact_mps", &I::v_contact_mps, "Normal approach speed of the point of contact", kSpeeds_mps),
      column("eps_contact", &I::eps_contact, "ε(`v_contact_mps`), the value of the law", {-kLargestEps, kLargestEps}),
      column("asperity", &I::asperity, "Index into the surface; -1: the smooth sphere", {-1.0, kIndexRange.greatest})};
  return all;
}

const RowColumns<ImpactState>& columns_of(const ImpactState*) {
  using S = ImpactState;
  static const RowColumns<S> all{
      at<&S::position_m, 0>("x_m", "Position of the ball's centre"),
      at<&S::position_m, 1>("y_m", "Likewise"),
      at<&S::position_m, 2>("z_m", "Likewise"),
      at<&S::orientation, 0>("qw", "Orientation, body → lab, unit quaternion"),
      at<&S::orientation, 1>("qx", "Likewise"),
      at<&S::orientation, 2>("qy", "Likewise"),
      at<&S::orientation, 3>("qz", "Likewise"),
      at<&S::velocity_mps, 0>("vx_mps", "Velocity of the centre before"),
      at<&S::velocity_mps, 1>("vy_mps", "Likewise"),
      at<&S::velocity_mps, 2>("vz_mps", "Likewise"),
      at<&S::spin_radps, 0>("wx_radps", "Angular velocity in the lab frame before"),
      at<&S::spin_radps, 1>("wy_radps", "Likewise"),
      at<&S::spin_radps, 2>("wz_radps", "Likewise"),
      at<&S::velocity_after_mps, 0>("vx_after_mps", "Velocity of the centre after"),
      at<&S::velocity_after_mps, 1>("vy_after_mps", "Likewise"),
      at<&S::velocity_after_mps, 2>("vz_after_mps", "Likewise"),
      at<&S::spin_after_radps, 0>("wx_after_radps", "Angular velocity in the lab frame after"),
      at<&S::spin_after_radps, 1>("wy_after_radps", "Likewise"),
      at<&S::spin_after_radps, 2>("wz_after_radps", "Likewise"),
      at<&S::energy_j, 0>("energy_vertical_j", "Kinetic energies before"),
      at<&S::energy_j, 1>("energy_horizontal_j", "Likewise"),
      at<&S::energy_j, 2>("energy_rotational_j", "Likewise"),
      at<&S::energy_after_j, 0>("energy_vertical_after_j", "Kinetic energies after"),
      at<&S::energy_after_j, 1>("energy_horizontal_after_j", "Likewise"),
      at<&S::energy_after_j, 2>("energy_rotational_after_j", "Likewise"),
      column("dissipated_j", &S::dissipated_j, "Before + created = after + dissipated; one of the two is 0", kState),
      column("created_j", &S::created_j, "", kState)};
  return all;
}

Table to_table(const Impacts& impacts) {
  Table table = table_of<Impact>(columns_of(impacts.rows.data()), impacts.rows);
  if (impacts.states.empty()) return table;
  for (Column& c : table_of<ImpactState>(columns_of(impacts.states.data()), impacts.states).columns)
    table.columns.push_back(std::move(c));
  return table;
}

std::vector<ColumnSpec> impact_columns() {
  std::vector<ColumnSpec> all = specs_of(columns_of(static_cast<const Impact*>(nullptr)));
  for (ColumnSpec& spec : specs_of(columns_of(static_cast<const ImpactState*>(nullptr))))
    all.push_back(std::move(spec));
  return all;
}

Impacts impacts_from_table(const Table& table, const std::string& name) {
  check_columns(table, impact_columns(), name);
  Impacts impacts{rows_of(columns_of(static_cast<const Impact*>(nullptr)), table), {}};
  const std::vector<double>*v_contact = table.reals("v_contact_mps"), *eps_contact = table.reals("eps_contact");
  const auto is_known = [](const std::vector<double>* cells, std::size_t k) {
    return cells && !std::isnan((*cells)[k]);
  };
  const Impact* before = nullptr;
  for (std::size_t k = 0; k < impacts.rows.size(); ++k) {
    Impact& row = impacts.rows[k];
    if (before && row.drop < before->drop)
      throw FileError(name, table.place_of(k) + ": drops must not go back; sort the file");
    if (before && row.drop == before->drop && row.t_s <= before->t_s)
      throw FileError(name, table.place_of(k) + ", column t_s: times must increase within a drop; sort the file");
    row.eps_macro = row.v_after_mps / row.v_mps;
    if (!(std::abs(row.eps_macro) <= kLargestEps))
      throw FileError(name, table.place_of(k) + ": v_after_mps is more than a million times v_mps; correct the speeds");
    if (!is_known(v_contact, k)) row.v_contact_mps = row.v_mps;
    if (!is_known(eps_contact, k)) row.eps_contact = row.eps_macro;
    before = &row;
  }
  const RowColumns<ImpactState>& states = columns_of(static_cast<const ImpactState*>(nullptr));
  for (const RowColumn<ImpactState>& c : states)
    if (!is_energy(c.spec.name) && !table.has(c.spec.name)) return impacts;
  impacts.states = rows_of(states, table);
  return impacts;
}

}  // namespace bouncelab
