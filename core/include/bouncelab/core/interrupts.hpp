// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab {

/// Asks the work of this process to stop. May be called in a signal handler.
void request_stop() noexcept;
bool stop_requested() noexcept;
/// For a process that goes on after work that was stopped, as an interpreter does.
void forget_stop_request() noexcept;
/// For places that wait for another program (a pipe's other end) and for progress callbacks.
/// @throws Interrupted once request_stop() was called
void throw_if_stop_requested();

}  // namespace bouncelab
