// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/impacts.hpp"

#include <cmath>
#include <span>
#include <string>

#include "bouncelab/core/error.hpp"
#include "tables/optional_cells.hpp"

namespace bouncelab {
namespace {

constexpr double kLargestEps = 1e6;  // more is no coefficient of restitution

/// Names of the state columns and where each number lives.
struct StateColumn {
  const char* name;
  double (*get)(const ImpactState&);
  void (*set)(ImpactState&, double);
};

#define BOUNCELAB_STATE_COLUMN(column, member, k)                                                               \
  StateColumn {                                                                                                 \
    column, [](const ImpactState& s) { return s.member[k]; }, [](ImpactState& s, double x) { s.member[k] = x; } \
  }

const StateColumn kStateColumns[] = {
    BOUNCELAB_STATE_COLUMN("x_m", position_m, 0),
    BOUNCELAB_STATE_COLUMN("y_m", position_m, 1),
    BOUNCELAB_STATE_COLUMN("z_m", position_m, 2),
    BOUNCELAB_STATE_COLUMN("qw", orientation, 0),
    BOUNCELAB_STATE_COLUMN("qx", orientation, 1),
    BOUNCELAB_STATE_COLUMN("qy", orientation, 2),
    BOUNCELAB_STATE_COLUMN("qz", orientation, 3),
    BOUNCELAB_STATE_COLUMN("vx_mps", velocity_mps, 0),
    BOUNCELAB_STATE_COLUMN("vy_mps", velocity_mps, 1),
    BOUNCELAB_STATE_COLUMN("vz_mps", velocity_mps, 2),
    BOUNCELAB_STATE_COLUMN("wx_radps", spin_radps, 0),
    BOUNCELAB_STATE_COLUMN("wy_radps", spin_radps, 1),
    BOUNCELAB_STATE_COLUMN("wz_radps", spin_radps, 2),
    BOUNCELAB_STATE_COLUMN("vx_after_mps", velocity_after_mps, 0),
    BOUNCELAB_STATE_COLUMN("vy_after_mps", velocity_after_mps, 1),
    BOUNCELAB_STATE_COLUMN("vz_after_mps", velocity_after_mps, 2),
    BOUNCELAB_STATE_COLUMN("wx_after_radps", spin_after_radps, 0),
    BOUNCELAB_STATE_COLUMN("wy_after_radps", spin_after_radps, 1),
    BOUNCELAB_STATE_COLUMN("wz_after_radps", spin_after_radps, 2),
};
const StateColumn kEnergyColumns[] = {
    BOUNCELAB_STATE_COLUMN("energy_vertical_j", energy_j, 0),
    BOUNCELAB_STATE_COLUMN("energy_horizontal_j", energy_j, 1),
    BOUNCELAB_STATE_COLUMN("energy_rotational_j", energy_j, 2),
    BOUNCELAB_STATE_COLUMN("energy_vertical_after_j", energy_after_j, 0),
    BOUNCELAB_STATE_COLUMN("energy_horizontal_after_j", energy_after_j, 1),
    BOUNCELAB_STATE_COLUMN("energy_rotational_after_j", energy_after_j, 2),
    {"dissipated_j", [](const ImpactState& s) { return s.dissipated_j; },
     [](ImpactState& s, double x) { s.dissipated_j = x; }},
    {"created_j", [](const ImpactState& s) { return s.created_j; }, [](ImpactState& s, double x) { s.created_j = x; }},
};
#undef BOUNCELAB_STATE_COLUMN

void append_columns(std::span<const StateColumn> columns, const std::vector<ImpactState>& states, Table& table) {
  for (const StateColumn& column : columns) {
    std::vector<double> values;
    values.reserve(states.size());
    for (const ImpactState& state : states) values.push_back(column.get(state));
    table.columns.push_back({column.name, std::move(values)});
  }
}

void read_column(const Table& table, const StateColumn& column, std::vector<ImpactState>& states) {
  const auto* values = table.reals(column.name);
  for (std::size_t k = 0; values != nullptr && k < states.size(); ++k) column.set(states[k], (*values)[k]);
}

struct ImpactColumns {
  std::vector<std::int64_t> drop, impact, asperity;
  std::vector<double> t, v, v_after, eps_macro, v_contact, eps_contact;
};

}  // namespace

Table to_table(const Impacts& impacts) {
  ImpactColumns c;
  for (const Impact& i : impacts.rows) {
    c.drop.push_back(i.drop);
    c.impact.push_back(i.impact);
    c.t.push_back(i.t_s);
    c.v.push_back(i.v_mps);
    c.v_after.push_back(i.v_after_mps);
    c.eps_macro.push_back(i.eps_macro);
    c.v_contact.push_back(i.v_contact_mps);
    c.eps_contact.push_back(i.eps_contact);
    c.asperity.push_back(i.asperity);
  }
  Table table{{{"drop", std::move(c.drop)},
               {"impact", std::move(c.impact)},
               {"t_s", std::move(c.t)},
               {"v_mps", std::move(c.v)},
               {"v_after_mps", std::move(c.v_after)},
               {"eps_macro", std::move(c.eps_macro)},
               {"v_contact_mps", std::move(c.v_contact)},
               {"eps_contact", std::move(c.eps_contact)},
               {"asperity", std::move(c.asperity)}}};
  if (impacts.states.empty()) return table;
  append_columns(kStateColumns, impacts.states, table);
  append_columns(kEnergyColumns, impacts.states, table);
  return table;
}

std::vector<ColumnSpec> impact_columns() {
  constexpr double kFastest_mps = 1e4;
  constexpr Range kSpeeds_mps{-kFastest_mps, kFastest_mps};
  constexpr Range kState{-1e9, 1e9, false, false};  // metres, m/s, rad/s, joules
  std::vector<ColumnSpec> columns{{"drop", ColumnType::integer, true, kIndexRange},
                                  {"impact", ColumnType::integer, true, kIndexRange},
                                  {"t_s", ColumnType::real, true, known(kTimeRange_s)},
                                  {"v_mps", ColumnType::real, true, known(positive_up_to(kFastest_mps))},
                                  {"v_after_mps", ColumnType::real, true, known(kSpeeds_mps)},
                                  {"v_contact_mps", ColumnType::real, false, kSpeeds_mps},
                                  {"eps_contact", ColumnType::real, false, {-kLargestEps, kLargestEps}},
                                  {"asperity", ColumnType::integer, false, {-1.0, kIndexRange.greatest}}};
  for (const StateColumn& column : kStateColumns) columns.push_back({column.name, ColumnType::real, false, kState});
  for (const StateColumn& column : kEnergyColumns) columns.push_back({column.name, ColumnType::real, false, kState});
  return columns;
}

Impacts impacts_from_table(const Table& table, const std::string& name, const Impact* before) {
  check_columns(table, impact_columns(), name);
  const auto& drop = *table.integers("drop");
  const auto& impact = *table.integers("impact");
  const auto& t = *table.reals("t_s");
  const auto& v = *table.reals("v_mps");
  const auto& v_after = *table.reals("v_after_mps");
  const auto* v_contact = table.reals("v_contact_mps");
  const auto* eps_contact = table.reals("eps_contact");
  const auto* asperity = table.integers("asperity");

  Impacts impacts;
  impacts.rows.reserve(t.size());
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (before && drop[k] < before->drop)
      throw FileError(name, table.place_of(k) + ": drops must not go back; sort the file");
    if (before && drop[k] == before->drop && t[k] <= before->t_s)
      throw FileError(name, table.place_of(k) + ", column t_s: times must increase within a drop; sort the file");
    const double eps = v_after[k] / v[k];
    if (!(std::abs(eps) <= kLargestEps))
      throw FileError(name, table.place_of(k) + ": v_after_mps is more than a million times v_mps; correct the speeds");
    impacts.rows.push_back({drop[k], impact[k], t[k], v[k], v_after[k], eps, optional_cell(v_contact, k).value_or(v[k]),
                            optional_cell(eps_contact, k).value_or(eps), asperity ? (*asperity)[k] : -1});
    before = &impacts.rows.back();
  }
  bool has_state = true;
  for (const StateColumn& column : kStateColumns) has_state = has_state && table.has(column.name);
  if (!has_state) return impacts;
  impacts.states.resize(t.size());
  for (const StateColumn& column : kStateColumns) read_column(table, column, impacts.states);
  for (const StateColumn& column : kEnergyColumns) read_column(table, column, impacts.states);
  return impacts;
}

}  // namespace bouncelab
