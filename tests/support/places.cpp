// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/places.hpp"

namespace bouncelab::test {

const char* const kSupport = BOUNCELAB_ROOT "/tests/support";
const char* const kInputs = BOUNCELAB_ROOT "/tests/support/inputs";
const char* const kSamples = BOUNCELAB_ROOT "/samples";
const char* const kFormats = BOUNCELAB_ROOT "/docs/formats.md";
const char* const kProgram = BOUNCELAB_PROGRAM;
const char* const kVampFolder = BOUNCELAB_VAMP_FOLDER;

}  // namespace bouncelab::test
