// SPDX-License-Identifier: GPL-3.0-or-later
// A value with its standard error, as it is printed.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace bouncelab::cli {

/// "0.98169 ± 0.00004": two digits of the standard error and as many of the value as it warrants; six significant
/// digits where there is no standard error.
inline std::string measured(double value, std::optional<double> se) {
  if (!se || !(*se > 0.0) || !std::isfinite(*se)) return fmt::format("{:.6g}", value);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(*se))), 0, 12);
  return fmt::format("{:.{}f} ± {:.{}f}", value, decimals, *se, decimals);
}

}  // namespace bouncelab::cli
