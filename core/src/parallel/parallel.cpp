// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/parallel.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

namespace bouncelab {
namespace {

namespace tbb = oneapi::tbb;

/// Which threads the loops of this thread may use: as they ask for, this one only, or those of the arena that it is in,
/// either outside of any loop or within a call of one.
enum class Allowed { as_asked, this_thread, arena, arena_within_loop };
thread_local Allowed allowed = Allowed::as_asked;

class Limit {
 public:
  explicit Limit(Allowed here) : before_(std::exchange(allowed, here)) {}
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;
  ~Limit() { allowed = before_; }

 private:
  Allowed before_;
};

/// The calls of one loop: which k is next, and the failure of the smallest k.
class Calls {
 public:
  Calls(std::size_t n, const std::function<void(std::size_t)>& body) : n_(n), body_(body), first_failed_(n) {}

  /// Makes calls until there is none left to make. Those before a failed one are still made, so that the same failure
  /// is reported whatever the number of threads.
  void make() {
    for (std::size_t k = next_++; k < n_ && k < first_failed_; k = next_++) call(k);
  }

  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void call(std::size_t k) {
    try {
      body_(k);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (k >= first_failed_) return;
      first_failed_ = k;
      failure_ = std::current_exception();
    }
  }

  std::size_t n_;
  const std::function<void(std::size_t)>& body_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<std::size_t> first_failed_;
  std::mutex mutex_;
  std::exception_ptr failure_;
};

void make_on_all_threads(std::size_t n, Calls& calls) {
  const auto n_threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const auto make = [&](std::size_t) {
    const Limit limit(Allowed::arena_within_loop);
    calls.make();
  };
  const auto loop = [&] { tbb::parallel_for(std::size_t{0}, std::min(n, n_threads), make, tbb::simple_partitioner()); };
  // A thread that waits for an inner loop helps in it, and does not begin another call of an outer one meanwhile. One
  // that waits for the outermost loop is not isolated: it helps in whatever inner loops the last calls have.
  if (allowed == Allowed::arena_within_loop)
    tbb::this_task_arena::isolate(loop);
  else
    loop();
}

}  // namespace

int resolved_threads(int n_threads) { return n_threads > 0 ? n_threads : tbb::info::default_concurrency(); }

void parallel_for(std::size_t n, int n_threads, const std::function<void(std::size_t)>& body) {
  Calls calls(n, body);
  with_threads(n_threads, [&] {
    if (n <= 1 || allowed == Allowed::this_thread)
      calls.make();
    else
      make_on_all_threads(n, calls);
  });
  calls.rethrow();
}

void with_threads(int n_threads, const std::function<void()>& work) {
  if (n_threads == 1 || allowed == Allowed::this_thread) {
    const Limit limit(Allowed::this_thread);
    return work();
  }
  if (allowed == Allowed::arena || allowed == Allowed::arena_within_loop) return work();
  const int n = resolved_threads(n_threads);
  // TBB starts no more threads than there are cores unless it is told to
  std::optional<tbb::global_control> more_than_cores;
  if (n > tbb::info::default_concurrency())
    more_than_cores.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(n));
  tbb::task_arena arena(n);
  arena.execute([&] {
    const Limit limit(Allowed::arena);
    work();
  });
}

}  // namespace bouncelab
