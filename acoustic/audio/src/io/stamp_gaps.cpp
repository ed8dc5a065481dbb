// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/stamp_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::size_t kAround = 8;      // blocks, some 0.2 s
constexpr double kLeastStep_s = 2e-3;   // stamps of Matroska are whole milliseconds
constexpr double kNearBlocks_s = 1e-3;  // to a whole number of blocks
constexpr double kLongestGap_s = 60.0;  // no ball flies so long: a longer one is a stamp gone wrong, or a pause

}  // namespace

std::vector<StampGap> gaps_between(const std::vector<StampedBlock>& blocks) {
  std::vector<double> ahead_s;  // of the lengths before
  double sum_s = 0.0;
  for (const StampedBlock& block : blocks) {
    ahead_s.push_back(block.begin_s - sum_s);
    sum_s += block.length_s;
  }
  std::vector<double> lengths_s;
  for (const StampedBlock& block : blocks) lengths_s.push_back(block.length_s);
  const double block_s = lengths_s.empty() ? 0.0 : median(lengths_s);
  std::vector<StampGap> gaps;
  double after_s = 0.0;
  for (std::size_t k = 1; k < blocks.size(); ++k) {
    after_s += blocks[k - 1].length_s;
    const auto here = ahead_s.begin() + static_cast<std::ptrdiff_t>(k);
    const auto begin = ahead_s.begin() + static_cast<std::ptrdiff_t>(k - std::min(k, kAround));
    const auto end = here + static_cast<std::ptrdiff_t>(std::min(blocks.size() - k, kAround));
    const auto [least_before, most_before] = std::minmax_element(begin, here);
    const auto [least_after, most_after] = std::minmax_element(here, end);
    const bool ahead = *least_after - *most_before > kLeastStep_s, back = *most_after - *least_before < -kLeastStep_s;
    if (!ahead && !back) continue;
    // a gap that follows at once raises the later ones of those after it: the nearest few are this one's
    double length_s = std::clamp(*here - *(here - 1), -kLongestGap_s, kLongestGap_s);
    const double n_blocks = block_s > 0.0 ? std::round(length_s / block_s) : 0.0;
    if (n_blocks != 0.0 && std::abs(length_s - n_blocks * block_s) < kNearBlocks_s) length_s = n_blocks * block_s;
    gaps.push_back({after_s, length_s});
  }
  return gaps;
}

void say_gaps(const std::vector<StampGap>& gaps, SoundInfo& info) {
  if (gaps.empty()) return;
  double moved_s = 0.0, filled_s = 0.0, overlap_s = 0.0;
  for (const StampGap& gap : gaps) {
    if (gap.length_s > 0.0) {
      const double begin_s = gap.after_s + moved_s;
      info.silences.push_back({begin_s, begin_s + gap.length_s});
      filled_s += gap.length_s;
    } else {
      overlap_s -= gap.length_s;
    }
    moved_s += gap.length_s;
  }
  std::string text;
  if (filled_s > 0.0)
    text = formatted("its time stamps have %zu gap%s, %.3g s in all, where sound is missing: its times are kept",
                     info.silences.size(), info.silences.size() == 1 ? "" : "s", filled_s);
  if (overlap_s > 0.0)
    text += formatted("%s%.3g s of sound overlap by their time stamps: what came first was kept",
                      text.empty() ? "" : "; ", overlap_s);
  info.warning += (info.warning.empty() ? "" : "; ") + text;
}

}  // namespace bouncelab::audio
