// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "command.hpp"

namespace bouncelab::cli {

/// SHA-256 of a file's content, in hexadecimal; computed once, unless the file changes. From any thread.
/// @throws FileError, Interrupted
std::string sha256_of_file(const std::filesystem::path& path);

/// OUTPUT.meta.json; where that name would be longer than 255 bytes, OUTPUT is cut, and ends with ~ and the first eight
/// digits of the SHA-256 of the whole.
std::filesystem::path provenance_path(const std::filesystem::path& output);

/// Writes the provenance beside an output: command line, version, commit, seed, inputs with their SHA-256, and
/// all parameters as resolved. None of an output that is a stream.
void write_provenance(const Run& run, const std::filesystem::path& output,
                      const std::vector<std::filesystem::path>& inputs = {});

}  // namespace bouncelab::cli
