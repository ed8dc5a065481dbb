// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/raw_pcm.hpp"

#include <fcntl.h>
#include <sndfile.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>
#include <vector>

#include "bouncelab/audio/dsp/vector_clones.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kFramesAtOnce = 1 << 14;

/// Bytes of an integer of 16 or 24 bits as this processor has them; 0 for all else.
int bytes_of_integer(SNDFILE* file, int format) {
  const int container = format & SF_FORMAT_TYPEMASK;
  const bool may_be = container == SF_FORMAT_WAV || container == SF_FORMAT_WAVEX || container == SF_FORMAT_RF64 ||
                      container == SF_FORMAT_W64 || container == SF_FORMAT_AIFF || container == SF_FORMAT_AU ||
                      container == SF_FORMAT_CAF;
  const int sub = format & SF_FORMAT_SUBMASK;
  const bool is_native = std::endian::native == std::endian::little &&
                         sf_command(file, SFC_RAW_DATA_NEEDS_ENDSWAP, nullptr, 0) == SF_FALSE;
  if (!may_be || !is_native) return 0;
  return sub == SF_FORMAT_PCM_16 ? 2 : sub == SF_FORMAT_PCM_24 ? 3 : 0;
}

/// Full scale 1, as libsndfile has it, which takes one sample at a time.
BOUNCELAB_VECTOR_CLONES void from_16_bits(const unsigned char* from, float* to, std::int64_t n) {
  for (std::int64_t k = 0; k < n; ++k) {
    std::int16_t x;
    std::memcpy(&x, from + 2 * k, sizeof x);
    to[k] = static_cast<float>(x) * 0x1p-15F;
  }
}

BOUNCELAB_VECTOR_CLONES void from_24_bits(const unsigned char* from, float* to, std::int64_t n) {
  using Bytes = unsigned char __attribute__((vector_size(16)));
  using Integers = std::int32_t __attribute__((vector_size(16)));
  using Floats = float __attribute__((vector_size(16)));
  constexpr Bytes kPlace{16, 0, 1, 2, 16, 3, 4, 5, 16, 6, 7, 8, 16, 9, 10, 11};  // 16: a byte of zeros
  std::int64_t k = 0;
  for (; 3 * k + 16 <= 3 * n; k += 4) {
    Bytes x;
    std::memcpy(&x, from + 3 * k, sizeof x);
    const auto high = reinterpret_cast<Integers>(__builtin_shuffle(x, Bytes{}, kPlace));
    const Floats value = __builtin_convertvector(high, Floats) * 0x1p-31F;
    std::memcpy(to + k, &value, sizeof value);
  }
  for (; k < n; ++k) {
    const unsigned char* x = from + 3 * k;
    to[k] =
        static_cast<float>(std::bit_cast<std::int32_t>(std::array<unsigned char, 4>{0, x[0], x[1], x[2]})) * 0x1p-31F;
  }
}

/// A file as libsndfile sees it and where that stands in it.
class Seen {
 public:
  explicit Seen(const std::filesystem::path& path) : descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ >= 0) file_ = sf_open_fd(descriptor_, SFM_READ, &info_, SF_FALSE);
  }
  Seen(const Seen&) = delete;
  Seen& operator=(const Seen&) = delete;
  ~Seen() {
    if (file_ != nullptr) sf_close(file_);
    if (descriptor_ >= 0) close(descriptor_);
  }
  SNDFILE* file() const { return file_; }
  const SF_INFO& info() const { return info_; }

  /// Of the first sample, in bytes: where libsndfile goes for it.
  std::int64_t offset() const {
    return sf_seek(file_, 0, SEEK_SET) == 0 ? static_cast<std::int64_t>(lseek(descriptor_, 0, SEEK_CUR)) : -1;
  }

  /// Interleaved frames from `first` on.
  std::vector<float> read(std::int64_t first, std::int64_t n) const {
    std::vector<float> x(static_cast<std::size_t>(n * info_.channels), 2.0F);  // which no integer is
    if (sf_seek(file_, first, SEEK_SET) == first) sf_readf_float(file_, x.data(), n);
    return x;
  }

 private:
  int descriptor_;
  SF_INFO info_{};
  SNDFILE* file_ = nullptr;
};

}  // namespace

PlainSamples::PlainSamples(FileBytes bytes, std::int64_t offset, int n_bytes, int n_channels)
    : bytes_(std::move(bytes)), offset_(offset), n_bytes_(n_bytes), n_channels_(n_channels) {}

std::optional<PlainSamples> PlainSamples::of(const std::filesystem::path& path) {
  const Seen seen(path);
  if (seen.file() == nullptr) return std::nullopt;
  const SF_INFO& info = seen.info();
  const int n_bytes = bytes_of_integer(seen.file(), info.format);
  const std::int64_t offset = n_bytes > 0 ? seen.offset() : -1;
  if (offset <= 0 || info.frames <= 0) return std::nullopt;
  FileBytes bytes(path);
  if (offset + info.frames * n_bytes * info.channels > bytes.size()) return std::nullopt;
  PlainSamples plain(std::move(bytes), offset, n_bytes, info.channels);
  // where libsndfile stood is where it said, but nothing in its interface says so: either end is compared
  const std::int64_t n_compared = std::min<std::int64_t>(info.frames, 64);
  for (const std::int64_t first : {std::int64_t{0}, static_cast<std::int64_t>(info.frames) - n_compared}) {
    const std::vector<float> expected = seen.read(first, n_compared);
    std::vector<float> x(expected.size());
    plain.decode(first, x);
    if (x != expected) return std::nullopt;
  }
  return plain;
}

void PlainSamples::decode(std::int64_t first, std::span<float> out) {
  const std::int64_t frame = n_bytes_ * n_channels_;
  const auto n = static_cast<std::int64_t>(out.size()) / n_channels_;
  for (std::int64_t done = 0; done < n; done += kFramesAtOnce) {
    const std::int64_t n_here = std::min(kFramesAtOnce, n - done);
    const unsigned char* from = bytes_.at(offset_ + (first + done) * frame, n_here * frame).data();
    (n_bytes_ == 2 ? from_16_bits : from_24_bits)(from, out.data() + done * n_channels_, n_here * n_channels_);
  }
}

}  // namespace bouncelab::audio
