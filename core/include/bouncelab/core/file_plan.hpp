// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

namespace bouncelab {

/// To be called before any work with all files of it: what would destroy something, or come to nothing in the end, is
/// refused now. Empty paths are passed over.
///
/// No output may be an input or another output, by any name or link; it must be a file that may be replaced, a new name
/// in a folder that can be written, or a stream (see OutputFile). A stream can be read once only, and is read here (see
/// readable()).
/// @param inputs   files to be read; one that is missing is left to its reader
/// @param outputs  files to be written; several may go to /dev/null
/// @param beside   further outputs that are replaced where they exist (NAME.meta.json)
/// @throws InvalidArgument where two of them are the same file; FileExists, FileError as OutputFile and readable() do
void check_files(const std::vector<std::filesystem::path>& inputs, const std::vector<std::filesystem::path>& outputs,
                 const std::vector<std::filesystem::path>& beside, bool may_replace);

}  // namespace bouncelab
