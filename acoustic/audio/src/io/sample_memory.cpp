// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sample_memory.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <new>

namespace bouncelab::audio {
namespace {

constexpr std::size_t kLargePage_bytes = std::size_t{1} << 21;

}  // namespace

SampleMemory sample_memory(std::size_t n) {
  const std::size_t n_bytes = std::max<std::size_t>(n, 1) * sizeof(float);
#ifdef MADV_HUGEPAGE
  // a last page that would be less than half full is left to small ones
  const std::size_t of_large_pages = (n_bytes + kLargePage_bytes / 2) / kLargePage_bytes * kLargePage_bytes;
#else
  const std::size_t of_large_pages = 0;
#endif
  void* memory = nullptr;
  const std::size_t alignment = of_large_pages > 0 ? kLargePage_bytes : alignof(std::max_align_t);
  if (::posix_memalign(&memory, alignment, std::max(n_bytes, of_large_pages)) != 0) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  // where it cannot be granted the pages are small
  if (of_large_pages > 0) static_cast<void>(::madvise(memory, of_large_pages, MADV_HUGEPAGE));
#endif
  return SampleMemory(static_cast<float*>(memory));
}

}  // namespace bouncelab::audio
