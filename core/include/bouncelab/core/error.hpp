// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cerrno>
#include <stdexcept>
#include <string>
#include <string_view>

#include "bouncelab/core/text.hpp"

namespace bouncelab {

/// What went wrong, in one line that names the quantity or file, the place, the value and the remedy.
/// Thrown for broken contracts and unreadable input; caught only in main. Results that are merely poor are
/// data (a status beside the numbers), never an exception.
/// The message is printable(): it may quote names and cells of any length and content.
class Error : public std::runtime_error {
 public:
  explicit Error(std::string_view message) : std::runtime_error(printable(message, kMessage_characters)) {}
};

/// An argument is outside its stated range. The command line answers with exit code 2.
class InvalidArgument : public Error {
 public:
  using Error::Error;
};

/// A file cannot be read, written or understood. Exit code 3.
class FileError : public Error {
 public:
  /// @param path    the file as the user named it
  /// @param what    place and reason, without the path ("line 7, column t_s: 'abc' is not a number")
  /// @param error   errno, where the system refused the file
  FileError(const std::string& path, const std::string& what, int error = 0)
      : Error(printable(path) + ": " + what), path_(path), reason_(what), error_(error) {}

  const std::string& path() const noexcept { return path_; }
  const std::string& reason() const noexcept { return reason_; }
  /// As errno has it: ENOENT, EACCES ...; 0 where the system did not refuse the file.
  int system_error() const noexcept { return error_; }

 private:
  std::string path_, reason_;
  int error_;
};

/// A file that is to be written exists, and may not be replaced.
class FileExists : public FileError {
 public:
  explicit FileExists(const std::string& path) : FileError(path, "exists already", EEXIST) {}
};

/// The user (Ctrl-C) or the system asked to stop. Thrown by progress callbacks; unfinished outputs vanish.
class Interrupted : public Error {
 public:
  Interrupted() : Error("interrupted; nothing was left half-written") {}
};

}  // namespace bouncelab
