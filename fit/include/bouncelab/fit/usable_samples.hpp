// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"

namespace bouncelab::fit {

/// Samples that were left out, by reason: how many, and the number of the first, from 1.
struct LeftOut {
  std::map<std::string, std::size_t> n, first;
};

/// Samples without those that are left out: a copy only where there are such, since a sample is some hundred bytes.
class PartOfSamples {
 public:
  /// @param all       must outlive this
  /// @param left_out  indices, increasing
  PartOfSamples(const RestitutionSamples& all, const std::vector<std::size_t>& left_out);
  const RestitutionSamples& operator*() const { return part_ ? *part_ : all_; }
  const RestitutionSamples* operator->() const { return &**this; }

 private:
  const RestitutionSamples& all_;
  std::optional<RestitutionSamples> part_;
};

/// Those without a flag, finite, with v > 0 and flights longer than the contacts of a named ball, in their order.
/// @param samples  must outlive the result
PartOfSamples usable_samples(const RestitutionSamples& samples, LeftOut& left_out);

}  // namespace bouncelab::fit
