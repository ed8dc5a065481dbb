// SPDX-License-Identifier: GPL-3.0-or-later
// Headers of sound files: their chunks, and where samples lie that need no codec.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"

namespace bouncelab::audio {

/// What is known of a sound once it is open.
struct SoundInfo : AudioFormat {
  bool may_be_infinite = true;  ///< floats, and what a lossy codec makes, need not be finite
};

inline constexpr double kLowestRate_hz = 4e3;  // below, a contact of steel on glass (30 us) leaves nothing to time
inline constexpr double kHighestRate_hz = 4e6;

/// @throws FileError where a sampling rate is outside of these
void check_rate(double rate_hz, const std::string& name);

/// The message for a file that holds less than its header says.
std::string ends_early(std::int64_t at_frame, std::int64_t n_promised);

/// The warning where a header is wrong about the length of the sound, with what was found.
/// @param n_promised  frames; absent where the header gives no length
std::string wrong_length(const SoundInfo& found, std::optional<double> n_promised);

// ---- chunks: a name, a length, the content

std::uint64_t number_in(std::string_view text);
std::string bytes_of_number(std::uint64_t value, int n_bytes);

/// How a format writes its chunks: as RIFF does, unless said otherwise.
struct ChunkLayout {
  std::int64_t first_chunk = 12;  ///< in the file
  int name_bytes = 4, length_bytes = 4;
  bool counts_head = false;  ///< the length includes name and length
  std::int64_t alignment = 2;

  std::int64_t head_bytes() const { return name_bytes + length_bytes; }
  std::int64_t next(std::int64_t begin, std::int64_t length) const {
    return begin + (length + alignment - 1) / alignment * alignment;
  }
};

struct Chunk {
  std::string name;          ///< its first four characters
  std::int64_t begin = 0;    ///< of the content, in the file
  std::uint64_t length = 0;  ///< of the content, as it is given
};

/// Nothing where the file ends before the chunk's content begins.
std::optional<Chunk> chunk_at(FileBytes& bytes, const ChunkLayout& layout, std::int64_t at);

// ---- samples

/// Samples that lie in a file one after the other, without a codec.
struct PlainSound {
  SoundInfo info;
  int coding = 0;  ///< as libsndfile numbers it, with the order of bytes
  std::size_t sample_bytes = 0;
  std::int64_t first_byte = 0;
};

/// The plain samples of a WAV file (RIFF, RF64) or W64: integers of 8 to 32 bits, float, double. Where the
/// header is wrong about their length (more than the file holds: cut off, or counted wrongly; none: written to a pipe,
/// 0 or all bits set; less than the file holds, where what follows the samples promised is no chunk but more than 4 kB
/// of something else) what is there is taken, and info.warning says so.
/// @return nothing where the file is of another kind, coded, or unlike what such files are
/// @throws FileError: no samples, a sampling rate that cannot be
/// Sources: RIFF MCI 1991; EBU Tech 3306 (RF64).
std::optional<PlainSound> plain_sound(FileBytes& bytes);

/// The length of coded samples (ADPCM, A-law ...) in a WAV file (RIFF) whose header is wrong about it, as above.
struct CodedLength {
  std::int64_t at = 0;                 ///< byte of the file where the header gives it, in 32 bits
  std::int64_t n_bytes = 0;            ///< what is there
  std::optional<double> n_promised{};  ///< what the header gives, in bytes; absent where that is none
};
std::optional<CodedLength> coded_length(FileBytes& bytes);

/// What a file holds behind the sound that is read, for people: another recording that was joined to it (cat, a
/// recorder that pauses), a second chunk of samples. Empty: nothing.
std::string what_follows(FileBytes& bytes);

/// Where a file of another format lies inside a WAV file: Ogg in the chunk of its samples (format tags 'Og', 1998).
struct EmbeddedFile {
  std::int64_t first = 0, n_bytes = 0;
};
std::optional<EmbeddedFile> ogg_in_wav(FileBytes& bytes);

/// Container and coding in words. @param format  as libsndfile numbers it
std::string description_of(int format);

/// libsndfile cannot read the file: perhaps another decoder can.
class NotForLibsndfile : public FileError {
 public:
  using FileError::FileError;
};

/// Plain samples, read in place.
class PlainSamples {
 public:
  PlainSamples(FileBytes bytes, PlainSound sound) : bytes_(std::move(bytes)), sound_(std::move(sound)) {}

  /// Interleaved frames from `first` on, all of them inside the sound; from any thread.
  /// @throws FileError where the file ends early or cannot be read
  void read(std::int64_t first, std::span<float> interleaved) const;

 private:
  FileBytes bytes_;
  PlainSound sound_;
};

/// Coded sound from its begin to its end: no limit on time and memory, which a damaged file may use up, so that
/// decode_coded() runs this in a process of its own. The tests that try millions of damaged files run it as it is.
class SoundDecoder {
 public:
  /// Reads the header. @throws NotForLibsndfile; FileError naming the remedy
  explicit SoundDecoder(const FileBytes& bytes);

  /// n_frames as the header says, which may be wrong.
  const SoundInfo& info() const;
  /// Whether the header says how many frames there are.
  bool has_length() const;
  /// The next interleaved frames, until the next call; none at the end.
  /// @throws FileError where samples are missing that are not the last ones, or there is no end
  std::span<const float> next();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// What is known once all was decoded. @param n_found  frames. @throws FileError where there are none
void conclude(SoundInfo& info, bool has_length, std::int64_t n_found, const std::string& name);

}  // namespace bouncelab::audio
