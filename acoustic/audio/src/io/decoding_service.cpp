// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/decoding_service.hpp"

#include <unistd.h>

#include <cstring>
#include <utility>

#include "io/sound_bytes.hpp"

namespace bouncelab::audio {
namespace {

/// SoundInfo but for its texts, which follow, each with a 0 at its end.
struct PlainInfo {
  double rate_hz;
  std::int32_t n_channels;
  std::int64_t n_frames;
  bool may_be_infinite, can_begin_anywhere;
  PlainEncoding plain;
  std::int64_t first_byte;
};

template <class T>
std::string bytes_of_plain(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

// the first byte of the answer to `open`
constexpr char kOpened = 'o';
constexpr char kNotForLibsndfile = 'n';  // the reason follows

// the answer to `read_piece`
constexpr const char* kRead = "";
constexpr const char* kNotInTwoParts = "n";

std::string message_of(const SoundInfo& info) {
  return bytes_of_plain(PlainInfo{info.rate_hz, info.n_channels, info.n_frames, info.may_be_infinite,
                                  info.can_begin_anywhere, info.plain, info.first_byte}) +
         info.description + '\0' + info.lossy_coding + '\0' + info.warning + '\0';
}

SoundInfo info_of(const std::string& message) {
  PlainInfo info{};
  std::memcpy(&info, message.data(), sizeof info);
  std::size_t at = sizeof info;
  const auto next_text = [&] {
    std::string text = message.c_str() + at;
    at += text.size() + 1;
    return text;
  };
  std::string description = next_text(), lossy_coding = next_text();
  return {info.rate_hz, info.n_channels, info.n_frames,          info.may_be_infinite,    info.can_begin_anywhere,
          info.plain,   info.first_byte, std::move(description), std::move(lossy_coding), next_text()};
}

}  // namespace

std::string bytes_of(const DecodingRequest& request) { return bytes_of_plain(request); }

SoundInfo opened_file(const std::string& answer, const std::string& name) {
  if (answer.at(0) != kOpened) throw NotForLibsndfile(name, answer.substr(1));
  return info_of(answer.substr(1));
}

bool has_read_piece(const std::string& answer) { return answer == kRead; }

std::string DecodingService::answer(std::string_view message, int descriptor) {
  DecodingRequest request;
  std::memcpy(&request, message.data(), sizeof request);
  switch (request.action) {
    case DecodingRequest::Action::open:
      return open(descriptor, std::string(message.substr(sizeof request)));
    case DecodingRequest::Action::read:
      return read(request.first, request.n_frames);
    case DecodingRequest::Action::read_piece:
      return read_piece(request.piece, request.in_two_parts);
    case DecodingRequest::Action::close:
      break;
  }
  return close();
}

std::string DecodingService::open(int descriptor, const std::string& name) {
  descriptor_ = descriptor;
  name_ = name;
  try {
    decoder_.emplace(SoundBytes(descriptor), name);
  } catch (const NotForLibsndfile& error) {
    close();
    return kNotForLibsndfile + error.reason;
  }
  std::string info = kOpened + message_of(decoder_->info());
  // the bytes of plain samples are read where they are needed
  if (decoder_->info().plain != PlainEncoding::none) close();
  return info;
}

std::string DecodingService::read(std::int64_t first, std::int64_t n_frames) {
  SoundDecoder& decoder = decoder_.value();
  decoder.read(first, samples_.first(static_cast<std::size_t>(n_frames * decoder.info().n_channels)));
  return {};
}

std::string DecodingService::read_piece(std::int64_t k, bool in_two_parts) {
  SoundDecoder& decoder = decoder_.value();
  const SoundInfo& info = decoder.info();
  if (k == 0) pieces_ = FilePieces(info.n_frames, info.n_channels, in_two_parts);
  if (in_two_parts) {
    if (!has_failed_in_two_ && read_both(k)) return kRead;
    if (!std::exchange(has_failed_in_two_, true)) {
      // as one decoder would have found it, from the beginning on
      second_.reset();
      decoder.begin_again();
    }
    return kNotInTwoParts;
  }
  const FilePieces::Piece piece = pieces_.of_first(k);
  decoder.read(piece.first, place_of(piece, info.n_channels, samples_));
  return kRead;
}

bool DecodingService::read_both(std::int64_t k) {
  SoundDecoder& decoder = decoder_.value();
  if (!second_) second_.emplace(descriptor_, name_, decoder.info(), pieces_, samples_);
  second_->ask_for(k);
  const FilePieces::Piece piece = pieces_.of_first(k);
  return decoder.read_without_error(piece.first, place_of(piece, decoder.info().n_channels, samples_)) &&
         second_->wait_for(k);
}

std::string DecodingService::close() {
  second_.reset();
  decoder_.reset();
  has_failed_in_two_ = false;
  ::close(descriptor_);
  return {};
}

}  // namespace bouncelab::audio
