// SPDX-License-Identifier: GPL-3.0-or-later
// Samples as numbers: a table of text, or NumPy's .npy where the bytes begin as one.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "io/coded_sound.hpp"
#include "io/sound_header.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

void check(const audio::SoundInfo& info) {
  require(info.rate_hz >= 4e3 && info.rate_hz <= 4e6, "the sampling rate is in the range promised");
  require(info.n_channels > 0 && info.n_frames > 0, "there are samples");
}

void read_npy(FileBytes& bytes) {
  const audio::PlainSound sound = audio::npy_sound(bytes, 48e3);
  check(sound.info);
  audio::PlainSamples samples(bytes, sound);
  std::vector<float> last(static_cast<std::size_t>(sound.info.n_channels));
  must_accept("the samples are all in the file", [&] { samples.read(sound.info.n_frames - 1, last); });
}

void read_text(const std::string& text, std::optional<double> rate_hz) {
  std::istringstream in(text);
  audio::DecodedSamples samples("input");
  const audio::SoundInfo info = audio::read_number_text(in, "input", rate_hz, samples);
  check(info);
  require(info.n_frames * info.n_channels <= std::ssize(text), "a sample takes a byte of text at least");
  std::vector<float> all(static_cast<std::size_t>(info.n_frames * info.n_channels));
  samples.read(0, all);
  require(std::none_of(all.begin(), all.end(), [](float x) { return std::isnan(x); }), "no sample is NaN");
}

}  // namespace

void run(Bytes input) {
  FileBytes bytes(std::as_bytes(input), "input");
  if (audio::is_npy(bytes)) {
    accepts([&] { read_npy(bytes); });
    return;
  }
  const std::string text(reinterpret_cast<const char*>(input.data()), input.size());
  accepts([&] { read_text(text, std::nullopt); });
  accepts([&] { read_text(text, 48e3); });
}

}  // namespace bouncelab::fuzz
