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

}  // namespace bouncelab::test
