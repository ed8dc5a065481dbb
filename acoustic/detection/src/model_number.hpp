// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// The numbers of a stage's model stand in one struct, of which there is one constant. Programs that
/// measure what each is worth are built with numbers that they may change (tests/bench/model_numbers.hpp).
#ifdef BOUNCELAB_CHANGEABLE_MODEL
#define BOUNCELAB_MODEL inline  // NOLINT(cppcoreguidelines-macro-usage)
#else
#define BOUNCELAB_MODEL inline constexpr  // NOLINT(cppcoreguidelines-macro-usage)
#endif
