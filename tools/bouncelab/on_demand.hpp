// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <dlfcn.h>

#include <string>

#include "bouncelab/core/error.hpp"

namespace bouncelab::cli {

/// What a shared library has under a name. The library is asked for each time anew: one that is there already takes no
/// time, and what is missing now, a descriptor or memory, may not be so later.
/// @param file     of the library, as programs are linked to it: "libsndfile.so.1"
/// @param product  the library's own name, for the message
/// @param remedy   what to do where it cannot be loaded
/// @throws FileError
inline void* loaded(const char* file, const char* name, const char* product, const char* remedy) {
  void* const library = dlopen(file, RTLD_LAZY | RTLD_LOCAL);
  void* const found = library != nullptr ? dlsym(library, name) : nullptr;
  if (found != nullptr) return found;
  const char* const reason = dlerror();
  throw FileError(product, std::string("cannot be loaded (") + (reason != nullptr ? reason : "why?") + "); " + remedy);
}

}  // namespace bouncelab::cli

// NOLINTBEGIN(cppcoreguidelines-macro-usage, bugprone-macro-parentheses): functions of the same kind, and their types

/// The text of what a name stands for: a header may give another version of a function the name of the former one.
#define BOUNCELAB_TEXT_OF_NAME(name) #name
#define BOUNCELAB_TEXT_OF(name) BOUNCELAB_TEXT_OF_NAME(name)

/// A function of a library, which is loaded at the first call. The library's own calls of it must not come here: the
/// linker is told not to show it to shared libraries (--exclude-libs).
/// @param find  gives the function's address by its name
#define BOUNCELAB_ON_DEMAND(find, Result, function, parameters, arguments)                             \
  Result function parameters {                                                                         \
    static const auto its = reinterpret_cast<Result(*) parameters>(find(BOUNCELAB_TEXT_OF(function))); \
    return its arguments;                                                                              \
  }

// NOLINTEND(cppcoreguidelines-macro-usage, bugprone-macro-parentheses)
