// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/usable_samples.hpp"

#include <cmath>
#include <string_view>

namespace bouncelab::fit {
namespace {

/// Why a sample cannot be used; empty: it can. The first flag names the reason.
std::string_view reason_to_leave_out(const RestitutionSample& s) {
  if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps)) return "not_finite";
  if (!(s.v_mps > 0.0)) return "speed_not_positive";
  return s.flags.first_word();
}

}  // namespace

PartOfSamples usable_samples(const RestitutionSamples& samples, LeftOut& left_out) {
  std::vector<std::size_t> unusable;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::string_view reason = reason_to_leave_out(samples[k]);
    if (reason.empty()) continue;
    unusable.push_back(k);
    ++left_out.n[std::string(reason)];
    left_out.first.try_emplace(std::string(reason), k + 1);
  }
  return {samples, unusable};
}

PartOfSamples::PartOfSamples(const RestitutionSamples& all, const std::vector<std::size_t>& left_out) : all_(all) {
  if (left_out.empty()) return;
  part_.emplace();
  part_->reserve(all.size() - left_out.size());
  auto next = left_out.begin();
  for (std::size_t k = 0; k < all.size(); ++k)
    if (next != left_out.end() && *next == k)
      ++next;
    else
      part_->push_back(all[k]);
}

}  // namespace bouncelab::fit
