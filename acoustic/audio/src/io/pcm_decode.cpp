// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/pcm_decode.hpp"

#include <cassert>
#include <cstring>

#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::audio {
namespace {

BOUNCELAB_VECTOR_CLONES void decode_16_bits(const std::byte* from, float* to, std::int64_t n) {
  for (std::int64_t k = 0; k < n; ++k) {
    std::int16_t x;
    std::memcpy(&x, from + 2 * k, sizeof x);
    to[k] = static_cast<float>(x) * 0x1p-15F;
  }
}

/// Each integer goes into the upper three bytes of one of 32 bits, so that its sign comes right.
BOUNCELAB_VECTOR_CLONES void decode_24_bits(const std::byte* from, float* to, std::int64_t n) {
  using Half = unsigned char __attribute__((vector_size(16)));
  using Bytes = unsigned char __attribute__((vector_size(32)));
  using Integers = std::int32_t __attribute__((vector_size(32)));
  using Floats = float __attribute__((vector_size(32)));
  constexpr std::int64_t kAtOnce = 8;  // in two halves, of each of which 12 of 16 bytes are needed
  std::int64_t k = 0;
  for (; 3 * k + 28 <= 3 * n; k += kAtOnce) {
    Half a, b;
    std::memcpy(&a, from + 3 * k, sizeof a);
    std::memcpy(&b, from + 3 * k + 12, sizeof b);
    const Bytes x = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19,
                                            20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31);
    // 32: a byte of the second operand, which is zero
    const Bytes high = __builtin_shufflevector(x, Bytes{}, 32, 0, 1, 2, 32, 3, 4, 5, 32, 6, 7, 8, 32, 9, 10, 11,  //
                                               32, 16, 17, 18, 32, 19, 20, 21, 32, 22, 23, 24, 32, 25, 26, 27);
    const Floats value = __builtin_convertvector(reinterpret_cast<Integers>(high), Floats) * 0x1p-31F;
    std::memcpy(to + k, &value, sizeof value);
  }
  for (; k < n; ++k) {
    const auto byte = [&](int b) { return std::to_integer<std::uint32_t>(from[3 * k + b]); };
    const std::uint32_t high = byte(0) << 8 | byte(1) << 16 | byte(2) << 24;
    to[k] = static_cast<float>(static_cast<std::int32_t>(high)) * 0x1p-31F;
  }
}

BOUNCELAB_VECTOR_CLONES void decode_doubles(const std::byte* from, float* to, std::int64_t n) {
  for (std::int64_t k = 0; k < n; ++k) {
    double x;
    std::memcpy(&x, from + 8 * k, sizeof x);
    to[k] = static_cast<float>(x);
  }
}

}  // namespace

int bytes_per_sample(PlainEncoding encoding) {
  switch (encoding) {
    case PlainEncoding::none:
      return 0;
    case PlainEncoding::int16:
      return 2;
    case PlainEncoding::int24:
      return 3;
    case PlainEncoding::float32:
      return 4;
    case PlainEncoding::float64:
      break;
  }
  return 8;
}

void decode_pcm(std::span<const std::byte> from, PlainEncoding encoding, std::span<float> out) {
  const auto n = std::ssize(out);
  assert(std::ssize(from) >= n * bytes_per_sample(encoding));
  if (encoding == PlainEncoding::int16) decode_16_bits(from.data(), out.data(), n);
  if (encoding == PlainEncoding::int24) decode_24_bits(from.data(), out.data(), n);
  if (encoding == PlainEncoding::float64) decode_doubles(from.data(), out.data(), n);
  if (encoding == PlainEncoding::float32 && n > 0) std::memcpy(out.data(), from.data(), out.size_bytes());
}

}  // namespace bouncelab::audio
