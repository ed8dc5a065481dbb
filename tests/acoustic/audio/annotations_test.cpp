// SPDX-License-Identifier: GPL-3.0-or-later
// Onsets as the marks of editors: labels, layers, grids, cue points of WAV files.
#include "bouncelab/audio/annotations.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/onsets.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

namespace fs = std::filesystem;
using test::refusal;

/// Two drops with all that an onset can have, and numbers that need every digit.
Onsets some_onsets() {
  Onsets onsets;
  for (int k = 0; k < 60; ++k) {
    Onset onset;
    onset.recording = "drop \"1\" & <2>.wav";
    onset.drop = k / 40;
    onset.impact = k % 40 + (k > 30 ? 1 : 0);  // one is missing
    onset.t_s = 0.1 + std::sqrt(2.0 + k) + 1e-9 / (k + 3.0);
    if (k % 3 != 0) onset.sigma_t_s = 1e-7 / (k + 1.0);
    if (k % 4 != 0) onset.amplitude = 1.0 / (k + 7.0);
    if (k % 5 != 0) onset.snr_db = -3.0 + k / 7.0;
    if (k % 6 != 0) onset.probability = 1.0 / (k + 1.0);
    if (k % 7 == 0) onset.flags = {Flag::clipped, Flag::doubtful};
    onsets.push_back(onset);
  }
  return onsets;
}

void expect_same(const Onsets& a, const Onsets& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(a[k].drop, b[k].drop);
    EXPECT_EQ(a[k].impact, b[k].impact);
    EXPECT_EQ(a[k].t_s, b[k].t_s);
    EXPECT_EQ(a[k].sigma_t_s, b[k].sigma_t_s);
    EXPECT_EQ(a[k].amplitude, b[k].amplitude);
    EXPECT_EQ(a[k].snr_db, b[k].snr_db);
    EXPECT_EQ(a[k].flags, b[k].flags);
    EXPECT_EQ(a[k].probability, b[k].probability);
  }
}

TEST(Annotations, ShortLabelsFitAndAreCompletedByTheOnsets) {
  const Onsets onsets = some_onsets();
  const Annotations full = annotations_of(onsets), brief = shortened(full);
  for (std::size_t k = 0; k < onsets.size(); ++k) {
    const std::string& label = brief.points[k].label;
    EXPECT_LE(label.size(), 20u) << label;
    const std::string number = std::to_string(onsets[k].drop) + "." + std::to_string(onsets[k].impact);
    EXPECT_THAT(label, ::testing::StartsWith(number));
    EXPECT_EQ(brief.points[k].t_s, onsets[k].t_s);
    if (onsets[k].flags.empty()) {
      EXPECT_EQ(label, number);
    } else {
      // both where they fit: behind three characters, not behind four
      EXPECT_EQ(label, number + (number.size() <= 3 ? " clipped|doubtful" : " clipped"));
    }
  }
  Annotations back = completed(parse_audacity_labels(audacity_labels(brief), "x.txt"), onsets);
  back.recording = onsets.front().recording;
  expect_same(onsets_of(back, false, "marks"), onsets);
  // moved, named anew, or taken away: that one alone
  back = brief;
  back.points[3].t_s += 1e-4;
  back.points[4].label = "here it was";
  back.points.pop_back();
  const Onsets corrected = onsets_of(completed(back, onsets), false, "marks");
  ASSERT_EQ(corrected.size(), onsets.size() - 1);
  for (const std::size_t k : {3U, 4U}) {
    EXPECT_EQ(corrected[k].flags, Flags{Flag::by_hand});
    EXPECT_FALSE(corrected[k].sigma_t_s);
  }
  EXPECT_EQ(corrected[5].sigma_t_s, onsets[5].sigma_t_s);
}

TEST(Annotations, TextFormatsGiveBackEveryBit) {
  const Onsets onsets = some_onsets();
  const Annotations annotations = annotations_of(onsets);
  expect_same(onsets_of(parse_audacity_labels(audacity_labels(annotations), "a.txt"), false, "marks"), onsets);
  const Onsets from_layer = onsets_of(
      parse_sonic_visualiser_layer(sonic_visualiser_layer(annotations, 44100, 500000), "a.svl"), false, "marks");
  expect_same(from_layer, onsets);
  EXPECT_EQ(from_layer.front().recording, onsets.front().recording);
  const Onsets from_grid = onsets_of(parse_text_grid(text_grid(annotations, 12.0), "a.TextGrid"), false, "marks");
  expect_same(from_grid, onsets);
  EXPECT_EQ(from_grid.front().recording, onsets.front().recording);
}

