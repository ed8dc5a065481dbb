// SPDX-License-Identifier: GPL-3.0-or-later
#include "usable_samples.hpp"

#include <cmath>

namespace bouncelab::fit {
namespace {

/// Why a sample cannot be used; empty: it can. The first flag names the reason.
std::string reason_to_leave_out(const RestitutionSample& s) {
  if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps)) return "not_finite";
  if (!(s.v_mps > 0.0)) return "speed_not_positive";
  return std::string(s.flags.first_word());
}

}  // namespace

RestitutionSamples usable_samples(const RestitutionSamples& samples, LeftOut& left_out) {
  RestitutionSamples used;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::string reason = reason_to_leave_out(samples[k]);
    if (reason.empty()) {
      used.push_back(samples[k]);
      continue;
    }
    ++left_out.n[reason];
    left_out.first.try_emplace(reason, k + 1);
  }
  return used;
}

}  // namespace bouncelab::fit
