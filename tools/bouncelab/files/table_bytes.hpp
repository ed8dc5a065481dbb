// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "bouncelab/core/table.hpp"

namespace bouncelab::cli {

/// The columns of a table as bytes for another process of this program; lines are left out.
std::string to_bytes(const Table& table);
/// @param bytes  of to_bytes
Table table_from_bytes(std::string_view bytes);

}  // namespace bouncelab::cli
