// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace bouncelab {

/// An input's name in messages, tables and provenance: "standard input" for "-", else the path as it was given.
std::string input_name(const std::filesystem::path& path);

/// A path under which the content of an input can be opened as often as wanted, and read at any place. That is `path`
/// itself where it leads to a regular file. What can be read only once (a pipe, a FIFO, /dev/stdin, "-") is copied at
/// the first call for it to a temporary file without a name, in TMPDIR or /tmp, which lasts as long as the process.
/// Every reader opens its file by this; from any thread.
/// @throws FileError where there is no such file, it is a folder or a device without end, or cannot be read or copied;
///         Interrupted
std::filesystem::path readable(const std::filesystem::path& path);

}  // namespace bouncelab
