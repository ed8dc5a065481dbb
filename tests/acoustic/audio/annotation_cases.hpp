// SPDX-License-Identifier: GPL-3.0-or-later
/// What tests of annotations share: onsets with all that they can have, and what a refusal says.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"

namespace bouncelab::audio {

/// Two drops with all that an onset can have, and numbers that need every digit.
inline Onsets some_onsets() {
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

inline void expect_same(const Onsets& a, const Onsets& b) {
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

/// The message of the Error that a call ends with; empty where it ends well.
template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace bouncelab::audio
