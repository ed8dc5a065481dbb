// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/statistics.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <utility>

namespace bouncelab {

double order_statistic(std::vector<double> values, std::size_t rank) {
  assert(rank < values.size());
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return values.size() % 2 == 1 ? *middle : 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double upper_median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  return order_statistic(std::move(values), middle);
}

double quantile(std::span<const double> sorted, double p) {
  assert(!sorted.empty() && p >= 0.0 && p <= 1.0);
  const double at = p * (static_cast<double>(sorted.size()) - 1.0);
  const auto k = static_cast<std::size_t>(at);
  const double rest = at - static_cast<double>(k);
  return k + 1 < sorted.size() ? sorted[k] + rest * (sorted[k + 1] - sorted[k]) : sorted[k];
}

namespace {

constexpr std::uint64_t kSign = std::uint64_t{1} << 63;

/// In the order of the values: negative ones have all their bits turned round, the others their sign.
std::uint64_t key_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  return (bits & kSign) != 0 ? ~bits : bits | kSign;
}

double value_of(std::uint64_t key) { return std::bit_cast<double>((key & kSign) != 0 ? key & ~kSign : ~key); }

}  // namespace

StreamedMedian::StreamedMedian(std::filesystem::path folder, std::string name)
    : folder_(std::move(folder)), name_(std::move(name)) {}

void StreamedMedian::add(double value) {
  held_.push_back(value);
  if (held_.size() < kHeld) return;
  if (!stored_) stored_.emplace(folder_, name_);
  stored_->append({reinterpret_cast<const char*>(held_.data()), held_.size() * sizeof(double)});
  n_stored_ += held_.size();
  held_.clear();
}

template <class Use>
void StreamedMedian::for_each(Use use) const {
  for (std::size_t first = 0; first < n_stored_; first += kHeld) {
    const std::string bytes = stored_->at(static_cast<std::int64_t>(first * sizeof(double)), kHeld * sizeof(double));
    for (std::size_t k = 0; k < kHeld; ++k) {
      double value = 0.0;
      std::memcpy(&value, bytes.data() + k * sizeof value, sizeof value);
      use(value);
    }
  }
  for (const double value : held_) use(value);
}

/// By the digits of the keys, 16 bits each: which of the values begin as the one that is looked for.
double StreamedMedian::with_rank(std::size_t rank) const {
  constexpr int kDigit_bits = 16;
  std::uint64_t begin = 0;  // of its key: the digits known, then zeros
  for (int shift = 64 - kDigit_bits;; shift -= kDigit_bits) {
    const auto is_candidate = [&](std::uint64_t key) {
      return shift + kDigit_bits == 64 || (key ^ begin) >> (shift + kDigit_bits) == 0;
    };
    std::vector<std::size_t> counts(std::size_t{1} << kDigit_bits);
    for_each([&](double value) {
      const std::uint64_t key = key_of(value);
      if (is_candidate(key)) ++counts[(key >> shift) & 0xFFFF];
    });
    std::uint64_t digit = 0;
    for (; rank >= counts[digit]; ++digit) rank -= counts[digit];
    begin |= digit << shift;
    if (shift == 0) return value_of(begin);
    if (counts[digit] > kHeld) continue;
    std::vector<double> candidates;
    for_each([&](double value) {
      if ((key_of(value) ^ begin) >> shift == 0) candidates.push_back(value);
    });
    return order_statistic(std::move(candidates), rank);
  }
}

std::optional<double> StreamedMedian::median() const {
  const std::size_t n = n_stored_ + held_.size();
  if (n == 0) return std::nullopt;
  if (n_stored_ == 0) return bouncelab::median(held_);
  const double upper = with_rank(n / 2);
  return n % 2 == 1 ? upper : 0.5 * (upper + with_rank(n / 2 - 1));
}

}  // namespace bouncelab
