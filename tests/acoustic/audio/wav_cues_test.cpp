// SPDX-License-Identifier: GPL-3.0-or-later
// Onsets as cue points of WAV files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <span>

#include "acoustic/audio/annotation_cases.hpp"
#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/audio/audio_writer.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

namespace fs = std::filesystem;

constexpr int kRate_hz = 44100;

class Cues : public testing::Test {
 protected:
  std::string bytes(const fs::path& path) const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write_sound(const std::string& name, SampleEncoding encoding) const {
    AudioWriter writer(folder_ / name, {kRate_hz, 1, encoding}, 400001, false);
    std::vector<double> x(400001);  // odd: 24 bits need a pad byte
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = 0.5 * std::sin(0.1 * static_cast<double>(k));
    writer.write(x);
    writer.commit();
  }
  std::vector<double> samples(const fs::path& path, SF_INFO& info) const {
    info = {};
    SNDFILE* file = sf_open(path.c_str(), SFM_READ, &info);
    if (!file) return {};
    std::vector<double> x(static_cast<std::size_t>(info.frames));
    sf_read_double(file, x.data(), info.frames);
    sf_close(file);
    return x;
  }
  test::TemporaryFolder folder_;
};

TEST_F(Cues, ACopyOfTheRecordingHoldsThemAndItsSamplesAreUntouched) {
  const Onsets onsets = some_onsets();
  for (const std::string extension : {".wav", ".rf64"}) {
    const fs::path original = folder_ / ("a" + extension), marked = folder_ / ("b" + extension),
                   again = folder_ / ("c" + extension);
    write_sound(original.filename(), SampleEncoding::pcm24);
    copy_with_cues(original, annotations_of(onsets), marked, "b");
    expect_same(onsets_of(read_cues(marked), false, "marks"), onsets);
    const std::string in_memory = bytes(marked);
    expect_same(onsets_of(parse_cues(std::as_bytes(std::span(in_memory)), "b"), false, "marks"), onsets);
    SF_INFO info, before;
    EXPECT_EQ(samples(marked, info), samples(original, before));
    EXPECT_EQ(info.format, before.format);
    EXPECT_EQ(info.frames, 400001);
    // cues are replaced, not added
    copy_with_cues(marked, annotations_of(onsets), again, "c");
    EXPECT_EQ(bytes(again), bytes(marked));
  }
}

TEST_F(Cues, OtherProgramsReadThem) {
  write_sound("a.wav", SampleEncoding::pcm16);
  copy_with_cues(folder_ / "a.wav", annotations_of(some_onsets()), folder_ / "b.wav", "b.wav");
  SF_INFO info{};
  SNDFILE* file = sf_open((folder_ / "b.wav").c_str(), SFM_READ, &info);
  ASSERT_NE(file, nullptr);
  SF_CUES cues{};
  ASSERT_EQ(sf_command(file, SFC_GET_CUE, &cues, sizeof cues), SF_TRUE);
  sf_close(file);
  EXPECT_EQ(cues.cue_count, 60u);
  EXPECT_EQ(cues.cue_points[7].sample_offset, std::llround(some_onsets()[7].t_s * kRate_hz));
}

TEST_F(Cues, ManyThousandAreNoProblem) {
  write_sound("a.wav", SampleEncoding::pcm16);
  Onsets many;
  for (int k = 0; k < 20000; ++k) {
    Onset onset;
    onset.impact = k;
    onset.t_s = 4e-4 * k + 1e-5;
    many.push_back(onset);
  }
  copy_with_cues(folder_ / "a.wav", annotations_of(many), folder_ / "b.wav", "b.wav");
  expect_same(onsets_of(read_cues(folder_ / "b.wav"), false, "marks"), many);
}

TEST_F(Cues, ASampleRateThatIsNoneIsRefused) {
  write_sound("a.wav", SampleEncoding::pcm16);
  copy_with_cues(folder_ / "a.wav", annotations_of(some_onsets()), folder_ / "b.wav", "b.wav");
  std::string file = bytes(folder_ / "b.wav");
  std::fill_n(file.begin() + static_cast<std::ptrdiff_t>(file.find("fmt ")) + 12, 4, '\xFF');
  EXPECT_THAT(refusal([&] { parse_cues(std::as_bytes(std::span(file)), "b.wav"); }),
              testing::HasSubstr("sample rate 4294967295 Hz"));
}

TEST_F(Cues, OtherFilesAreRefused) {
  write_sound("a.flac", SampleEncoding::pcm16);
  write_sound("a.wav", SampleEncoding::pcm16);
  const Annotations annotations = annotations_of(some_onsets());
  EXPECT_THAT(refusal([&] { copy_with_cues(folder_ / "a.flac", annotations, folder_ / "b.wav", "b.wav"); }),
              testing::HasSubstr("neither WAV nor RF64"));
  EXPECT_THAT(refusal([&] { read_cues(folder_ / "a.wav"); }), testing::HasSubstr("no cue points"));
  EXPECT_THAT(refusal([&] { read_cues(folder_ / "none.wav"); }), testing::HasSubstr("none.wav"));
  Annotations far = annotations;
  far.points[0].t_s = 1e6;
  EXPECT_THAT(refusal([&] { copy_with_cues(folder_ / "a.wav", far, folder_ / "b.wav", "b.wav"); }),
              testing::HasSubstr("1000000"));
  fs::resize_file(folder_ / "a.wav", 1000);
  EXPECT_THAT(refusal([&] { copy_with_cues(folder_ / "a.wav", annotations, folder_ / "b.wav", "b.wav"); }),
              testing::HasSubstr("cut off"));
}

}  // namespace
}  // namespace bouncelab::audio
