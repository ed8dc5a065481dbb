// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"

namespace bouncelab::report {

/// "0.947 to 0.951": the 95 % interval, which must be there.
std::string interval_in_words(const fit::Estimate& e);
/// "0.0069": two digits, without a power of ten.
std::string two_digits(double x);
/// What was measured: "times", "heights" or "speeds".
const char* measured_in_words(const SampleConditions& conditions);
PlainAnswer plain_answer(const fit::FitResult& result, const RestitutionSamples& samples);
/// Two balls, or two floors, which nothing but the drops tells apart.
Note note_of(const fit::KindsOfDrops& kinds);
/// Absent where they agree, or cannot be compared.
std::optional<Note> note_of_difference(const fit::Recordings& recordings);
/// Speed, air and roughness, the largest that is seen first; none without an answer.
std::vector<Cause> causes_of(const fit::FitResult& result, const PlainAnswer& answer,
                             const RestitutionSamples& samples);
/// The questions that a reader brings (five; with several recordings whether they agree, with memory whether the
/// fluctuations remember), answered in a sentence or two from the numbers of the result.
std::vector<Finding> findings_of(const fit::FitResult& result, const SampleConditions& conditions);

}  // namespace bouncelab::report
