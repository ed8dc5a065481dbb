// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab::fit {

/// The file core/restitution_with_memory.hpp.
extern const char* const kSamplerText;

}  // namespace bouncelab::fit
