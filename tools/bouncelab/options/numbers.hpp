// SPDX-License-Identifier: GPL-3.0-or-later
/// Numbers on the command line and in configuration files: decimal, finite, in a range that is stated.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace bouncelab::cli {

/// A range of real numbers, both ends in it. For an option of one real, or of several of them.
CLI::Validator within(double lo, double hi);

/// A range of integers, both ends in it.
CLI::Validator within(std::int64_t lo, std::int64_t hi);
CLI::Validator within(int lo, int hi);

/// An option whose value is a list: "0.09,0.10". Given again, the last list counts, as a whole.
/// @param shape   what stands in --help: "X,Y"
/// @param values  its content is the default
/// @param lo, hi  range of each number
CLI::Option* add_list(CLI::App& app, const std::string& name, std::vector<double>& values, const std::string& shape,
                      std::size_t n_min, std::size_t n_max, double lo, double hi, const std::string& help);

/// What CLI11 says of an option's value: "INT:1 to 10" -> {"INT", "1 to 10"}
std::pair<std::string, std::string> type_and_range(const CLI::Option& option);

/// Is this an option of add_list?
bool takes_list(const CLI::Option& option);

/// Makes every option of numbers read them in one way: integers in decimal, "010" is ten; reals in decimal, finite.
/// Hexadecimal and octal prefixes, nan, inf and what does not fit are refused. To be called after all options were
/// added.
void read_numbers_in_decimal(CLI::App& app);

}  // namespace bouncelab::cli
