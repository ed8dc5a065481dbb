// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace bouncelab {

/// The words of a title in small letters: letters, and whatever is not ASCII (the Greek mu).
std::vector<std::string> words_of(std::string_view title);
/// Is one of them time, in one of several languages?
bool names_time(std::string_view title);
/// Does it name what is computed of times, speeds or coefficients, or is known about them: "1-eps", "T^2 (s^2)", "1/T",
/// "half interval", "sigma_t", "contact time"? Or a unit with a factor, "(10^-3 s)"?
bool names_derived(std::string_view title);

}  // namespace bouncelab
