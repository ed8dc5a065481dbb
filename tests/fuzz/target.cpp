// SPDX-License-Identifier: GPL-3.0-or-later
#include "target.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "memory_limit.hpp"

namespace bouncelab::fuzz {

void fail(std::string_view promise, std::string_view what) {
  std::fprintf(stderr, "does not hold: %.*s%s%.*s\n", static_cast<int>(promise.size()), promise.data(),
               what.empty() ? "" : ": ", static_cast<int>(std::min<std::size_t>(what.size(), 2000)), what.data());
  std::fflush(stderr);
  std::abort();
}

void check_message(std::string_view message) {
  // of UTF-8: bytes that continue a character are not counted
  const auto n_characters = std::count_if(message.begin(), message.end(),
                                          [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; });
  if (message.empty() || n_characters > 1000) fail("a message has 1 to 1,000 characters", message);
  const bool clean = std::none_of(message.begin(), message.end(), [](unsigned char c) { return c < 32 || c == 127; });
  if (!clean) fail("a message has no control characters", message);
}

}  // namespace bouncelab::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const bouncelab::fuzz::MemoryLimit limit(size);
  bouncelab::fuzz::run({data, size});
  return 0;
}
