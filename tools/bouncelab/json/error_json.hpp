// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace bouncelab::cli {

/// What --json prints of a command that failed: {"error": ..., "exit_code": ...}.
std::string error_json(const std::string& error, int exit_code);

/// The summary of a command whose result is not usable, with the same two keys.
/// @param json  an object, as text
std::string with_error(const std::string& json, const std::string& error, int exit_code);

}  // namespace bouncelab::cli
