// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "bouncelab/fit/between_recordings.hpp"

namespace bouncelab::fit {
namespace {

TEST(RecordingDate, IsReadFromIso) {
  EXPECT_EQ(date_from_iso("1970-01-02"), std::nullopt);  // before 1990
  ASSERT_TRUE(date_from_iso("2000-03-01"));
  EXPECT_EQ(date_from_iso("2000-03-01")->calendar_day, 11017);  // 30 years, 7 leap days, 31 + 29 days
  EXPECT_EQ(date_from_iso("2000-03-01")->day, 11017.5);
  EXPECT_EQ(date_from_iso("2000-03-01T06:00")->day, 11017.25);
  EXPECT_EQ(date_from_iso("2000-03-01 06:00:00.0Z")->day, 11017.25);
  EXPECT_EQ(date_from_iso("20000301T0600")->day, 11017.25);
  EXPECT_EQ(date_from_iso("2000-03-01T07:00+01:00")->day, 11017.25);
  EXPECT_EQ(iso_in_words(*date_from_iso("2000-02-29T23:59:58")), "2000-02-29T23:59:58");
  for (const char* text :
       {"", "2001-02-29", "2000-13-01", "2000-03-01T25:00", "2000-03-01x", "01.03.2000", "2000-0301"})
    EXPECT_FALSE(date_from_iso(text)) << text;
}

TEST(RecordingDate, IsFoundInNames) {
  const auto in_name = [](const char* name) {
    const auto date = date_in_name(name);
    return date ? iso_in_words(*date) : std::string();
  };
  EXPECT_EQ(in_name("ball_2026-03-10_1030.wav"), "2026-03-10T10:30:00");
  EXPECT_EQ(in_name("2026-03-10/drop 3.wav"), "2026-03-10T12:00:00");
  EXPECT_EQ(in_name("rec20260310T103015.flac"), "2026-03-10T10:30:15");
  EXPECT_EQ(in_name("20260310103015.wav"), "2026-03-10T10:30:15");
  EXPECT_EQ(in_name("Recording 2026-03-10 at 2"), "2026-03-10T12:00:00");
  EXPECT_EQ(in_name("2026_03_10-10.30.15.wav"), "2026-03-10T10:30:15");
  EXPECT_EQ(in_name("2026-03-10_99.wav"), "2026-03-10T12:00:00");
  for (const char* name : {"drop.wav", "20261399.wav", "1234567890.wav", "120260310.wav", "2150-01-01.wav"})
    EXPECT_EQ(in_name(name), "") << name;
}

}  // namespace
}  // namespace bouncelab::fit
