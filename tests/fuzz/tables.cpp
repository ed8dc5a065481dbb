// SPDX-License-Identifier: GPL-3.0-or-later
#include "tables.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/samples.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

const std::string kName = "input";

bool is_same_cell(double a, double b) {
  return a == b ? std::signbit(a) == std::signbit(b) : std::isnan(a) && std::isnan(b);
}
template <class T>
bool is_same_cell(const T& a, const T& b) {
  return a == b;
}

bool is_of_type(const Column& column, ColumnType type) {
  if (type == ColumnType::real) return std::holds_alternative<std::vector<double>>(column.values);
  if (type == ColumnType::integer) return std::holds_alternative<std::vector<std::int64_t>>(column.values);
  return std::holds_alternative<std::vector<std::string>>(column.values);
}

/// A standard error is not known, or a positive number; of a sample it may be 0, which the fit takes for not known.
bool is_error(const std::optional<double>& sigma, bool may_be_0 = false) {
  return !sigma || (std::isfinite(*sigma) && (*sigma > 0.0 || (may_be_0 && *sigma == 0.0)));
}

void check(const Impacts& impacts) {
  require(impacts.states.empty() || impacts.states.size() == impacts.rows.size(), "there is a state for each impact");
  for (std::size_t k = 0; k < impacts.rows.size(); ++k) {
    const Impact& impact = impacts.rows[k];
    require(std::isfinite(impact.t_s) && std::isfinite(impact.v_mps) && std::isfinite(impact.v_after_mps),
            "times and speeds of impacts are finite");
    if (k == 0) continue;
    const Impact& before = impacts.rows[k - 1];
    require(before.drop < impact.drop || (before.drop == impact.drop && before.t_s < impact.t_s),
            "drops do not go back, and times increase within a drop");
  }
}

void check(const Onsets& onsets) {
  for (std::size_t k = 0; k < onsets.size(); ++k) {
    const Onset& onset = onsets[k];
    require(std::isfinite(onset.t_s), "times of onsets are finite");
    require(is_error(onset.sigma_t_s), "standard errors are positive numbers");
    if (k == 0 || onsets[k - 1].recording != onset.recording || onsets[k - 1].drop != onset.drop) continue;
    require(onsets[k - 1].t_s < onset.t_s, "times increase within a drop");
  }
}

void check(const RestitutionSamples& samples) {
  for (const RestitutionSample& sample : samples) {
    const bool finite = std::isfinite(sample.v_mps) && std::isfinite(sample.eps);
    require(finite || sample.flags.has(Flag::not_finite), "speed and coefficient are finite, or flagged");
    require(is_error(sample.sigma_eps, true) && is_error(sample.sigma_v_mps, true), "standard errors are not negative");
  }
}

/// One kind of table: what it makes of the columns is checked, and is the same after a round trip.
template <class Values>
void check_kind(const TableFormat& format, const std::vector<ColumnSpec>& wanted, Values (*values_of)(const Table&)) {
  Table table;
  if (!accepts([&] { table = format.read(wanted); })) return;
  check_columns(table, wanted);
  Table again;
  must_accept("a table that was written can be read", [&] { again = format.read_back(table, wanted); });
  require(are_same(table, again), "a table is the same when written and read again");

  Values values;
  if (!accepts([&] { values = values_of(table); })) return;
  check(values);
  const Table written = to_table(values);
  Values values_again;
  must_accept("values that were accepted are accepted when written and read again",
              [&] { values_again = values_of(format.read_back(written, wanted)); });
  // numbers without an error that are written with fewer digits than they were read with get one by rounding, once
  const Table settled = to_table(values_again);
  require(are_same(settled, to_table(values_of(format.read_back(settled, wanted)))),
          "values are the same when written and read again");
}

}  // namespace

void check_columns(const Table& table, const std::vector<ColumnSpec>& wanted) {
  for (const Column& column : table.columns) {
    require(std::visit([](const auto& values) { return values.size(); }, column.values) == table.n_rows(),
            "columns are of equal length");
    const auto spec = std::find_if(wanted.begin(), wanted.end(), [&](const auto& s) { return s.name == column.name; });
    require(spec != wanted.end(), "only columns that are wanted are read");
    require(is_of_type(column, spec->type), "a column is of the type wanted");
  }
  for (const ColumnSpec& spec : wanted)
    require(!spec.required || table.has(spec.name), "a column that is required is there");
}

bool are_same(const Table& a, const Table& b) {
  const auto same_column = [](const Column& x, const Column& y) {
    if (x.name != y.name || x.values.index() != y.values.index()) return false;
    return std::visit(
        [&](const auto& values) {
          const auto& others = std::get<std::decay_t<decltype(values)>>(y.values);
          return std::equal(values.begin(), values.end(), others.begin(), others.end(),
                            [](const auto& p, const auto& q) { return is_same_cell(p, q); });
        },
        x.values);
  };
  return std::equal(a.columns.begin(), a.columns.end(), b.columns.begin(), b.columns.end(), same_column);
}

void check_tables(const TableFormat& format) {
  static const std::vector<ColumnSpec> of_impacts = impact_columns(), of_onsets = onset_columns(),
                                       of_samples = sample_columns();
  check_kind<Impacts>(format, of_impacts, [](const Table& table) { return impacts_from_table(table, kName); });
  check_kind<Onsets>(format, of_onsets, [](const Table& table) { return onsets_from_table(table, kName); });
  check_kind<RestitutionSamples>(format, of_samples,
                                 [](const Table& table) { return samples_from_table(table, kName); });
}

}  // namespace bouncelab::fuzz
