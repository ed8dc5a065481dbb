// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/second_part_decoder.hpp"

#include <exception>
#include <utility>

#include "io/sound_bytes.hpp"

namespace bouncelab::audio {

SecondPartDecoder::SecondPartDecoder(int descriptor, std::string name, const SoundInfo& expected,
                                     const FilePieces& pieces, std::span<float> samples)
    : expected_(expected), pieces_(pieces), samples_(samples) {
  try {
    thread_ = std::thread([this, descriptor, name = std::move(name)] { decode(descriptor, name); });
  } catch (const std::exception&) {  // the system has no thread to give
    has_failed_ = true;
  }
}

SecondPartDecoder::~SecondPartDecoder() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void SecondPartDecoder::ask_for(std::int64_t k) {
  {
    const std::lock_guard lock(mutex_);
    n_asked_ = k + 1;
  }
  changed_.notify_all();
}

bool SecondPartDecoder::wait_for(std::int64_t k) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return has_failed_ || n_decoded_ > k; });
  return n_decoded_ > k;
}

void SecondPartDecoder::decode(int descriptor, const std::string& name) {
  bool is_good = false;
  try {
    SoundDecoder decoder(SoundBytes(descriptor), name);
    is_good = decoder.info().n_frames == expected_.n_frames && decoder.info().n_channels == expected_.n_channels;
    for (std::int64_t k = 0; is_good && k < pieces_.size(); ++k) {
      if (!wait_for_place(k)) return;
      is_good = decode_piece(decoder, k);
      const std::lock_guard lock(mutex_);
      if (is_good) n_decoded_ = k + 1;
      changed_.notify_all();
    }
  } catch (const std::exception&) {  // the first decoder will meet it too
    is_good = false;
  }
  const std::lock_guard lock(mutex_);
  has_failed_ |= !is_good;
  changed_.notify_all();
}

bool SecondPartDecoder::wait_for_place(std::int64_t k) {
  // of the pieces that were asked for the last kMostBegun may not be copied yet
  std::unique_lock lock(mutex_);
  changed_.wait(lock,
                [&] { return is_stopping_ || k < n_asked_ - FilePieces::kMostBegun + FilePieces::kPlacesOfSecond; });
  return !is_stopping_;
}

bool SecondPartDecoder::decode_piece(SoundDecoder& decoder, std::int64_t k) const {
  const FilePieces::Piece piece = pieces_.of_second(k);
  return decoder.read_without_error(piece.first, place_of(piece, expected_.n_channels, samples_));
}

}  // namespace bouncelab::audio
