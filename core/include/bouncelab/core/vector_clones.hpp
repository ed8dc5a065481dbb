// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Compiles a function three times, for registers of 128, 256 and 512 bits, and takes the widest that the processor
/// has. Everything is compiled with -ffp-contract=off: no fused multiply-add, so that every x86-64 processor gives
/// the same bytes.
///
/// For loops on which much of the time goes: synthesis, the FIR filters of sound, the likelihood of a fit.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define BOUNCELAB_VECTOR_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BOUNCELAB_VECTOR_CLONES
#endif
