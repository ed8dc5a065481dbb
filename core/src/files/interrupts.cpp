// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/parallel.hpp"

#include <atomic>

#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

// the handler runs on any thread, and so do those that ask
std::atomic<bool> asked_to_stop = false;
static_assert(std::atomic<bool>::is_always_lock_free);

}  // namespace

void request_stop() noexcept { asked_to_stop.store(true, std::memory_order_relaxed); }
void forget_stop_request() noexcept { asked_to_stop.store(false, std::memory_order_relaxed); }
bool stop_requested() noexcept { return asked_to_stop.load(std::memory_order_relaxed); }
void throw_if_stop_requested() {
  if (stop_requested()) throw Interrupted();
}

}  // namespace bouncelab
