// SPDX-License-Identifier: GPL-3.0-or-later
#include "target.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define BOUNCELAB_COUNTS_ALLOCATIONS
#include <sanitizer/allocator_interface.h>
#endif
#endif
#ifndef BOUNCELAB_COUNTS_ALLOCATIONS
#include <sys/resource.h>
#endif

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

namespace {

// a thread of a library allocates too, but the readers have none
std::int64_t held = 0, most_held = 0, most_of_all = 0, limit = 0;

#ifdef BOUNCELAB_COUNTS_ALLOCATIONS
void on_allocation(const volatile void*, std::size_t size) {
  held += static_cast<std::int64_t>(size);
  most_held = std::max(most_held, held);
  if (limit > 0 && held > limit) {
    limit = 0;
    fail("memory stays below 10 times the input and 100 MB");
  }
}
void on_release(const volatile void* block) {
  if (block != nullptr) held -= static_cast<std::int64_t>(__sanitizer_get_allocated_size(const_cast<void*>(block)));
}
#else
std::int64_t most_of_process() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}
#endif

void print_most() { std::fprintf(stderr, "stat::peak_input_kb: %lld\n", static_cast<long long>(most_of_all / 1024)); }

/// Watches what is allocated while it lives: more than 10 times the input and 100 MB is a finding. With clang's
/// address sanitizer every allocation is seen as it is made; otherwise the growth of the process at the end.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t input_bytes) {
    [[maybe_unused]] static const bool once = [] {
#ifdef BOUNCELAB_COUNTS_ALLOCATIONS
      __sanitizer_install_malloc_and_free_hooks(on_allocation, on_release);
#endif
      std::atexit(print_most);
      return true;
    }();
#ifdef BOUNCELAB_COUNTS_ALLOCATIONS
    held = 0;
#else
    held = most_of_process();
#endif
    most_held = 0;
    limit = 10 * static_cast<std::int64_t>(input_bytes) + 100'000'000;
  }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
  ~MemoryLimit() {
#ifndef BOUNCELAB_COUNTS_ALLOCATIONS
    most_held = most_of_process() - held;
    require(most_held <= limit, "memory stays below 10 times the input and 100 MB");
#endif
    most_of_all = std::max(most_of_all, most_held);
    limit = 0;
  }
};

}  // namespace
}  // namespace bouncelab::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const bouncelab::fuzz::MemoryLimit limit(size);
  bouncelab::fuzz::run({data, size});
  return 0;
}
