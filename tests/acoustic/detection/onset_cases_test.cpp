// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings with exact truth from an independent generator, in the folder BOUNCELAB_ONSET_CASES, and a real one, in
// BOUNCELAB_RECORDINGS. Skipped, saying so, where there is none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bouncelab/core/table.hpp"
#include "bouncelab/detection/detect.hpp"

namespace bouncelab::detection {
namespace {

struct Case {
  std::string name;
  OnsetScore score;
  double rms_after_contact_law_s = 0.0;  // about a + b v^(-1/5)
  double bound_s = 0.0;                  // rms of the Cramer-Rao bounds
};

/// Least squares of the errors on 1 and v^(-1/5); returns the rms residual.
double rms_about_contact_law(const std::vector<double>& error_s, const std::vector<double>& v_mps) {
  const auto n = static_cast<double>(error_s.size());
  double u = 0, uu = 0, e = 0, ue = 0;
  for (std::size_t k = 0; k < error_s.size(); ++k) {
    const double x = std::pow(v_mps[k], -0.2);
    u += x / n, uu += x * x / n, e += error_s[k] / n, ue += x * error_s[k] / n;
  }
  const double b = (ue - u * e) / (uu - u * u);
  double sum = 0;
  for (std::size_t k = 0; k < error_s.size(); ++k) {
    const double r = error_s[k] - e - b * (std::pow(v_mps[k], -0.2) - u);
    sum += r * r / n;
  }
  return std::sqrt(sum);
}

Case run(const std::filesystem::path& truth_file) {
  const auto json = nlohmann::json::parse(std::ifstream(truth_file));
  const std::filesystem::path sound = truth_file.parent_path() / (truth_file.stem().string() + ".wav");
  Onsets truth;
  Case c{truth_file.stem().string(), {}, 0.0, 0.0};
  for (const auto& impact : json["impacts"]) {
    Onset onset;
    onset.recording = sound.string();
    onset.t_s = impact["t_s"];
    onset.drop = impact["drop"];
    onset.impact = truth.empty() || truth.back().drop != onset.drop ? 0 : truth.back().impact + 1;
    truth.push_back(onset);
    c.bound_s += std::pow(impact["crb_us"].get<double>() * 1e-6, 2) / static_cast<double>(json["impacts"].size());
  }
  c.bound_s = std::sqrt(c.bound_s);
  const Detection d = detect(sound);
  c.score = score_onsets(truth, d.onsets);
  std::vector<double> error_s, v_mps;
  for (std::size_t k = 0; k < truth.size(); ++k)
    if (c.score.match[k]) {
      error_s.push_back(d.onsets[*c.score.match[k]].t_s - truth[k].t_s);
      v_mps.push_back(json["impacts"][k]["v"]);
    }
  c.rms_after_contact_law_s = rms_about_contact_law(error_s, v_mps);
  return c;
}

TEST(OnsetCases, AreFoundCompletelyAndTimedNearTheBound) {
  const char* folder = std::getenv("BOUNCELAB_ONSET_CASES");
  if (folder == nullptr) GTEST_SKIP() << "BOUNCELAB_ONSET_CASES is not set";
  std::vector<double> rms_s, ratios;
  std::size_t n_honest = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const Case c = run(entry.path());
    const auto recall = static_cast<double>(c.score.n_found) / static_cast<double>(c.score.n_true);
    const auto precision =
        static_cast<double>(c.score.n_found) / static_cast<double>(c.score.n_found + c.score.n_invented);
    const double ratio = c.rms_after_contact_law_s / c.bound_s;
    std::printf(
        "%-24s recall %.3f precision %.3f rms %.3f us, after the contact law %.3f us = %.2f bounds, pull %.2f\n",
        c.name.c_str(), recall, precision, c.score.rms_s.value_or(NAN) * 1e6, c.rms_after_contact_law_s * 1e6, ratio,
        c.score.pull_sd.value_or(NAN));
    const bool chatter = c.name.find("chatter") != std::string::npos;
    EXPECT_GE(recall, chatter ? 0.97 : 0.99) << c.name;
    EXPECT_GE(precision, 0.99) << c.name;
    // 90 pulls know their rms to 7 %, and a case's sigma rests on one drop: one in nine may be outside
    n_honest += *c.score.pull_sd > 0.8 && *c.score.pull_sd < 1.25 ? 1 : 0;
    rms_s.push_back(*c.score.rms_s);
    ratios.push_back(ratio);
  }
  ASSERT_FALSE(rms_s.empty()) << folder << " holds no truth file";
  std::sort(rms_s.begin(), rms_s.end());
  std::sort(ratios.begin(), ratios.end());
  EXPECT_LT(rms_s[rms_s.size() / 2], 3e-6);  // the contact law alone moves the times by 2 us rms
  EXPECT_LT(ratios[ratios.size() / 2], 1.5);
  EXPECT_GE(n_honest + 1, ratios.size());
}

TEST(PingPongBall, IsFollowedThroughItsEchoes) {
  const char* folder = std::getenv("BOUNCELAB_RECORDINGS");
  if (folder == nullptr) GTEST_SKIP() << "BOUNCELAB_RECORDINGS is not set";
  const std::filesystem::path sound = std::filesystem::path(folder) / "eeps_pingpong.wav";
  Onsets truth =
      onsets_from_table(read_csv(std::filesystem::path(folder) / "eeps_pingpong.truth.csv", onset_columns()), "truth");
  for (Onset& onset : truth) onset.recording = sound.string();
  const Detection d = detect(sound);
  const OnsetScore s = score_onsets(truth, d.onsets, 2e-3);
  EXPECT_EQ(s.n_found, 50U);
  const auto before_last =
      std::count_if(d.onsets.begin(), d.onsets.end(), [&](const Onset& o) { return o.t_s < truth.back().t_s + 2e-3; });
  EXPECT_EQ(static_cast<std::size_t>(before_last), s.n_found) << "invented before the last one";
  EXPECT_NEAR(d.summary.restitution_median.value(), 0.946, 0.004);
}

}  // namespace
}  // namespace bouncelab::detection
