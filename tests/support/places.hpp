// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Where the tests find what they read and start: absolute paths, in a source of their own, so that what a compiler
// cache has of all others is good for a clone in another folder too.

namespace bouncelab::test {

extern const char* const kSupport;     ///< tests/support
extern const char* const kInputs;      ///< tests/support/inputs
extern const char* const kSamples;     ///< samples
extern const char* const kFormats;     ///< docs/formats.md
extern const char* const kProgram;     ///< the program; these two empty where they are not built
extern const char* const kVampFolder;  ///< of the Vamp plugins

}  // namespace bouncelab::test
