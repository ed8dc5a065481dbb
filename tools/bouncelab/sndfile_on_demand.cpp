// SPDX-License-Identifier: GPL-3.0-or-later
/// The functions of libsndfile that the program calls, each of which loads the library at the first call.
///
/// libsndfile and the codecs that come with it are eight shared libraries, whose loading was a sixth of the time that
/// the program takes to start. Most commands read no sound, and recordings are read in a process of their own
/// (guarded_decoder.cpp), which loads the library while this one does something else. With these definitions the linker
/// needs none of the libraries (--as-needed). A function that is missing here is taken from the library as before: the
/// program starts later, and nothing else.
#include <sndfile.h>

#include "on_demand.hpp"

namespace {

/// @param name  of a function of libsndfile
/// @throws bouncelab::FileError
void* of_sndfile(const char* name) {
  return bouncelab::cli::loaded(BOUNCELAB_SNDFILE, name, "libsndfile", "install it");
}

}  // namespace

extern "C" {
BOUNCELAB_ON_DEMAND(of_sndfile, int, sf_close, (SNDFILE * file), (file))
BOUNCELAB_ON_DEMAND(of_sndfile, int, sf_command, (SNDFILE * file, int command, void* data, int n),
                    (file, command, data, n))
BOUNCELAB_ON_DEMAND(of_sndfile, int, sf_error, (SNDFILE * file), (file))
BOUNCELAB_ON_DEMAND(of_sndfile, const char*, sf_error_number, (int number), (number))
BOUNCELAB_ON_DEMAND(of_sndfile, int, sf_format_check, (const SF_INFO* info), (info))
BOUNCELAB_ON_DEMAND(of_sndfile, SNDFILE*, sf_open_virtual, (SF_VIRTUAL_IO * calls, int mode, SF_INFO* info, void* user),
                    (calls, mode, info, user))
BOUNCELAB_ON_DEMAND(of_sndfile, sf_count_t, sf_readf_float, (SNDFILE * file, float* out, sf_count_t n), (file, out, n))
BOUNCELAB_ON_DEMAND(of_sndfile, sf_count_t, sf_seek, (SNDFILE * file, sf_count_t frames, int whence),
                    (file, frames, whence))
BOUNCELAB_ON_DEMAND(of_sndfile, const char*, sf_strerror, (SNDFILE * file), (file))
BOUNCELAB_ON_DEMAND(of_sndfile, sf_count_t, sf_write_float, (SNDFILE * file, const float* in, sf_count_t n),
                    (file, in, n))
BOUNCELAB_ON_DEMAND(of_sndfile, sf_count_t, sf_write_int, (SNDFILE * file, const int* in, sf_count_t n), (file, in, n))
}
