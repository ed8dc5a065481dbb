// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace bouncelab::cli {

/// JSON as text, which is valid whatever the texts in it are: in names of files that are not UTF-8, each byte that is
/// not becomes U+FFFD.
/// @param indent  -1: one line
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

/// What --json prints of a command that failed: {"error": ..., "exit_code": ...}.
std::string error_json(const std::string& error, int exit_code);

/// The summary of a command whose result is not usable, with the same two keys.
/// @param json  an object, as text
std::string with_error(const std::string& json, const std::string& error, int exit_code);

}  // namespace bouncelab::cli
