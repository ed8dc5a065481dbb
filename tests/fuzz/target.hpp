// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <string>
#include <string_view>

#include "bouncelab/core/error.hpp"

/// What libFuzzer calls, and run_inputs.cpp.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace bouncelab::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// Gives an input, any bytes, to a reader and checks what it promises. Each file of targets/ defines it.
void run(Bytes input);

/// Prints what was promised and did not hold, and aborts: a finding.
[[noreturn]] void fail(std::string_view promise, std::string_view what = {});
inline void require(bool holds, std::string_view promise) {
  if (!holds) fail(promise);
}

/// Aborts unless it is one line for people: at most 1,000 characters, none of them a control character.
void check_message(std::string_view message);

/// Calls a reader. @return false where it refused the input with an InvalidArgument or a FileError whose message is fit
/// to be shown; anything else that is thrown is a finding.
template <class Reader>
bool accepts(Reader&& reader) {
  try {
    reader();
    return true;
  } catch (const InvalidArgument& error) {
    check_message(error.what());
  } catch (const FileError& error) {
    check_message(error.what());
  } catch (const std::exception& error) {
    fail("only InvalidArgument and FileError are thrown", error.what());
  }
  return false;
}

/// As accepts, of what the library wrote itself: that it is refused is a finding.
template <class Reader>
void must_accept(std::string_view promise, Reader&& reader) {
  try {
    reader();
  } catch (const std::exception& error) {
    fail(promise, error.what());
  }
}

inline std::string_view text_of(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace bouncelab::fuzz
