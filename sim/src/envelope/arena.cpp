// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/arena.hpp"

#include <cstdlib>
#include <new>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace bouncelab::sim {
namespace {

std::size_t rounded_up_to(std::size_t n_bytes, std::size_t unit) { return (n_bytes + unit - 1) / unit * unit; }

}  // namespace

void Arena::Free::operator()(void* block) const { std::free(block); }

void* Arena::allocate(std::size_t n_bytes) {
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

std::byte* Arena::add_block(std::size_t n_bytes) {
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
