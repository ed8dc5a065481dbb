// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "bouncelab/fit/fit.hpp"

namespace bouncelab::loop {

// Parts of a FitResult; null where it does not have them. Speeds agree to within 1e-9 m/s.
const fit::NodeEstimate* node_at(const fit::FitResult& fit, double v_mps);
const fit::HistogramFit* window_at(const fit::FitResult& fit, double v_mps);
/// The window at this speed that has both slopes.
const fit::HistogramFit* window_with_slopes(const fit::FitResult& fit, double v_mps);
const fit::Estimate* parameter_named(const fit::FitResult& fit, std::string_view name);

}  // namespace bouncelab::loop
