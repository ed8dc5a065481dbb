// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Json = nlohmann::json;
using Loop = ProgramTest;

TEST_F(Loop, WhatWentInComesOutWithinTheErrorsStated) {
  const Result result = run("loop --drops 6 --asperities 100000 --out out --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = Json::parse(content_of(folder_ / "out" / "summary.json"));
  EXPECT_EQ(Json::parse(result.out), summary);
  const int n_impacts = summary["n_impacts"];
  EXPECT_GE(n_impacts, 6 * 90);  // the paper: 90 to 100 bounces a drop
  EXPECT_GE(summary["n_found"].get<int>(), 0.99 * n_impacts);
  EXPECT_LE(summary["n_invented"].get<int>(), 0.01 * n_impacts);
  for (const Json& node : summary["eps_nodes"]) {
    const Json& found = node["from_sound"];
    // 4 standard errors: three nodes, one fixed seed
    EXPECT_NEAR(found["eps"].get<double>(), node["truth"].get<double>(), 4 * found["se"].get<double>()) << node;
  }
  // the closed form beside it: of the impacts simulated, whether or not they were found
  const Json& theory = summary["theory"];
  EXPECT_EQ(theory["n_transforms"], n_impacts);
  int n_counted = 0;
  for (const Json& n : theory["transform_counts"]) n_counted += n.get<int>();
  EXPECT_EQ(n_counted, n_impacts);
  // uniform radii of width 1e-3: s2 = (1/2) sqrt(pi w/N), stated to three digits
  EXPECT_NEAR(theory["offset_variance"].get<double>(), 0.5 * std::sqrt(3.14159 * 1e-3 / 1e5), 1e-7);
  EXPECT_THAT(content_of(folder_ / "out" / "report.html"), testing::HasSubstr("\"transform_counts\":["));
  for (const Json& density : theory["densities"]) {
    EXPECT_EQ(density["eps"].size(), density["density"].size());
    int n_in_bins = 0;
    for (const Json& n : density["simulated_counts"]) n_in_bins += n.get<int>();
    EXPECT_LE(n_in_bins, density["n_simulated"].get<int>());
  }
  // the reservoir through files, where the table of impacts has no states
  EXPECT_EQ(content_of(folder_ / "out" / "impacts.csv").find("wx_radps"), std::string::npos);
  const Json& reservoir = summary["reservoir"];
  EXPECT_EQ(reservoir["law"], "independent");
  EXPECT_EQ(reservoir["n_drops"], 6);
  EXPECT_EQ(reservoir["drops"]["sound_m2ps2"].size(), 6u);
  // the drops' own errors and terms of second order are below 1 % of w; the law shifts all drops alike
  EXPECT_GT(reservoir["correlation"].get<double>(), 0.99);
  EXPECT_LT(reservoir["rms_difference_m2ps2"].get<double>(), 4 * reservoir["expected_law_m2ps2"].get<double>());
  EXPECT_NEAR(reservoir["spin_share"].get<double>(), 2.0 / 7.0, 0.01);  // rolling, to first order in offsets of 1e-2
  EXPECT_THAT(content_of(folder_ / "out" / "report.html"), testing::HasSubstr("\"sound_m2ps2\":["));
  for (const char* name : {"impacts.csv", "truth.csv", "onsets.csv", "samples.csv", "fit.json", "histograms.csv",
                           "wave.json", "report.html"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;
}

/// Without the times of the stages.
std::string without_seconds(std::string text) {
  const std::string key = "\"seconds\":";
  for (std::size_t at = 0; (at = text.find(key, at)) != std::string::npos;) text.erase(at, text.find('}', at) - at);
  return text;
}

/// Every file of a folder but the provenance, which holds the command line.
std::map<std::string, std::string> outputs(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(".meta.json")) continue;
    const bool timed = name == "summary.json" || name == "report.html";
    all[name] = timed ? without_seconds(content_of(entry.path())) : content_of(entry.path());
  }
  return all;
}

void expect_same_outputs(const fs::path& one, const fs::path& other, std::size_t n_files) {
  const auto a = outputs(one), b = outputs(other);
  EXPECT_EQ(a.size(), n_files);
  EXPECT_EQ(b.size(), n_files);
  for (const auto& [name, text] : a) EXPECT_TRUE(b.count(name) == 1 && b.at(name) == text) << name;
}

TEST_F(Loop, ResultsDoNotDependOnTheNumberOfThreads) {
  // the same folder each time, since tables and report name their files
  for (const std::string threads : {"1", "3"}) {
    ASSERT_EQ(run("loop --drops 3 --asperities 20000 --impacts 40 --threads " + threads + " --out loop").exit_code, 0);
    ASSERT_EQ(run("analyze loop/recording.wav --diagnostics --threads " + threads + " --out analysis").exit_code, 0);
    fs::rename(folder_ / "analysis", folder_ / ("analysis" + threads));
    fs::rename(folder_ / "loop", folder_ / ("loop" + threads));
  }
  expect_same_outputs(folder_ / "loop1", folder_ / "loop3", 12);
  expect_same_outputs(folder_ / "analysis1", folder_ / "analysis3", 8);
}

}  // namespace
}  // namespace bouncelab::cli_test
