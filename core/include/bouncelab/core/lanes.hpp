// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstring>

namespace bouncelab {

/// Eight numbers side by side, for loops in which the compiler finds no such order: one wide register, or two narrow
/// ones. Passed by reference only: how values are passed depends on the registers that a function may use.
using Lanes = float __attribute__((vector_size(32)));
inline constexpr std::size_t kLanes = sizeof(Lanes) / sizeof(float);

[[gnu::always_inline]] inline void load(const float* from, Lanes& x) { std::memcpy(&x, from, sizeof x); }
[[gnu::always_inline]] inline void store(const Lanes& x, float* to) { std::memcpy(to, &x, sizeof x); }

}  // namespace bouncelab
