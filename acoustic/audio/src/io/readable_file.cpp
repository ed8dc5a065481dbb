// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/readable_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"

namespace bouncelab::audio {

ReadableFile::ReadableFile(const std::filesystem::path& path) : name_(input_name(path)) {
  const std::filesystem::path content = readable(path);
  std::error_code error;
  if (std::filesystem::file_size(content, error) == 0 && !error)
    throw FileError(name_, "the file is empty (0 bytes); record again");
  descriptor_ = open(content.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw FileError(name_,
                    std::string("cannot be opened for reading (") + std::strerror(errno) + "); check its permissions");
}

ReadableFile::~ReadableFile() { close(descriptor_); }

}  // namespace bouncelab::audio
