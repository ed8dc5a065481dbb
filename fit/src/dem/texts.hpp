// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab::fit {

/// The file core/restitution_with_memory.hpp.
extern const char* const kSamplerText;

/// Inputs of discrete-element codes, files of fit/data, with @name@ where a number or a part of another file stands.
extern const char *const kLiggghts, *const kLiggghtsConstant, *const kLiggghtsViscoelastic;
extern const char* const kLammps;
extern const char *const kYade, *const kYadeViscoelastic;
extern const char* const kMercury;

}  // namespace bouncelab::fit
