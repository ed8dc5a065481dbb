// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/parallel.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/sanitizers.hpp"

namespace bouncelab {
namespace {

using namespace std::chrono_literals;

/// A loaded machine may let a thread wait for long; nothing here takes so long otherwise.
constexpr auto kPatience = 20s;

/// Counts who works, and how many at once. The first to come waits for a second, where one is expected.
class Observed {
 public:
  explicit Observed(bool expects_others) : waits_until_(std::chrono::steady_clock::now() + kPatience) {
    if (!expects_others) waits_until_ = {};
  }
  void work() {
    const int now = ++n_now_;
    for (int most = n_most_; now > most && !n_most_.compare_exchange_weak(most, now);) {
    }
    {
      const std::lock_guard lock(mutex_);
      threads_.insert(std::this_thread::get_id());
    }
    do {
      std::this_thread::sleep_for(50us);
    } while (n_threads() < 2 && std::chrono::steady_clock::now() < waits_until_);
    --n_now_;
  }
  int n_most() const { return n_most_; }
  std::size_t n_threads() const {
    const std::lock_guard lock(mutex_);
    return threads_.size();
  }

 private:
  std::chrono::steady_clock::time_point waits_until_;
  std::atomic<int> n_now_ = 0, n_most_ = 0;
  mutable std::mutex mutex_;
  std::set<std::thread::id> threads_;
};

TEST(ParallelFor, CallsEachIndexOnce) {
  for (const int n_threads : {0, 1, 2, 7}) {
    std::vector<std::atomic<int>> calls(1000);
    parallel_for(calls.size(), n_threads, [&](std::size_t k) { ++calls[k]; });
    EXPECT_TRUE(std::all_of(calls.begin(), calls.end(), [](const auto& n) { return n == 1; })) << n_threads;
  }
  parallel_for(0, 3, [](std::size_t) { FAIL() << "a call of an empty loop"; });
}

TEST(ParallelFor, UsesNoMoreThreadsThanAllowedAndMoreThanOneWhereAllowed) {
  for (const int n_threads : {1, 2, 5}) {  // 5: more than many machines have cores
    Observed observed(n_threads > 1);
    parallel_for(200, n_threads, [&](std::size_t) { observed.work(); });
    EXPECT_LE(observed.n_most(), n_threads);
    EXPECT_EQ(observed.n_threads() > 1, n_threads > 1) << n_threads;
  }
}

TEST(ParallelFor, AnInnerLoopSharesTheThreadsOfTheOuterOne) {
  for (const int n_threads : {1, 3}) {
    Observed observed(n_threads > 1);
    parallel_for(6, n_threads, [&](std::size_t) {
      parallel_for(20, 0, [&](std::size_t) { observed.work(); });
      parallel_for(20, 16, [&](std::size_t) { observed.work(); });
    });
    EXPECT_LE(observed.n_most(), n_threads);
  }
}

TEST(ParallelFor, AnInnerLoopOfOneThreadStaysOnIt) {
  parallel_for(8, 4, [](std::size_t) {
    const auto here = std::this_thread::get_id();
    parallel_for(20, 1, [&](std::size_t) {
      EXPECT_EQ(std::this_thread::get_id(), here);
      parallel_for(3, 0, [&](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), here); });
    });
  });
}

TEST(ParallelFor, FreeThreadsHelpInTheInnerLoopOfTheLastCall) {
  // two threads, two calls of which one ends at once: its thread must come to the inner loop of the other
  std::atomic<bool> came = false;
  parallel_for(2, 2, [&](std::size_t k) {
    if (k == 1) return;
    const auto here = std::this_thread::get_id();
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    parallel_for(100000, 2, [&](std::size_t) {
      if (std::this_thread::get_id() != here) came = true;
      if (!came && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(100us);
    });
  });
  EXPECT_TRUE(came);
}

TEST(ParallelFor, OneLongCallDelaysNoOther) {
  // the first call waits for all others: a loop that deals out stretches beforehand would wait for ever
  constexpr int kOthers = 50;
  std::atomic<int> n_others = 0;
  parallel_for(kOthers + 1, 2, [&](std::size_t k) {
    if (k > 0) {
      ++n_others;
      return;
    }
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (n_others < kOthers && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(1ms);
    EXPECT_EQ(n_others, kOthers);
  });
}

TEST(ParallelFor, RethrowsTheFailureOfTheSmallestIndex) {
  for (const int n_threads : {1, 2, 5})
    for (int again = 0; again < 20; ++again) try {
        parallel_for(100, n_threads, [](std::size_t k) {
          if (k >= 17) throw std::runtime_error(std::to_string(k));
          std::this_thread::sleep_for(20us);  // so that later calls fail first
        });
        FAIL() << "no failure";
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "17");
      }
}

TEST(ParallelFor, AFailureOfAnInnerLoopReachesTheCaller) {
  EXPECT_THROW(parallel_for(4, 2,
                            [](std::size_t) {
                              parallel_for(4, 0, [](std::size_t k) {
                                if (k == 2) throw std::runtime_error("inner");
                              });
                            }),
               std::runtime_error);
  // and the limit ends with the loop
  Observed observed(true);
  parallel_for(200, 3, [&](std::size_t) { observed.work(); });
  EXPECT_GT(observed.n_threads(), 1u);
}

/// Leaves this process less address space than the stack of a thread takes.
void allow_no_more_threads() {
  rlim_t n_pages = 0;
  std::ifstream("/proc/self/statm") >> n_pages;
  const rlim_t most = n_pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + (1 << 20);
  const rlimit limit{most, most};
  ::setrlimit(RLIMIT_AS, &limit);
}

TEST(ParallelFor, GoesOnWithFewerThreadsWhereTheSystemGivesNoMore) {
  if (test::kSanitizer != nullptr)
    GTEST_SKIP() << test::kSanitizer << " needs more address space than any limit leaves";
  EXPECT_EXIT(
      {
        allow_no_more_threads();
        std::vector<std::atomic<int>> calls(100);
        parallel_for(calls.size(), 8, [&](std::size_t k) { ++calls[k]; });
        ::_exit(std::all_of(calls.begin(), calls.end(), [](const auto& n) { return n == 1; }) ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(WithThreads, LimitsTheLoopsInIt) {
  for (const int n_threads : {1, 2}) {
    Observed observed(n_threads > 1);
    with_threads(n_threads, [&] {
      parallel_for(50, 0, [&](std::size_t) { observed.work(); });
      parallel_for(50, 8, [&](std::size_t) { observed.work(); });
    });
    EXPECT_LE(observed.n_most(), n_threads);
    EXPECT_EQ(observed.n_threads() > 1, n_threads > 1);
  }
}

TEST(ResolvedThreads, TakesAllCoresForNone) {
  EXPECT_GE(resolved_threads(0), 1);
  EXPECT_EQ(resolved_threads(9), 9);
}

}  // namespace
}  // namespace bouncelab
