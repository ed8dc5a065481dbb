// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "bouncelab/core/table.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// Reads the wanted columns from a table file; the extension chooses the format. @throws FileError
Table read_table(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);

/// Writes a table whole or not at all, and its provenance beside it. @throws FileError
void write_table(const Run& run, const std::filesystem::path& path, const Table& table,
                 const std::vector<std::filesystem::path>& inputs = {});

/// Writes a text (JSON, HTML ...) whole or not at all, and its provenance beside it. @throws FileError
void write_text(const Run& run, const std::filesystem::path& path, const std::string& content,
                const std::vector<std::filesystem::path>& inputs = {});

/// Creates the folder where it is missing. @throws FileError where that cannot be, or nothing can be written in it
void make_output_folder(const std::filesystem::path& folder);

/// Throws FileError where the output exists and --force was not said: asked before the work, not after it.
void check_may_write(const Run& run, const std::filesystem::path& path);

}  // namespace bouncelab::cli
