// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/strike_ringing.hpp"

#include <algorithm>
#include <utility>

namespace bouncelab::synthesis {
namespace {

void add_to(PoleValues& sum, const PoleValues& part) {
  for (std::size_t p = 0; p < sum.size(); ++p) sum.set(p, sum[p] + part[p]);
}

}  // namespace

void StrikeRinging::add(ContactWave wave) {
  if (wave.end() > at_) return waves_.push_back(std::move(wave));
  bank_.advance(wave.ringing, at_ - wave.end());
  add_to(state_, wave.ringing);
}

template <class T>
void StrikeRinging::add_next(std::span<T> out) {
  const std::int64_t first = at_, end = first + static_cast<std::int64_t>(out.size());
  for (const ContactWave& wave : waves_)
    for (std::int64_t k = std::max(wave.first, first); k < std::min(wave.end(), end); ++k)
      out[static_cast<std::size_t>(k - first)] +=
          static_cast<T>(wave.samples[static_cast<std::size_t>(k - wave.first)]);
  ring(out);
}

template <class T>
void StrikeRinging::ring(std::span<T> out) {
  while (!out.empty()) {
    // waves of contacts that follow one another closely need not end in their order
    std::int64_t until = at_ + static_cast<std::int64_t>(out.size());
    for (const ContactWave& wave : waves_) {
      if (wave.end() == at_) add_to(state_, wave.ringing);
      if (wave.end() > at_) until = std::min(until, wave.end());
    }
    std::erase_if(waves_, [this](const ContactWave& wave) { return wave.end() <= at_; });
    const auto n = static_cast<std::size_t>(until - at_);
    bank_.ring(state_, silence_, out.first(n));
    out = out.subspan(n);
    at_ = until;
  }
}

template void StrikeRinging::add_next(std::span<float>);
template void StrikeRinging::add_next(std::span<double>);

}  // namespace bouncelab::synthesis
