// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/two_part_decoder.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "io/sound_bytes.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kSamplesAtOnce = 1 << 15;

}  // namespace

TwoPartDecoder::TwoPartDecoder(SoundDecoder& first, int descriptor, std::string name, SharedMemory& memory)
    : first_(first),
      name_(std::move(name)),
      memory_(memory),
      n_channels_(first.info().n_channels),
      n_frames_(first.info().n_frames),
      middle_(n_frames_ / 2),
      n_second_(middle_) {
  try {
    second_ = std::thread([this, descriptor] { decode_second_half(descriptor); });
  } catch (const std::exception&) {  // the system has no thread to give
    is_alone_ = true;
  }
}

TwoPartDecoder::~TwoPartDecoder() { stop(); }

void TwoPartDecoder::stop() {
  {
    const std::lock_guard lock(mutex_);
    has_failed_ = true;
  }
  if (second_.joinable()) second_.join();
}

void TwoPartDecoder::read_until(std::int64_t end) {
  if (is_alone_) return go_on_alone(end);
  const std::int64_t end_here = std::min(end, middle_);
  if (end_here > n_first_) {
    if (!first_.read_without_error(n_first_, part(n_first_, end_here))) {
      // as one decoder would have found it, from the beginning on
      stop();
      is_alone_ = true;
      first_.begin_again();
      n_first_ = 0;
      return go_on_alone(end);
    }
    n_first_ = end_here;
  }
  if (end <= middle_ || is_second_there(end)) return;
  stop();
  is_alone_ = true;
  go_on_alone(end);
}

void TwoPartDecoder::go_on_alone(std::int64_t end) {
  if (end <= n_first_) return;
  first_.read(n_first_, part(n_first_, end));
  n_first_ = end;
}

std::span<float> TwoPartDecoder::part(std::int64_t first, std::int64_t end) const {
  const std::span<float> here{reinterpret_cast<float*>(memory_.bytes().data()) + first * n_channels_,
                              static_cast<std::size_t>((end - first) * n_channels_)};
  memory_.populate(std::as_bytes(here));
  return here;
}

void TwoPartDecoder::decode_second_half(int descriptor) {
  bool is_good = false;
  try {
    SoundDecoder decoder(SoundBytes(descriptor), name_);
    is_good = decoder.info().n_frames == n_frames_ && decoder.info().n_channels == n_channels_;
    const std::int64_t n_piece = std::max<std::int64_t>(1, kSamplesAtOnce / n_channels_);
    for (std::int64_t at = middle_; is_good && at < n_frames_; at = std::min(at + n_piece, n_frames_)) {
      const std::int64_t end = std::min(at + n_piece, n_frames_);
      is_good = decoder.read_without_error(at, part(at, end));
      const std::lock_guard lock(mutex_);
      if (has_failed_) return;
      if (is_good) n_second_ = end;
      changed_.notify_all();
    }
  } catch (const std::exception&) {  // the first decoder will meet it too
    is_good = false;
  }
  const std::lock_guard lock(mutex_);
  has_failed_ |= !is_good;
  changed_.notify_all();
}

bool TwoPartDecoder::is_second_there(std::int64_t end) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return has_failed_ || n_second_ >= end; });
  return n_second_ >= end;
}

}  // namespace bouncelab::audio
