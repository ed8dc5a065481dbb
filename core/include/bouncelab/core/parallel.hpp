// SPDX-License-Identifier: GPL-3.0-or-later
/// Work on several threads, its progress, and requests to stop it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace bouncelab {

/// Called now and then by long computations, from one thread at a time, with the work done so far and in all (same
/// unit, e.g. drops or seconds of sound; total 0 = not known). May throw Interrupted to stop the computation.
using ProgressCallback = std::function<void(double done, double total)>;
/// Makes the progress callback of a stage: `label` is what is done ("simulate"), `unit` what is counted ("drops").
using StageProgress = std::function<ProgressCallback(const std::string& label, const std::string& unit)>;

/// Number of threads for an option whose 0 means all cores. @return n_threads, or the number of cores that this process
/// may run on where it is <= 0
int resolved_threads(int n_threads);

/// Calls body(k) once for each k = 0 ... n-1, on at most n_threads threads; returns when all are done. Where the system
/// starts no more threads (a limit on processes or memory), those that there are do the work.
///
/// Each thread takes the next k that nobody has, so that a long piece of work among many short ones delays nobody.
/// Loops may be nested: an inner loop shares the threads of the outermost one and never adds to them; one with
/// n_threads = 1 runs on the thread that calls it, and so do the loops in it. Results do not depend on the number of
/// threads where body(k) writes only what belongs to k.
/// @param n_threads  0: all cores; it may exceed their number. Within another loop or within with_threads anything but
///                   1 means the threads given there
/// @throws what body threw; where it threw for several k, what it threw for the smallest; Interrupted where a stop was
///         requested before all calls were made
void parallel_for(std::size_t n, int n_threads, const std::function<void(std::size_t)>& body);

/// Calls work() on this thread, and limits to n_threads the threads of all loops in it. Within another loop or
/// with_threads only n_threads = 1 has an effect.
/// @param n_threads  0: all cores
/// @throws what work threw
void with_threads(int n_threads, const std::function<void()>& work);

/// Asks the work of this process to stop. May be called in a signal handler.
void request_stop() noexcept;
bool stop_requested() noexcept;
/// For a process that goes on after work that was stopped, as an interpreter does.
void forget_stop_request() noexcept;
/// For places that wait for another program (a pipe's other end) and for progress callbacks.
/// @throws Interrupted once request_stop() was called
void throw_if_stop_requested();

}  // namespace bouncelab
