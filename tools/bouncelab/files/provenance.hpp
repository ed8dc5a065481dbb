// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "command.hpp"

namespace bouncelab::cli {

/// SHA-256 of a file's content, in hexadecimal. @throws FileError
std::string sha256_of_file(const std::filesystem::path& path);

/// Writes OUTPUT.meta.json beside an output: command line, version, commit, seed, inputs with their SHA-256, and
/// all parameters as resolved.
void write_provenance(const Run& run, const std::filesystem::path& output,
                      const std::vector<std::filesystem::path>& inputs = {});

}  // namespace bouncelab::cli
