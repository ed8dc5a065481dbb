// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace bouncelab::cli {

/// JSON as text, which is valid whatever the texts in it are: in names of files that are not UTF-8, each byte that is
/// not becomes U+FFFD.
/// @param indent  -1: one line
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace bouncelab::cli
