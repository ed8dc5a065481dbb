// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace bouncelab::fuzz {

/// Watches what is allocated while it lives: more than 10 times the input and 100 MB is a finding. With clang's
/// address sanitizer every allocation is seen as it is made; otherwise the growth of the process at the end.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t input_bytes);
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
  ~MemoryLimit();
};

}  // namespace bouncelab::fuzz
