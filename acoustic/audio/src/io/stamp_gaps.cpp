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

constexpr std::size_t kAround = 8;         // blocks, some 0.2 s
constexpr double kLeastStep_s = 2e-3;      // stamps of Matroska are whole milliseconds
constexpr double kNearBlocks_s = 1e-3;     // to a whole number of blocks
constexpr double kLongestGap_s = 60.0;     // no ball flies so long
constexpr double kLongestOverlap_s = 1.0;  // of blocks that were written twice

}  // namespace

bool StampGap::is_jump() const { return stamped_s > kLongestGap_s || stamped_s < -kLongestOverlap_s; }

double StampGap::length_s() const { return is_jump() ? kLongestGap_s : stamped_s; }

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
    double length_s = *here - *(here - 1);
    const double n_blocks = block_s > 0.0 ? std::round(length_s / block_s) : 0.0;
    if (n_blocks != 0.0 && std::abs(length_s - n_blocks * block_s) < kNearBlocks_s) length_s = n_blocks * block_s;
    gaps.push_back({after_s, length_s});
  }
  return gaps;
}

void say_gaps(const std::vector<StampGap>& gaps, SoundInfo& info) {
  std::vector<std::string> texts;
  std::size_t n_filled = 0;
  double moved_s = 0.0, filled_s = 0.0, overlap_s = 0.0;
  for (const StampGap& gap : gaps) {
    const double begin_s = gap.after_s + moved_s, length_s = gap.length_s();
    moved_s += length_s;
    if (length_s < 0.0) {
      overlap_s -= length_s;
      continue;
    }
    info.silences.push_back({begin_s, begin_s + length_s});
    if (gap.is_jump()) {
      texts.push_back(
          formatted("its time stamps jump by %.0f s at %.4g s: %.0f s of silence stand for the jump, and the "
                    "times that follow are not those of its clock",
                    gap.stamped_s, begin_s, length_s));
    } else {
      filled_s += length_s;
      ++n_filled;
    }
  }
  if (n_filled > 0)
    texts.push_back(
        formatted("its time stamps have %zu gap%s, %.3g s in all, where sound is missing: its times are kept", n_filled,
                  n_filled == 1 ? "" : "s", filled_s));
  if (overlap_s > 0.0)
    texts.push_back(formatted("%.3g s of sound overlap by their time stamps: what came first was kept", overlap_s));
  for (const std::string& text : texts) info.warning += (info.warning.empty() ? "" : "; ") + text;
}

}  // namespace bouncelab::audio
