// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace bouncelab::sim {

/// Memory for many arrays that are given back together: no room between them, and large pages where the system has
/// them, because a search reads one place in gigabytes, and would wait for the tables of small pages too.
class Arena {
 public:
  /// @param expected_bytes  roughly, of all; small arenas take no large pages
  explicit Arena(std::size_t expected_bytes = 0) : block_bytes_(std::min(kLargePage, expected_bytes + kLine)) {}

  /// Room for n values, at the start of a cache line; several threads may ask at once.
  template <class T>
  std::span<T> make(std::size_t n) {
    return {static_cast<T*>(allocate(n * sizeof(T))), n};
  }
  template <class T>
  std::span<T> copy(const std::vector<T>& values) {
    const std::span<T> copied = make<T>(values.size());
    std::uninitialized_copy(values.begin(), values.end(), copied.begin());
    return copied;
  }

 private:
  static constexpr std::size_t kLine = 64, kLargePage = std::size_t{2} << 20U;
  struct Free {
    void operator()(void* block) const;
  };

  void* allocate(std::size_t n_bytes);
  std::byte* add_block(std::size_t n_bytes);

  std::size_t block_bytes_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  std::vector<std::unique_ptr<void, Free>> blocks_;
  std::byte* next_ = nullptr;
  std::size_t left_bytes_ = 0;  ///< after next_
};

}  // namespace bouncelab::sim
