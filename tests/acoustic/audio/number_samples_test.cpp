// SPDX-License-Identifier: GPL-3.0-or-later
// Samples as numbers: NumPy's .npy, tables of text as phyphox and oscilloscopes export them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

double sample(int k, int channel) { return 0.5 * std::sin(0.1 * k + channel); }

std::string text_of(double value, const char* format = "%.9g") {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

class NumberSamples : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& content) {
    const auto path = folder_ / "numbers";
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  AudioReader reader_of(const std::string& content, std::optional<double> rate_hz = std::nullopt) {
    return AudioReader(write(content), rate_hz);
  }
  std::string error_of(const std::string& content, std::optional<double> rate_hz = std::nullopt) {
    return test::refusal([&] { reader_of(content, rate_hz); });
  }
  static void expect_samples(AudioReader& reader, double rate_hz, int n_channels, std::int64_t n, double step) {
    EXPECT_EQ(reader.format().rate_hz, rate_hz);
    ASSERT_EQ(reader.format().n_channels, n_channels);
    ASSERT_EQ(reader.format().n_frames, n);
    for (int channel = 0; channel < n_channels; ++channel) {
      std::vector<float> got(static_cast<std::size_t>(n));
      reader.read(0, channel, got);
      for (int k = 0; k < n; ++k) ASSERT_NEAR(got[static_cast<std::size_t>(k)], sample(k, channel), step) << k;
    }
  }

  /// n rows of time and channels.
  static std::string table(int n, int n_channels, double rate_hz, const std::string& separator = ",",
                           double unit_s = 1.0, const char* time_format = "%.9e") {
    std::string text;
    for (int k = 0; k < n; ++k) {
      text += text_of(k / rate_hz / unit_s, time_format);
      for (int c = 0; c < n_channels; ++c) text += separator + text_of(sample(k, c));
      text += "\n";
    }
    return text;
  }
  static std::string with_decimal_comma(std::string text) {
    for (char& c : text)
      if (c == '.') c = ',';
    return text;
  }

  test::TemporaryFolder folder_;
};

/// As numpy.save writes it: the head ends at a multiple of 64 bytes.
template <class T>
std::string npy(const std::string& type, const std::string& shape, const std::vector<T>& values,
                const std::string& order = "False", char version = 1) {
  std::string head = "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
  const std::size_t n_before = version == 1 ? 10 : 12;
  while ((n_before + head.size() + 1) % 64 != 0) head += ' ';
  head += '\n';
  std::string bytes = std::string("\x93NUMPY") + version + '\0' + static_cast<char>(head.size() & 0xFF) +
                      static_cast<char>(head.size() >> 8);
  if (version != 1) bytes += std::string(2, '\0');
  bytes += head;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  return bytes;
}

template <class T>
std::vector<T> interleaved(int n, int n_channels, double full_scale) {
  std::vector<T> values;
  for (int k = 0; k < n; ++k)
    for (int c = 0; c < n_channels; ++c) values.push_back(static_cast<T>(full_scale * sample(k, c)));
  return values;
}

TEST_F(NumberSamples, NpyOfEachTypeOneDimensionAndTwo) {
  const std::string one = "(3000,)", two = "(1500, 2)";
  for (const char version : {'\1', '\2', '\3'}) {
    AudioReader doubles = reader_of(npy("<f8", one, interleaved<double>(3000, 1, 1.0), "False", version), 44100.0);
    expect_samples(doubles, 44100.0, 1, 3000, 1e-7);  // rounded to floats
  }
  AudioReader floats = reader_of(npy("<f4", two, interleaved<float>(1500, 2, 1.0)), 48000.0);
  expect_samples(floats, 48000.0, 2, 1500, 1e-7);
  AudioReader integers = reader_of(npy("<i2", two, interleaved<std::int16_t>(1500, 2, 32768.0)), 96000.0);
  expect_samples(integers, 96000.0, 2, 1500, 0x1p-15);  // one step
}

TEST_F(NumberSamples, NpyThatCannotBeSoundIsRefusedWithTheRemedy) {
  const auto x = interleaved<float>(1500, 2, 1.0);
  EXPECT_THAT(error_of(npy("<f4", "(3000,)", x)), HasSubstr("--rate"));
  EXPECT_THAT(error_of(npy("<i8", "(1500,)", x), 48e3), HasSubstr("astype"));
  EXPECT_THAT(error_of(npy(">f4", "(3000,)", x), 48e3), HasSubstr("astype"));
  EXPECT_THAT(error_of(npy("<f4", "(1500, 2)", x, "True"), 48e3), HasSubstr("ascontiguousarray"));
  EXPECT_THAT(error_of(npy("<f4", "(2, 1500)", x), 48e3), HasSubstr("ascontiguousarray"));
  EXPECT_THAT(error_of(npy("<f4", "(10, 10, 30)", x), 48e3), HasSubstr("one dimension, or two"));
  EXPECT_THAT(error_of(npy("<f4", "(0,)", x), 48e3), HasSubstr("no samples"));
  EXPECT_THAT(error_of(npy("<f4", "(99999999999999999999,)", x), 48e3), HasSubstr("one dimension, or two"));
  EXPECT_THAT(error_of(npy("<f4", "(3000,)", x).substr(0, 40), 48e3), HasSubstr("cut off"));
  EXPECT_THAT(error_of(npy("<f4", "(3000,)", x), 100.0), HasSubstr("4 kHz"));
}