TEST(Annotations, AnEditorThatRoundsToItsOwnResolutionLosesNothingAndMovesMarksByAStepOfIt) {
  const Onsets onsets = some_onsets();
  Annotations annotations = annotations_of(onsets);
  for (Annotation& point : annotations.points) point.t_s = std::round(point.t_s * 1e6) / 1e6;  // what Audacity writes
  annotations.resolution_s = 1e-6;
  expect_same(onsets_of(annotations, false, "marks"), onsets);
  for (std::size_t k = 0; k < onsets.size(); ++k) annotations.points[k].t_s += k % 2 == 0 ? 1e-6 : -1e-6;
  for (const Onset& moved : onsets_of(annotations, false, "marks"))
    EXPECT_TRUE(moved.flags == Flags{Flag::by_hand} && !moved.sigma_t_s) << moved.impact;
}

TEST(Annotations, AMarkThatWasMovedOrMadeCountsAsItStands) {
  const Onsets onsets = some_onsets();
  Annotations annotations = annotations_of(onsets);
  annotations.resolution_s = 1e-6;
  annotations.points[3].t_s += 1e-4;
  const double between_s = 0.5 * (onsets[10].t_s + onsets[11].t_s);
  annotations.points.push_back({between_s, "here too"});
  annotations.points.push_back({0.01, ""});
  const Onsets corrected = onsets_of(annotations, false, "marks");
  ASSERT_EQ(corrected.size(), 62u);
  EXPECT_EQ(corrected[0].t_s, 0.01);
  EXPECT_EQ(corrected[0].drop, 0);
  EXPECT_EQ(corrected[4].t_s, onsets[3].t_s + 1e-4);
  EXPECT_EQ(corrected[4].flags, Flags{Flag::by_hand});
  EXPECT_FALSE(corrected[4].sigma_t_s || corrected[4].amplitude || corrected[4].snr_db);
  EXPECT_EQ(corrected[12].t_s, between_s);
  EXPECT_EQ(corrected[12].flags, Flags{Flag::by_hand});
  for (std::size_t k = 1; k < 42; ++k)
    EXPECT_GT(corrected[k].impact, corrected[k - 1].impact) << "two came in: all move up";
  EXPECT_EQ(corrected[42].impact, onsets[40].impact) << "the next drop keeps its numbers";
}

TEST(Annotations, AMarkThatWasMissingTakesTheFreeNumber) {
  Annotations annotations = annotations_of(some_onsets());
  annotations.resolution_s = 1e-6;
  const Onsets before = onsets_of(annotations, false, "marks");
  ASSERT_EQ(before[31].impact, before[30].impact + 2);
  annotations.points.push_back({0.5 * (before[30].t_s + before[31].t_s), "missed"});
  const Onsets after = onsets_of(annotations, false, "marks");
  for (std::size_t k = 1; k <= 40; ++k) EXPECT_EQ(after[k].impact, after[k - 1].impact + 1);
}

TEST(Annotations, AfterOneWasTakenAwayTheRestIsNumberedAnewOnRequest) {
  Annotations annotations = annotations_of(some_onsets());
  annotations.points.erase(annotations.points.begin() + 10);
  EXPECT_EQ(onsets_of(annotations, false, "marks")[10].impact, 11);
  const Onsets renumbered = onsets_of(annotations, true, "marks");
  for (std::size_t k = 0; k < 39; ++k) EXPECT_EQ(renumbered[k].impact, static_cast<std::int64_t>(k));
  EXPECT_EQ(renumbered[39].drop, 1);
  EXPECT_EQ(renumbered[39].impact, 0);
}

TEST(Annotations, ReadsWhatTheEditorsThemselvesWrite) {
  const Annotations audacity =
      parse_audacity_labels("0.500000\t0.500000\t0.0 clipped\r\n\\\t100.0\t900.0\r\n1.25\t1.5\thit\r\n", "a");
  ASSERT_EQ(audacity.points.size(), 2u);
  const Onsets onsets = onsets_of(audacity, false, "marks");
  EXPECT_EQ(onsets[0].flags, Flags{Flag::clipped});
  EXPECT_EQ(onsets[1].t_s, 1.25);
  EXPECT_EQ(onsets[1].impact, 1);

  const Annotations layer = parse_sonic_visualiser_layer(
      "<?xml version=\"1.0\"?>\n<!DOCTYPE sonic-visualiser>\n<sv>\n<data>\n<model id='7' name='a' sampleRate='48000' "
      "start='96' "
      "type='sparse' />\n<dataset id=\"6\" dimensions=\"1\">\n<point frame=\"96000\" label=\"New &amp; "
      "Point\"/>\n<point\n "
      "label=\"\"  frame=\"120000\" ></point></dataset></data></sv>",
      "a");
  ASSERT_EQ(layer.points.size(), 2u);
  EXPECT_EQ(layer.points[0].t_s, 2.0);
  EXPECT_EQ(layer.points[0].label, "New & Point");
  EXPECT_EQ(layer.points[1].t_s, 2.5);

  // short text, an interval tier first
  const Annotations grid = parse_text_grid(
      "File type = \"ooTextFile\"\nObject class = "
      "\"TextGrid\"\n\n0\n2.3\n<exists>\n2\n\"IntervalTier\"\n\"words\"\n0\n2.3\n1\n0\n2.3\n"
      "\"a \"\"b\"\"\"\n\"TextTier\"\n\"bell\"\n0\n2.3\n2\n0.5\n\"\"\n1.75\n\"two\nlines\"\n",
      "a");
  ASSERT_EQ(grid.points.size(), 2u);
  EXPECT_EQ(grid.recording, "bell");
  EXPECT_EQ(grid.points[1].t_s, 1.75);
  EXPECT_EQ(grid.points[1].label, "two\nlines");
}

