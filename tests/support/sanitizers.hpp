// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab::test {

/// The sanitizer that tests and program were built with; none: nullptr. It takes terabytes of address space for its
/// shadow memory, so that no limit on memory can be tested with it.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr const char* kSanitizer = "AddressSanitizer";
#elif defined(__SANITIZE_THREAD__)
inline constexpr const char* kSanitizer = "ThreadSanitizer";
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
inline constexpr const char* kSanitizer = "AddressSanitizer";
#elif __has_feature(thread_sanitizer)
inline constexpr const char* kSanitizer = "ThreadSanitizer";
#else
inline constexpr const char* kSanitizer = nullptr;
#endif
#else
inline constexpr const char* kSanitizer = nullptr;
#endif

/// Why a test is left out under a sanitizer, where everything takes ten times as long.
inline constexpr const char* kRepetitions = "statistics of many repetitions run the same code again and again";

}  // namespace bouncelab::test
