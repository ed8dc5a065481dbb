// SPDX-License-Identifier: GPL-3.0-or-later
#include "whitening/white_window.hpp"

#include <algorithm>
#include <cassert>

namespace bouncelab::detection {
namespace {

constexpr std::int64_t kWhiteBlock =
    256;  // samples; shorter ones would cost more calls, longer ones more at windows' ends
constexpr std::int64_t kMostBlocksOfAWindow = (1 << 17) / kWhiteBlock + 2;  // a window's ends lie in blocks
constexpr std::int64_t kPlacesOfKept = 4;  // places for each block kept, of which few are wanted by two blocks then
constexpr std::int32_t kNoPlace = -1;

/// Rounded down, also below 0.
std::int64_t block_of(std::int64_t sample) { return (sample >= 0 ? sample : sample - (kWhiteBlock - 1)) / kWhiteBlock; }

}  // namespace

WhiteSound::WhiteSound(const audio::AudioSource& source)
    : source_(source),
      memory_(new float[kMostBlocksOfAWindow * kWhiteBlock]),  // holds anything yet
      places_(kPlacesOfKept * kMostBlocksOfAWindow, kNoPlace) {}

void WhiteSound::read(const std::vector<float>& whitener, std::int64_t first, std::span<float> out) {
  if (out.empty()) return;
  const std::int64_t end = first + std::ssize(out);
  const std::int64_t first_block = block_of(first), last_block = block_of(end - 1) + 1;
  assert(last_block - first_block <= kMostBlocksOfAWindow);
  if (whitener != model_.filter || last_block - first_block > kMostBlocksOfAWindow - std::ssize(numbers_)) {
    model_.filter = whitener;
    std::fill(places_.begin(), places_.end(), kNoPlace);
    numbers_.clear();
  }
  make_blocks(first_block, last_block);
  for (std::int64_t at = first; at < end;) {
    const std::int64_t block = block_of(at);
    const std::int64_t to = std::min(end, (block + 1) * kWhiteBlock);
    std::copy_n(memory_.get() + place(block) * kWhiteBlock + (at - block * kWhiteBlock), to - at,
                out.begin() + (at - first));
    at = to;
  }
}

std::int32_t& WhiteSound::place(std::int64_t block) {
  const auto n = std::ssize(places_);
  return places_[static_cast<std::size_t>((block % n + n) % n)];
}

bool WhiteSound::is_there(std::int64_t block) {
  const std::int32_t k = place(block);
  return k != kNoPlace && numbers_[static_cast<std::size_t>(k)] == block;
}

void WhiteSound::make_blocks(std::int64_t first, std::int64_t last) {
  for (std::int64_t block = first; block < last;) {
    const std::int64_t at = std::ssize(numbers_) * kWhiteBlock;
    std::int64_t n = 0;  // missing ones that lie side by side
    for (; block + n < last && !is_there(block + n); ++n) {
      place(block + n) = static_cast<std::int32_t>(numbers_.size());
      numbers_.push_back(block + n);
    }
    if (n > 0)  // most are there
      read_innovations(source_, model_, block * kWhiteBlock,
                       {memory_.get() + at, static_cast<std::size_t>(n * kWhiteBlock)});
    block += std::max<std::int64_t>(n, 1);
  }
}

}  // namespace bouncelab::detection
