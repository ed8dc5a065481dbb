// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/scratch_file.hpp"
#include "io/sound_bytes.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {

/// Whether a file may be a table: no control characters in its first bytes.
bool is_text(SoundBytes& bytes);

/// Samples as a table of text, as phyphox and oscilloscopes export them: columns by tab, semicolon, comma or blanks;
/// decimal point, or decimal comma where the comma does not separate; lines in front that are no numbers (titles,
/// units), empty ones and those that begin with # are passed over.
///
/// A first column that its title says to be time (in s, ms, us, ns), or that grows by equal steps, gives the sampling
/// rate; one that counts 0, 1, 2 ... is passed over. Every other column is a channel, full scale = 1. The samples lie
/// in a nameless temporary file (TMPDIR or /tmp), 4 bytes each.
class NumberText {
 public:
  /// @param in       the table's text, read to its end. @param name  for messages
  /// @param rate_hz  of a table without times
  /// @throws FileError naming the line: no numbers, another number of cells, times that are not uniform, neither times
  ///         nor rate; InvalidArgument where there are both
  NumberText(std::istream& in, const std::string& name, std::optional<double> rate_hz);

  const SoundInfo& info() const { return info_; }
  /// Interleaved frames from `first` on, all inside the table. @throws FileError
  void read(std::int64_t first, std::span<float> interleaved) const;

 private:
  ScratchFile samples_;
  SoundInfo info_;
};

}  // namespace bouncelab::audio
