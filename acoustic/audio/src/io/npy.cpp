// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/numbers.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <vector>

#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kLongestNpyHead_bytes = 1 << 16;
constexpr std::int64_t kMostNpyChannels = 1024;

struct NumberType {
  std::string_view name;
  int coding = 0;  ///< as libsndfile numbers it
  std::int64_t n_bytes = 0;
};

/// What stands behind 'KEY': in the head, a Python dictionary that NumPy writes in one way.
std::string_view value_behind(std::string_view head, std::string_view key) {
  const std::size_t at = head.find(key);
  if (at == std::string_view::npos) return {};
  std::string_view value = head.substr(at + key.size());
  value.remove_prefix(std::min(value.find_first_not_of(": "), value.size()));
  return value;
}

/// (1000,) or (1000, 2).
std::vector<std::int64_t> shape_in(std::string_view text) {
  std::vector<std::int64_t> shape;
  if (text.empty() || text.front() != '(') return shape;
  const char *at = text.data() + 1, *end = text.data() + text.size();
  while (at < end) {
    std::int64_t n = 0;
    const auto [rest, error] = std::from_chars(at, end, n);
    if (error != std::errc() || n < 0) break;
    shape.push_back(n);
    at = std::find_if(rest, end, [](char c) { return c != ',' && c != ' '; });
  }
  return shape;
}

}  // namespace

bool is_npy(SoundBytes& bytes) { return bytes.text(0, kMagic.size()) == kMagic; }

PlainSound npy_sound(SoundBytes& bytes, const std::string& name, std::optional<double> rate_hz) {
  const auto refuse = [&](const std::string& what) { throw FileError(name, what); };
  const std::string start = bytes.text(0, 12);
  const auto byte = [&](std::size_t k) { return static_cast<std::size_t>(static_cast<unsigned char>(start[k])); };
  if (start.size() < 12) refuse("is a .npy file that was cut off in its head; save it again");
  const bool is_first = start[6] == 1;
  const std::size_t n_head = byte(8) | byte(9) << 8 | (is_first ? 0 : byte(10) << 16 | byte(11) << 24);
  const std::int64_t head_at = is_first ? 10 : 12;
  const std::string head = bytes.text(head_at, std::min(n_head, kLongestNpyHead_bytes));
  if (head.size() < n_head) refuse("is a .npy file that was cut off in its head; save it again");

  PlainSound sound;
  SoundInfo& info = sound.info;
  const std::string type(value_behind(head, "'descr'").substr(0, 5));
  constexpr std::array<NumberType, 3> kTypes{
      {{"'<i2'", SF_FORMAT_PCM_16, 2}, {"'<f4'", SF_FORMAT_FLOAT, 4}, {"'<f8'", SF_FORMAT_DOUBLE, 8}}};
  const auto number = std::find_if(kTypes.begin(), kTypes.end(), [&](const NumberType& t) { return t.name == type; });
  if (number == kTypes.end())
    refuse("holds numbers of the type " + type + "; save them as int16, float32 or float64: x.astype('<f4')");
  const std::vector<std::int64_t> shape = shape_in(value_behind(head, "'shape'"));
  const bool is_c_order = value_behind(head, "'fortran_order'").substr(0, 5) == "False";
  if (shape.empty() || shape.size() > 2) refuse("must have one dimension, or two: samples x channels");
  const std::int64_t n_channels = shape.size() == 2 ? shape[1] : 1;
  if (shape[0] == 0 || n_channels == 0) refuse("holds no samples; record again");
  if (shape.size() == 2 && n_channels > 1 && (!is_c_order || n_channels > std::min(shape[0], kMostNpyChannels)))
    refuse("must be samples x channels in C order; save it so: np.ascontiguousarray(x.T)");
  if (!rate_hz) refuse("a .npy file holds no sampling rate; give it: --rate 48000");
  info.rate_hz = *rate_hz;
  info.n_channels = static_cast<int>(n_channels);
  info.n_frames = shape[0];
  info.may_be_infinite = number->coding != SF_FORMAT_PCM_16;
  sound.coding = number->coding | SF_ENDIAN_LITTLE;
  sound.first_byte = head_at + static_cast<std::int64_t>(n_head);
  info.description = "NumPy, " + type.substr(1, 3);
  const std::int64_t frame_bytes = number->n_bytes * n_channels;
  const std::int64_t n_held = (bytes.size() - sound.first_byte) / frame_bytes;
  if (n_held < info.n_frames) {
    if (n_held <= 0) refuse("holds no samples; save it again");
    info.warning = "the header promises " + std::to_string(info.n_frames) + " samples, the file holds " +
                   std::to_string(n_held) + ": those were read; is it cut off?";
    info.n_frames = n_held;
  }
  return sound;
}

}  // namespace bouncelab::audio
