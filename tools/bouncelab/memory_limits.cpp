// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory_limits.hpp"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <exception>
#include <new>
#include <string_view>

namespace bouncelab::cli {
namespace {

/// nlohmann::json's destructor asks for memory, as much as a twentieth of what it frees, and ends the process where it
/// gets none; a message needs some kilobytes.
constexpr std::size_t kReserve_bytes = 1 << 20;

std::atomic<void*> reserve{nullptr};

/// Destructors that run because of an exception may not fail: they get what was kept. All others learn of the shortage,
/// with the reserve free for what follows.
void when_memory_is_short() {
  const bool kept = reserve.load() != nullptr;
  release_reserve();
  if (!kept || std::uncaught_exceptions() == 0) throw std::bad_alloc();
}

/// The memory manager gives each thread an arena of its own, 64 MB of address space, and where a limit leaves no room
/// for one it asks the system at every allocation, a hundred times as slow. Under a limit all threads share one.
void share_memory_under_a_limit() {
#ifdef M_ARENA_MAX
  rlimit address_space{};
  if (::getrlimit(RLIMIT_AS, &address_space) == 0 && address_space.rlim_cur != RLIM_INFINITY) ::mallopt(M_ARENA_MAX, 1);
#endif
}

/// What is freed in pieces above 16 MB goes back to the system, and what is free above 32 MB at the end of the heap. By
/// itself glibc keeps all that is below the largest freed so far: a fifth more memory for an hour of music. With limits
/// of one megabyte the loop spends a tenth of its time on pages that come back empty, drop after drop.
void give_large_memory_back() {
#ifdef M_MMAP_THRESHOLD
  ::mallopt(M_MMAP_THRESHOLD, 1 << 24);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 25);
#endif
}

}  // namespace

void prepare_memory() {
  share_memory_under_a_limit();
  give_large_memory_back();
  reserve = ::operator new(kReserve_bytes);  // its pages are never touched
  std::set_new_handler(when_memory_is_short);
}

void release_reserve() noexcept { ::operator delete(reserve.exchange(nullptr)); }

void say_out_of_memory() noexcept {
  constexpr std::string_view kMessage = "bouncelab: out of memory; ask for less at once\n";
  (void)!::write(STDERR_FILENO, kMessage.data(), kMessage.size());
}

}  // namespace bouncelab::cli
