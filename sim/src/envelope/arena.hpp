// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <vector>
#if defined(__linux__)
#include <sys/mman.h>
#endif

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
    void operator()(void* block) const { std::free(block); }
  };

  static std::size_t rounded_up_to(std::size_t n_bytes, std::size_t unit) { return (n_bytes + unit - 1) / unit * unit; }

  void* allocate(std::size_t n_bytes);
  std::byte* add_block(std::size_t n_bytes);

  std::size_t block_bytes_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  std::vector<std::unique_ptr<void, Free>> blocks_;
  std::byte* next_ = nullptr;
  std::size_t left_bytes_ = 0;  ///< after next_
};

inline void* Arena::allocate(std::size_t n_bytes) {
  const std::size_t taken = rounded_up_to(n_bytes, kLine);
  const std::lock_guard lock(*mutex_);
  if (taken > block_bytes_ / 8) return add_block(taken);  // what is left of the block serves smaller ones
  if (taken > left_bytes_) {
    next_ = add_block(block_bytes_);
    left_bytes_ = block_bytes_;
  }
  std::byte* const place = next_;
  next_ += taken;
  left_bytes_ -= taken;
  return place;
}

inline std::byte* Arena::add_block(std::size_t n_bytes) {
  const std::size_t unit = n_bytes < kLargePage ? kLine : kLargePage;
  void* const block = std::aligned_alloc(unit, rounded_up_to(n_bytes, unit));
  if (block == nullptr) throw std::bad_alloc();
#if defined(__linux__)
  // advice: where it cannot be followed, pages are small
  if (unit == kLargePage) madvise(block, rounded_up_to(n_bytes, unit), MADV_HUGEPAGE);
#endif
  blocks_.emplace_back(block);
  return static_cast<std::byte*>(block);
}

}  // namespace bouncelab::sim
