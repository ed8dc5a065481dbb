// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace bouncelab::stages {

/// A file of a fit that states another eps than this version is not used.
/// @param content  fit.json
/// @param path     its name
/// @throws FileError where it was written before 0.3, when eps was the most frequent one
void refuse_older_fit(const std::string& content, const std::string& path);

/// Is this a fit.json, of whatever version? What is not text that can be read is none.
bool is_fit(const std::string& content);

}  // namespace bouncelab::stages
