// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace bouncelab {

/// The value with `rank` values before it in ascending order.
/// @param values  without NaN, in any order; more than `rank` of them
double order_statistic(std::vector<double> values, std::size_t rank);

/// The middle one of the values in ascending order; of an even number the mean of the two in the middle.
/// @param values  without NaN, in any order; at least one
double median(std::vector<double> values);

/// The middle one of the values in ascending order; of an even number the larger of the two in the middle, so that it
/// is always one of the values.
/// @param values  without NaN, in any order; at least one
double upper_median(std::vector<double> values);

/// The p-quantile, interpolated linearly between the values next to rank p (n - 1). Source: Hyndman & Fan, Am. Stat.
/// 50, 361 (1996), definition 7; doi:10.1080/00031305.1996.10473566.
/// @param sorted  ascending; at least one
/// @param p       0 to 1
double quantile(std::span<const double> sorted, double p);

}  // namespace bouncelab
