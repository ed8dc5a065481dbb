// SPDX-License-Identifier: GPL-3.0-or-later
// What the columns of other people's tables are called, and what they hold.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab {

using Words = std::span<const std::string_view>;
bool has_word(std::string_view title, Words wanted);

/// Of the numbers of a column: how many rows have one, and whether they count 1, 2, 3 ... or 0, 1, 2 ..., of each drop
/// anew perhaps
struct Numbers {
  std::size_t n = 0;
  bool counts = true;
};

Numbers numbers_of(const ForeignTable& table, std::size_t column);

/// Empty where the table names none.
std::string title_of(const ForeignTable& table, std::size_t column);
/// For messages: its title, else its number from 1.
std::string column_name(const ForeignTable& table, std::size_t column);
std::string titles_in_words(const ForeignTable& table);
std::string format_in_words(const CellFormat& format, std::size_t n_columns);

/// "v=speed,eps=e" -> the column that is to be `key`; absent where the text does not say. @throws InvalidArgument,
/// FileError
std::optional<std::size_t> told_column(const ForeignTable& table, const ForeignOptions& options, std::string_view key,
                                       const std::string& name);
/// The column that is called as in tables of ours, which somebody saved again with other separators.
std::optional<std::size_t> own_column(const ForeignTable& table, const std::string& title);
/// Columns that have our names keep them, with their values.
void add_own_columns(const ForeignTable& foreign, const std::vector<ColumnSpec>& own, const std::string& name,
                     Table& table);

/// "Mean", "SD" below the values of a table.
bool is_summary(const ForeignTable::Row& row);
/// @throws FileError where a column is called ball, floor, material ... and has several of them
void check_one_ball(const ForeignTable& table, const std::string& name);

/// Digits behind the point of numbers in another unit, by their roundings: half of 10^-decimals each.
int decimals_of(const std::vector<double>& roundings, double unit);

/// Speeds and coefficients of restitution, rather than times?
bool holds_samples(const ForeignTable& table);

}  // namespace bouncelab