TEST_F(NumberSamples, NpyThatIsCutOffIsReadUpToThere) {
  std::string bytes = npy("<f4", "(1500, 2)", interleaved<float>(1500, 2, 1.0));
  bytes.resize(bytes.size() - 4001);
  AudioReader reader = reader_of(bytes, 48e3);
  EXPECT_THAT(reader.format().warning, AllOf(HasSubstr("promises 1500"), HasSubstr("holds 999")));
  expect_samples(reader, 48e3, 2, 999, 1e-7);
}

TEST_F(NumberSamples, TableAsPhyphoxExportsItInEachOfItsFormats) {
  const std::string titles = "\"Time (s)\",\"Recording (a.u.)\"\n";
  for (const char separator : {',', ';', '\t'}) {
    std::string head = titles;
    for (char& c : head)
      if (c == ',') c = separator;
    AudioReader reader = reader_of(head + table(3000, 1, 48000.0, std::string(1, separator)));
    expect_samples(reader, 48000.0, 1, 3000, 1e-7);
    if (separator == ',') continue;
    AudioReader with_commas = reader_of(with_decimal_comma(head + table(3000, 1, 48000.0, std::string(1, separator))));
    expect_samples(with_commas, 48000.0, 1, 3000, 1e-7);
  }
}

TEST_F(NumberSamples, TablesAsOscilloscopesExportThem) {
  // PicoScope: units in a line of their own; Keysight: a unit for a title; others: settings first, blanks, comments
  AudioReader pico = reader_of("\xEF\xBB\xBFTime,Channel A,Channel B\r\n(ms),(V),(V)\r\n\r\n" +
                               table(2000, 2, 50000.0, ",", 1e-3, "%.8f"));
  expect_samples(pico, 50000.0, 2, 2000, 1e-7);
  AudioReader keysight = reader_of("x-axis,1\nsecond,Volt\n" + table(2000, 1, 1e6));
  expect_samples(keysight, 1e6, 1, 2000, 1e-7);
  AudioReader other = reader_of("Model,XY-1000\nRecord length,2000\n# a comment\nt [\xC2\xB5s];U [V]\n" +
                                table(2000, 1, 250000.0, ";", 1e-6, "%.1f"));
  expect_samples(other, 250000.0, 1, 2000, 1e-7);
  AudioReader blanks = reader_of(table(2000, 1, 44100.0, "   "));
  EXPECT_NEAR(blanks.format().rate_hz, 44100.0, 1e-3);  // 1/44100 s has no end, and was rounded to 10 digits
  EXPECT_EQ(blanks.format().n_channels, 1);
}

TEST_F(NumberSamples, WithoutTimesTheRateIsGiven) {
  std::string one, counted;
  for (int k = 0; k < 500; ++k) {
    one += text_of(sample(k, 0)) + "\n";
    counted += std::to_string(k) + "," + text_of(sample(k, 0)) + ",\n";
  }
  AudioReader reader = reader_of(one, 44100.0);
  expect_samples(reader, 44100.0, 1, 500, 1e-7);
  AudioReader scope = reader_of("Sequence,VOLT,\n" + counted, 1e6);
  expect_samples(scope, 1e6, 1, 500, 1e-7);
  EXPECT_THAT(error_of(one), HasSubstr("--rate"));
  EXPECT_THAT(error_of(table(500, 1, 48000.0), 48000.0), HasSubstr("leave --rate out"));
}

TEST_F(NumberSamples, TimesThatAreRoundedAreUniformAndGiveTheRate) {
  // to 1 us, 1/20 of a step: the rate follows to 0.5 us in 0.1 s, within which 48000 is the whole number
  AudioReader reader = reader_of("Time (s),x\n" + table(5000, 1, 48000.0, ",", 1.0, "%.6f"));
  EXPECT_EQ(reader.format().rate_hz, 48000.0);
}

TEST_F(NumberSamples, TimesThatAreNotUniformAreRefusedWithTheLine) {
  std::string text = "Time (s),x\n", missing = text, backwards = text, drifting = text;
  for (int k = 0; k < 5000; ++k) {
    const std::string x = "," + text_of(sample(k, 0)) + "\n";
    missing += text_of((k < 3000 ? k : k + 1) / 48000.0, "%.9f") + x;
    backwards += text_of((k == 3000 ? k - 4000 : k) / 48000.0, "%.9f") + x;
    // a hundredth of a step faster after the middle: 25 steps at the end
    drifting += text_of((k + std::max(0, k - 2500) * 0.01) / 48000.0, "%.9f") + x;
  }
  EXPECT_THAT(error_of(missing), HasSubstr("line 3002: time 0.0625"));
  EXPECT_THAT(error_of(backwards), HasSubstr("line 3002"));
  EXPECT_THAT(error_of(drifting), HasSubstr("must follow at one rate"));
}

TEST_F(NumberSamples, ABadCellOrRowIsNamed) {
  EXPECT_THAT(error_of("t (s),x\n" + table(100, 1, 48000.0) + "0.5,abc\n"), HasSubstr("line 102, column 2: 'abc'"));
  EXPECT_THAT(error_of("t (s),x\n" + table(100, 1, 48000.0) + "0.5\n"), HasSubstr("line 102 has 1 cells"));
  EXPECT_THAT(error_of("t (s),x\n" + table(100, 1, 48000.0) + "0.5,nan\n"), HasSubstr("'nan'"));
  EXPECT_THAT(error_of("0,123\n0,456\n", 48000.0), HasSubstr("one number or two"));
  EXPECT_THAT(error_of("t (s),x\n" + table(100, 1, 100.0)), HasSubstr("sampling rate 100 Hz"));
}

}  // namespace
}  // namespace bouncelab::audio
