// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "io/file_pieces.hpp"
#include "io/second_part_decoder.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {

/// What a process that decodes is asked for.
struct DecodingRequest {
  enum class Action : std::int32_t { open, read, read_piece, close };
  Action action = Action::open;
  std::int64_t first = 0, n_frames = 0;  ///< of read: to the begin of the shared memory
  std::int64_t piece = 0;                ///< of read_piece: to its place there
  bool in_two_parts = false;             ///< of read_piece
};

std::string bytes_of(const DecodingRequest& request);

/// The answer to `open`: what the file is, or why libsndfile cannot read it. @throws NotForLibsndfile
SoundInfo opened_file(const std::string& answer, const std::string& name);
/// The answer to `read_piece`: false where the file cannot be read in two parts, only in one from the beginning on.
bool has_read_piece(const std::string& answer);

/// What the process does: one file at a time.
class DecodingService {
 public:
  /// @param samples  in shared memory
  explicit DecodingService(std::span<float> samples) : samples_(samples) {}

  /// @param descriptor  of the file to open
  /// @throws FileError
  std::string answer(std::string_view message, int descriptor);

 private:
  std::string open(int descriptor, const std::string& name);
  std::string read(std::int64_t first, std::int64_t n_frames);
  std::string read_piece(std::int64_t k, bool in_two_parts);
  /// False where libsndfile sees an error in either part.
  bool read_both(std::int64_t k);
  std::string close();

  std::span<float> samples_;
  std::string name_;
  int descriptor_ = -1;
  std::optional<SoundDecoder> decoder_;
  std::optional<SecondPartDecoder> second_;
  FilePieces pieces_;
  bool has_failed_in_two_ = false;
};

}  // namespace bouncelab::audio
