// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "bouncelab/core/error.hpp"

namespace bouncelab::test {

/// The message of the error that a call ends with; of another type it goes on and fails the test.
template <class Refusal = Error, class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Refusal& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace bouncelab::test
