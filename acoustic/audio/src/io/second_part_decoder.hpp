// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <thread>

#include "io/file_pieces.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {

/// Decodes the second part of a file on a thread of its own, as far ahead as there are places for the pieces.
class SecondPartDecoder {
 public:
  /// @param descriptor  of the file, which stays the caller's
  /// @param expected    of the first part's decoder
  /// @param samples     where the places are
  SecondPartDecoder(int descriptor, std::string name, const SoundInfo& expected, const FilePieces& pieces,
                    std::span<float> samples);
  SecondPartDecoder(const SecondPartDecoder&) = delete;
  SecondPartDecoder& operator=(const SecondPartDecoder&) = delete;
  ~SecondPartDecoder();

  /// The pieces up to k - kMostBegun have been copied.
  void ask_for(std::int64_t k);
  /// Waits until piece k, which was asked for, is in its place. False where libsndfile saw an error there or before.
  bool wait_for(std::int64_t k);

 private:
  void decode(int descriptor, const std::string& name);
  /// Waits for the place of piece k. False where nobody wants it any more.
  bool wait_for_place(std::int64_t k);
  bool decode_piece(SoundDecoder& decoder, std::int64_t k) const;

  SoundInfo expected_;
  FilePieces pieces_;
  std::span<float> samples_;

  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::int64_t n_asked_ = 0, n_decoded_ = 0;  // pieces
  bool has_failed_ = false, is_stopping_ = false;
  std::thread thread_;
};

}  // namespace bouncelab::audio
