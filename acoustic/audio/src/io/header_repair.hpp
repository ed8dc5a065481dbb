// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/sound_bytes.hpp"

namespace bouncelab::audio {

/// Bytes of a header as they should be.
struct HeaderPatch {
  std::int64_t first = 0;
  std::string bytes;
};

/// A header that gives the length of the sound wrongly, or not at all, and what the file holds.
struct HeaderRepair {
  std::vector<HeaderPatch> patches;                ///< with these the header is right
  std::optional<std::int64_t> n_promised_bytes{};  ///< of samples; absent where the header gives no length
  std::int64_t n_held_bytes = 0;                   ///< of whole frames
};

/// Finds out whether the header of a WAV (RIFF, RF64), W64, AIFF or AU file is wrong about the length of its samples:
/// more than the file holds (cut off, or counted wrongly), no length (written to a pipe: 0 or all bits set), or less
/// than the file holds, where what follows the samples promised is no chunk but more than 4 kB of something else.
/// @return nothing where it is right to a frame, or the file is of another kind
std::optional<HeaderRepair> repair_header(SoundBytes& bytes);

/// Where a file of another format lies inside a WAV file: Ogg in the chunk of its samples (format tags 'Og', 1998).
struct EmbeddedFile {
  std::int64_t first = 0, n_bytes = 0;
};
std::optional<EmbeddedFile> ogg_in_wav(SoundBytes& bytes);

}  // namespace bouncelab::audio
