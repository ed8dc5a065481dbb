// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/annotations.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "acoustic/audio/annotation_cases.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {
namespace {

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

TEST(Annotations, AnEditorThatRoundsToItsOwnResolutionLosesNothing) {
  const Onsets onsets = some_onsets();
  Annotations annotations = annotations_of(onsets);
  for (Annotation& point : annotations.points) point.t_s = std::round(point.t_s * 1e6) / 1e6;  // what Audacity writes
  annotations.resolution_s = 1e-6;
  expect_same(onsets_of(annotations, false, "marks"), onsets);
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

TEST(Annotations, ATextGridWithMoreTiersOrPointsThanBytesIsRefused) {
  using testing::HasSubstr;
  const std::string head = "\"ooTextFile\" \"TextGrid\" 0 1 ";
  for (const std::string count : {"1e61", "-1", "1.5", "9000000000000000000"}) {
    EXPECT_THAT(refusal([&] { parse_text_grid(head + count + " \"TextTier\"", "a.TextGrid"); }), HasSubstr("tiers"));
    EXPECT_THAT(refusal([&] { parse_text_grid(head + "1 \"TextTier\" \"a\" 0 1 " + count, "a.TextGrid"); }),
                HasSubstr("points"));
  }
  // or with fewer than there are
  EXPECT_THAT(refusal([&] { parse_text_grid(head + "1 \"TextTier\" \"a\" 0 1 1 0.5 \"\" 0.7 \"\"", "a.TextGrid"); }),
              HasSubstr("has more points than it says"));
}

TEST(Annotations, ALabelWithAnEnormousNumberIsNotThatOfAnImpact) {
  const Onsets onsets = onsets_of(
      parse_audacity_labels("1\t1\t0.9223372036854775807 t_s=1\n2\t2\t0.5 t_s=2\n3\t3\t9999999999999999.0\n", "a.txt"),
      false, "marks");
  ASSERT_EQ(onsets.size(), 3U);
  EXPECT_EQ(onsets[0].impact, 0);
  EXPECT_EQ(onsets[0].flags, Flags{Flag::by_hand});
  EXPECT_EQ(onsets[1].impact, 5);
  EXPECT_EQ(onsets[2].drop, 0);
  EXPECT_EQ(onsets[2].impact, 6);
}

TEST(Annotations, AMarkAfterTheGreatestNumberIsRefused) {
  EXPECT_THAT(
      refusal([] { onsets_of(parse_audacity_labels("1\t1\t0.1000000000000000 t_s=1\n2\t2\t\n", "a"), false, "a"); }),
      testing::HasSubstr("a: no number is left for the mark at 2 s"));
}

TEST(Annotations, ANumberInALabelThatNoTableOfOnsetsHoldsIsNotKnown) {
  const std::string labels =
      "1\t1\t0.0 t_s=1 sigma_t_s=0 amplitude=-1 snr_db=30\n2\t2\t0.1 t_s=2 sigma_t_s=1e11 amplitude=1e40\n";
  const Onsets onsets = onsets_of(parse_audacity_labels(labels, "a.txt"), false, "marks");
  ASSERT_EQ(onsets.size(), 2U);
  for (const Onset& onset : onsets) {
    EXPECT_FALSE(onset.sigma_t_s);
    EXPECT_FALSE(onset.amplitude);
  }
  EXPECT_EQ(onsets[0].snr_db, 30.0);
  EXPECT_NO_THROW(onsets_from_table(to_table(onsets), "a.csv"));
}

TEST(Annotations, OnsetsAreInTheOrderOfTheTimesInTheirLabels) {
  // on one frame of 48 kHz; the second's own time is earlier
  const Onsets onsets =
      onsets_of({"a.wav", 1.0 / 48000.0, {{0.002, "5.1"}, {0.002, "1.1 t_s=0.001999"}}}, false, "marks");
  ASSERT_EQ(onsets.size(), 2U);
  EXPECT_EQ(onsets[0].drop, 1);
  EXPECT_EQ(onsets[1].drop, 5);
}

TEST(Annotations, ALabelBeforeCarriageReturnsIsTheSameWhenWrittenAndReadAgain) {
  const Annotations once = parse_audacity_labels("1\t1\ta\r\r\n", "a.txt");
  const Annotations twice = parse_audacity_labels(audacity_labels(once), "a.txt");
  EXPECT_EQ(once.points[0].label, "a");
  EXPECT_EQ(twice.points[0].label, "a");
}

TEST(Annotations, ALayerWithAttributesWithoutNamesIsRefusedInLinearMemory) {
  std::string points;  // the quadratic reader took 3 GB for these 200 kB, and 300 GB for ten times as many
  for (int k = 0; k < 200000; ++k) points += "<point   =\"1\"";
  EXPECT_THAT(refusal([&] { parse_sonic_visualiser_layer(svl("44100", points), "a.svl"); }),
              testing::HasSubstr("not XML from byte"));
}

TEST(Annotations, ALayerNestedAHundredThousandDeepIsRead) {
  std::string open, close;
  for (int k = 0; k < 100000; ++k) open += "<g>", close += "</g>";
  EXPECT_EQ(parse_sonic_visualiser_layer(svl("10", open + "<point frame='5' label='a&#10;b'/>" + close), "a.svl")
                .points.at(0)
                .label,
            "a\nb");
}

}  // namespace
}  // namespace bouncelab::audio
