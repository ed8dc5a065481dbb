// SPDX-License-Identifier: GPL-3.0-or-later
/// How the program uses memory, and what it keeps for the case that there is none left.
#pragma once

namespace bouncelab::cli {

/// To be called first.
/// @throws std::bad_alloc  where not even the reserve can be had
void prepare_memory();

/// Gives back what was kept so that destructors and the message of a shortage find memory. The first operator new that
/// fails has done so already; what fails elsewhere (FFTW) has not. Does nothing from the second call on.
void release_reserve() noexcept;

/// The one line for a process that is out of memory, without asking for any.
void say_out_of_memory() noexcept;

}  // namespace bouncelab::cli
