// SPDX-License-Identifier: GPL-3.0-or-later
// Samples decoded without libsndfile: of any bytes as by the definition, of a file as libsndfile gives them.
#include <algorithm>
#include <bit>
#include <span>
#include <string_view>
#include <vector>

#include "io/pcm_decode.hpp"
#include "io/sound_decoder.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

using audio::PlainEncoding;

constexpr std::string_view kContainers[] = {"RIFF", "RF64", "riff", "FORM", ".snd", "caff"};

bool is_same(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

float by_definition(Bytes sample, PlainEncoding encoding) {
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k < sample.size(); ++k) bits |= std::uint32_t{sample[k]} << (8 * k);
  if (encoding == PlainEncoding::float32) return std::bit_cast<float>(bits);
  const double full_scale = encoding == PlainEncoding::int16 ? 0x1p15 : 0x1p23;
  const auto value = static_cast<double>(bits);
  return static_cast<float>((value >= full_scale ? value - 2.0 * full_scale : value) / full_scale);
}

void check_decoding(Bytes input, PlainEncoding encoding) {
  const auto n_bytes = static_cast<std::size_t>(bytes_per_sample(encoding));
  std::vector<float> decoded(input.size() / n_bytes);
  // a copy of that length, so that a read beyond it is found
  const std::vector<std::uint8_t> copy(input.begin(),
                                       input.begin() + static_cast<std::ptrdiff_t>(decoded.size() * n_bytes));
  audio::decode_pcm(std::as_bytes(std::span(copy)), encoding, decoded);
  for (std::size_t k = 0; k < decoded.size(); ++k)
    require(is_same(decoded[k], by_definition(input.subspan(k * n_bytes, n_bytes), encoding)),
            "samples are decoded as they are defined");
}

/// The first samples of a file with plain samples, from its bytes and by libsndfile.
void check_file(Bytes input) {
  audio::SoundDecoder decoder(audio::SoundBytes(std::as_bytes(input)), "input");
  const audio::SoundInfo& info = decoder.info();
  if (info.plain == PlainEncoding::none) return;
  const std::int64_t n = std::min<std::int64_t>(info.n_frames, 2000 / info.n_channels + 1) * info.n_channels;
  std::vector<float> expected(static_cast<std::size_t>(n)), decoded(expected.size());
  decoder.read(0, expected);
  audio::decode_pcm(std::as_bytes(input).subspan(static_cast<std::size_t>(info.first_byte),
                                                 static_cast<std::size_t>(n * bytes_per_sample(info.plain))),
                    info.plain, decoded);
  require(std::equal(expected.begin(), expected.end(), decoded.begin(), is_same), "a file is decoded as by libsndfile");
}

}  // namespace

void run(Bytes input) {
  for (const PlainEncoding encoding : {PlainEncoding::int16, PlainEncoding::int24, PlainEncoding::float32})
    check_decoding(input, encoding);
  const bool is_container = std::any_of(std::begin(kContainers), std::end(kContainers),
                                        [&](std::string_view head) { return text_of(input).starts_with(head); });
  if (is_container) accepts([&] { check_file(input); });
}

}  // namespace bouncelab::fuzz