TEST(Annotations, WhatIsNotMarksIsNamed) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal([] { parse_audacity_labels("0.1\t0.1\tx\nbounce at 0.2\n", "a.txt"); }),
              HasSubstr("a.txt: line 2"));
  EXPECT_THAT(refusal([] { parse_audacity_labels("nan\t0.1\tx\n", "a.txt"); }), HasSubstr("line 1"));
  EXPECT_THAT(refusal([] { parse_sonic_visualiser_layer("<html><p>no</p></html>", "a.svl"); }),
              HasSubstr("sampleRate"));
  EXPECT_THAT(refusal([] { parse_sonic_visualiser_layer("<model sampleRate=\"9\"/><point frame=\"x\"/>", "a.svl"); }),
              HasSubstr("frame"));
  EXPECT_THAT(refusal([] { parse_sonic_visualiser_layer("<model sampleRate=\"44100", "a.svl"); }),
              HasSubstr("cut off"));
  EXPECT_THAT(refusal([] { parse_text_grid("once upon a time", "a.TextGrid"); }), HasSubstr("TextGrid"));
  const std::string grid = text_grid(annotations_of(some_onsets()), 9.0);
  EXPECT_THAT(refusal([&] { parse_text_grid(grid.substr(0, grid.size() / 2), "a.TextGrid"); }), HasSubstr("cut off"));
  EXPECT_THAT(refusal([] { annotations_of({}); }), HasSubstr("no onsets"));
  EXPECT_THAT(refusal([] {
                Onsets two = some_onsets();
                two.back().recording = "b.wav";
                annotations_of(two);
              }),
              HasSubstr("choose it"));
}

std::string svl(const std::string& rate, const std::string& points) {
  return "<sv><data><model name='a' sampleRate='" + rate + "'/>" + points + "</data></sv>";
}

TEST(Annotations, TimesThatNoRecordingHasAreRefused) {
  using testing::HasSubstr;
  for (const std::string rate : {"1e-300", "0", "-44100", "1e300"})
    EXPECT_THAT(refusal([&] { parse_sonic_visualiser_layer(svl(rate, "<point frame='1'/>"), "a.svl"); }),
                HasSubstr("sampleRate '" + rate + "'"));
  EXPECT_THAT(refusal([] { parse_sonic_visualiser_layer(svl("44100", "<point frame='1e300'/>"), "a.svl"); }),
              HasSubstr("point 1: a time of"));
  EXPECT_THAT(refusal([] { parse_audacity_labels("0.1\t0.1\t\n1e308\t1e308\t\n", "a.txt"); }),
              HasSubstr("line 2: a time of 1e+308 s"));
  EXPECT_THAT(refusal([] {
                parse_text_grid("\"ooTextFile\" \"TextGrid\" 0 1 1 \"TextTier\" \"a\" 0 1 1 1e300 \"\"", "a.TextGrid");
              }),
              HasSubstr("point 1: a time of"));
}

TEST(Annotations, ALayerNestedAHundredThousandDeepIsRead) {
  std::string open, close;
  for (int k = 0; k < 100000; ++k) open += "<g>", close += "</g>";
  EXPECT_EQ(parse_sonic_visualiser_layer(svl("10", open + "<point frame='5' label='a&#10;b'/>" + close), "a.svl")
                .points.at(0)
                .label,
            "a\nb");
}

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
  static void copy_with_cues(const fs::path& recording, const Annotations& annotations, const fs::path& out,
                             const std::string& name) {
    std::ofstream file(out, std::ios::binary);
    audio::copy_with_cues(
        recording, annotations, [&](std::string_view bytes) { file << bytes; }, name);
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
