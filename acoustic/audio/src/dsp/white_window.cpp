// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp/white_window.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kWhiteBlock =
    256;  // samples; shorter ones would cost more calls, longer ones more at windows' ends
constexpr std::int64_t kNoBlock = std::numeric_limits<std::int64_t>::min();

/// Rounded down, also below 0.
std::int64_t block_of(std::int64_t sample) { return (sample >= 0 ? sample : sample - (kWhiteBlock - 1)) / kWhiteBlock; }

}  // namespace

WhiteWindow read_white(const AudioSource& source, const std::vector<float>& whitener, std::int64_t first,
                       std::size_t n) {
  WhiteWindow window{first, std::vector<float>(n)};
  read_innovations(source, {whitener, 0.0}, first, window.sound);
  return window;
}

WhiteSound::WhiteSound(const AudioSource& source, const std::vector<float>& whitener, std::size_t n_kept)
    : source_(source),
      model_{whitener, 0.0},
      numbers_(n_kept / kWhiteBlock + 2, kNoBlock) {}  // a window's ends lie in blocks

void WhiteSound::read(std::int64_t first, std::span<float> out) {
  if (out.empty()) return;
  const auto n_slots = std::ssize(numbers_);
  const std::int64_t end = first + std::ssize(out);
  assert(block_of(end - 1) - block_of(first) < n_slots);
  kept_.resize(numbers_.size() * kWhiteBlock);  // at the first use
  const auto slot_of = [&](std::int64_t block) { return (block % n_slots + n_slots) % n_slots; };
  make_blocks(block_of(first), block_of(end - 1) + 1);
  for (std::int64_t at = first; at < end;) {
    const std::int64_t block = block_of(at);
    const std::int64_t to = std::min(end, (block + 1) * kWhiteBlock);
    std::copy_n(kept_.begin() + slot_of(block) * kWhiteBlock + (at - block * kWhiteBlock), to - at,
                out.begin() + (at - first));
    at = to;
  }
}

void WhiteSound::make_blocks(std::int64_t first, std::int64_t last) {
  const auto n_slots = std::ssize(numbers_);
  const auto slot_of = [&](std::int64_t block) { return (block % n_slots + n_slots) % n_slots; };
  for (std::int64_t block = first; block < last;) {
    const std::int64_t slot = slot_of(block);
    std::int64_t n = 0;  // missing ones that lie side by side
    for (; block + n < last && slot + n < n_slots && numbers_[static_cast<std::size_t>(slot + n)] != block + n; ++n)
      numbers_[static_cast<std::size_t>(slot + n)] = block + n;
    if (n > 0)  // most are there
      read_innovations(source_, model_, block * kWhiteBlock,
                       std::span(kept_).subspan(static_cast<std::size_t>(slot * kWhiteBlock),
                                                static_cast<std::size_t>(n * kWhiteBlock)));
    block += std::max<std::int64_t>(n, 1);
  }
}

}  // namespace bouncelab::audio
