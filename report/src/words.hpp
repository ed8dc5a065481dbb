// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/report/answer.hpp"

namespace bouncelab::report {

/// "air drag is not taken out, and its shift of eps is open: no ball was named (--ball)"; empty where nothing is open.
std::string open_corrections(const fit::ErrorBudget& budget);

std::vector<std::string> warnings_of(const fit::FitResult& result, const RestitutionSamples& samples);
PlainAnswer plain_answer(const fit::FitResult& result, const RestitutionSamples& samples);
/// The questions that a reader brings (five; with several recordings whether they agree, with memory whether the
/// fluctuations remember), answered in a sentence or two from the numbers of the result.
std::vector<Finding> findings_of(const fit::FitResult& result);

}  // namespace bouncelab::report
