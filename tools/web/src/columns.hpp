// SPDX-License-Identifier: GPL-3.0-or-later
/// Tables as JavaScript has them: an object of arrays, one a column. Numbers are Float64Arrays, NaN where one is not
/// known; texts are arrays of strings.
#pragma once

#include <emscripten/val.h>

#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab::web {

emscripten::val columns_of(const Table& table);
/// @param wanted  columns that are taken, where they are there
/// @throws InvalidArgument where columns have not the same length, or an integer is none
Table table_of(const emscripten::val& columns, const std::vector<ColumnSpec>& wanted, const std::string& what);

}  // namespace bouncelab::web
