// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/parallel.hpp"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

/// The calls of one loop: which k is next, and the failure of the smallest k.
class Calls {
 public:
  Calls(std::size_t n, const std::function<void(std::size_t)>& body) : n_(n), body_(body), first_failed_(n) {}

  bool any_left() const { return next_ < first_failed_; }

  /// Makes calls until there is none left to make. Those before a failed one are still made, so that the same failure
  /// is reported whatever the number of threads.
  void make() {
    for (std::size_t k = next_++; k < n_ && k < first_failed_; k = next_++) call(k);
  }

  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

  int n_helpers = 0;  ///< threads of the pool that are making calls; guarded by the pool's mutex

 private:
  void call(std::size_t k) {
    try {
      throw_if_stop_requested();
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

class Pool;

/// Where this thread is, which decides on the threads of the loops in it.
struct Place {
  Pool* pool = nullptr;  ///< none: as a loop asks for
  bool in_loop = false;  ///< within a call of a loop of the pool
  bool alone = false;    ///< no other thread may help
};
thread_local Place this_place;

class At {
 public:
  explicit At(Place here) : before_(std::exchange(this_place, here)) {}
  At(const At&) = delete;
  At& operator=(const At&) = delete;
  ~At() { this_place = before_; }

 private:
  Place before_;
};

/// Threads that help in every loop opened on one of them or on the thread that made the pool.
class Pool {
 public:
  explicit Pool(int n_threads) : n_helpers_wanted_(static_cast<std::size_t>(n_threads - 1)) {}
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  ~Pool() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    changed_.notify_all();
    for (std::thread& helper : helpers_) helper.join();
  }

  void run(Calls& calls) {
    const bool outermost = !this_place.in_loop;
    const At here({this, true, false});
    if (outermost && helpers_.empty()) start_helpers();
    {
      const std::lock_guard lock(mutex_);
      open_.push_back(&calls);
    }
    changed_.notify_all();
    calls.make();
    std::unique_lock lock(mutex_);
    std::erase(open_, &calls);
    // A thread that waits for the outermost loop helps in whatever inner loops the last calls have. One that waits for
    // an inner loop begins nothing else: it would come back late.
    const auto done = [&] { return calls.n_helpers == 0; };
    if (outermost)
      help(lock, done);
    else
      changed_.wait(lock, done);
  }

 private:
  /// As many as the system gives: results do not depend on it.
  void start_helpers() {
    try {
      helpers_.reserve(n_helpers_wanted_);
      while (helpers_.size() < n_helpers_wanted_)
        helpers_.emplace_back([this] {
          const At here({this, true, false});
          std::unique_lock lock(mutex_);
          help(lock, [this] { return ending_; });
        });
    } catch (const std::exception&) {
      return;  // no more threads, or no memory for them
    }
  }

  /// Makes calls of open loops, the outermost first: inner ones are for threads that have nothing else to do.
  template <class Done>
  void help(std::unique_lock<std::mutex>& lock, const Done& done) {
    while (!done()) {
      const auto loop = std::find_if(open_.begin(), open_.end(), [](const Calls* c) { return c->any_left(); });
      if (loop == open_.end()) {
        changed_.wait(lock);
        continue;
      }
      Calls& calls = **loop;
      ++calls.n_helpers;
      lock.unlock();
      calls.make();
      lock.lock();
      if (--calls.n_helpers == 0) changed_.notify_all();
    }
  }

  const std::size_t n_helpers_wanted_;
  std::vector<std::thread> helpers_;
  std::mutex mutex_;
  std::condition_variable changed_;  ///< a loop was opened, the last helper left one, or the pool ends
  std::vector<Calls*> open_;         ///< loops, in the order in which they were opened
  bool ending_ = false;
};

/// Cores that this process may run on: a batch system gives it fewer than the machine has.
int n_cores() {
#ifdef __EMSCRIPTEN__
  return 1;  // compiled without threads
#else
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (::sched_getaffinity(0, sizeof allowed, &allowed) == 0) return std::max(1, CPU_COUNT(&allowed));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
#endif
}

}  // namespace

int resolved_threads(int n_threads) { return n_threads > 0 ? n_threads : n_cores(); }

void parallel_for(std::size_t n, int n_threads, const std::function<void(std::size_t)>& body) {
  Calls calls(n, body);
  with_threads(n_threads, [&] {
    if (n <= 1 || this_place.alone)
      calls.make();
    else
      this_place.pool->run(calls);
  });
  calls.rethrow();
}

void with_threads(int n_threads, const std::function<void()>& work) {
  if (this_place.alone) return work();
  if (n_threads != 1 && this_place.pool != nullptr) return work();
  const int n = resolved_threads(n_threads);
  if (n == 1) {
    const At here({this_place.pool, this_place.in_loop, true});
    return work();
  }
  Pool pool(n);
  const At here({&pool, false, false});
  work();
}

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
