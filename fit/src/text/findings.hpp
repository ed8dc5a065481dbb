// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/fit.hpp"
#include "usable_samples.hpp"

namespace bouncelab::fit {

/// "air drag is not taken out, and its shift of eps is open: no ball was named (--ball)"; empty where nothing is open.
std::string open_corrections(const ErrorBudget& budget);
/// Likewise of the fit with memory, which needs a radius and a moment of inertia.
std::string open_without_ball(const MemoryFit& memory);

/// What a user must know before using the result, most important first.
/// @param used  the samples that were fitted
std::vector<std::string> warnings_of(const FitResult& result, const RestitutionSamples& used);

/// Of the samples alone, whatever is fitted to them.
std::vector<std::string> warnings_of(const RestitutionSamples& used, const LeftOut& left_out);

/// The questions that a reader brings (five; with several recordings whether they agree, with memory whether the
/// fluctuations remember), answered in a sentence or two from the numbers of the result.
std::vector<Finding> findings_of(const FitResult& result);

}  // namespace bouncelab::fit
