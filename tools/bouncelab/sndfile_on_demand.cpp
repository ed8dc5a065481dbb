// SPDX-License-Identifier: GPL-3.0-or-later
/// The functions of libsndfile that the program calls, each of which loads the library at the first call.
///
/// libsndfile and the codecs that come with it are eight shared libraries, whose loading was a sixth of the time that
/// the program takes to start. Most commands read no sound, and recordings are read in a process of their own
/// (guarded_decoder.cpp), which loads the library while this one does something else. With these definitions the linker
/// needs none of the libraries (--as-needed). A function that is missing here is taken from the library as before: the
/// program starts later, and nothing else.
#include <dlfcn.h>
#include <sndfile.h>

#include <string>

#include "bouncelab/core/error.hpp"

namespace {

/// @param name  of a function of libsndfile
/// @throws bouncelab::FileError
void* loaded(const char* name) {
  // each time anew: a library that is there already takes no time, and what is missing now, a descriptor or memory, may
  // not be so later
  void* const library = dlopen(BOUNCELAB_SNDFILE, RTLD_LAZY | RTLD_LOCAL);
  void* const function = library != nullptr ? dlsym(library, name) : nullptr;
  if (function != nullptr) return function;
  const char* const reason = dlerror();
  throw bouncelab::FileError(
      "libsndfile", std::string("cannot be loaded (") + (reason != nullptr ? reason : "why?") + "); install it");
}

}  // namespace

// NOLINTBEGIN(cppcoreguidelines-macro-usage, bugprone-macro-parentheses): functions of the same kind, and their types
#define BOUNCELAB_ON_DEMAND(Result, function, parameters, arguments)                   \
  Result function parameters {                                                         \
    static const auto its = reinterpret_cast<Result(*) parameters>(loaded(#function)); \
    return its arguments;                                                              \
  }

// NOLINTEND(cppcoreguidelines-macro-usage, bugprone-macro-parentheses)

extern "C" {
BOUNCELAB_ON_DEMAND(int, sf_close, (SNDFILE * file), (file))
BOUNCELAB_ON_DEMAND(int, sf_command, (SNDFILE * file, int command, void* data, int n), (file, command, data, n))
BOUNCELAB_ON_DEMAND(int, sf_error, (SNDFILE * file), (file))
BOUNCELAB_ON_DEMAND(const char*, sf_error_number, (int number), (number))
BOUNCELAB_ON_DEMAND(int, sf_format_check, (const SF_INFO* info), (info))
BOUNCELAB_ON_DEMAND(SNDFILE*, sf_open_virtual, (SF_VIRTUAL_IO * calls, int mode, SF_INFO* info, void* user),
                    (calls, mode, info, user))
BOUNCELAB_ON_DEMAND(sf_count_t, sf_readf_float, (SNDFILE * file, float* out, sf_count_t n), (file, out, n))
BOUNCELAB_ON_DEMAND(sf_count_t, sf_seek, (SNDFILE * file, sf_count_t frames, int whence), (file, frames, whence))
BOUNCELAB_ON_DEMAND(const char*, sf_strerror, (SNDFILE * file), (file))
BOUNCELAB_ON_DEMAND(sf_count_t, sf_write_float, (SNDFILE * file, const float* in, sf_count_t n), (file, in, n))
BOUNCELAB_ON_DEMAND(sf_count_t, sf_write_int, (SNDFILE * file, const int* in, sf_count_t n), (file, in, n))
}
