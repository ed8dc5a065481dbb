// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstring>

/// Compiles a function three times, for registers of 128, 256 and 512 bits, and takes the widest that the processor
/// has. For loops on which much of a whole command's time goes; the kernels' own ratios are in
/// acoustic/audio/src/dsp/kernels.cpp.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define BOUNCELAB_VECTOR_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BOUNCELAB_VECTOR_CLONES
#endif

namespace bouncelab {

/// Eight numbers side by side, for loops in which the compiler finds no such order: one wide register, or two narrow
/// ones. Passed by reference only: how values are passed depends on the registers that a function may use.
using Lanes = float __attribute__((vector_size(32)));
inline constexpr std::size_t kLanes = sizeof(Lanes) / sizeof(float);

[[gnu::always_inline]] inline void load(const float* from, Lanes& x) { std::memcpy(&x, from, sizeof x); }
[[gnu::always_inline]] inline void store(const Lanes& x, float* to) { std::memcpy(to, &x, sizeof x); }

}  // namespace bouncelab
