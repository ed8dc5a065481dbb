// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <sstream>

#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

using Analyze = ProgramTest;

TEST_F(Analyze, ARecordingGivesEveryFileOfTheInterfaceAsTheStagesByHandDo) {
  write("drop.wav", float_wav(bouncing(20), 44100));
  const Result result = run("analyze drop.wav --out out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const std::string name :
       {"onsets.csv", "samples.csv", "fit.json", "histograms.csv", "summary.json", "wave.json", "report.html"}) {
    EXPECT_TRUE(exists("out/" + name)) << name;
    EXPECT_TRUE(exists("out/" + name + ".meta.json")) << name;
  }
  const Json summary = json("out/summary.json"), answer = json("out/fit.json")["answer"];
  EXPECT_EQ(summary["n_onsets"], 20);
  // intervals shrink by exactly 0.9; timing errors of a few microseconds on intervals above 40 ms are 1e-4 of eps
  EXPECT_NEAR(summary["eps_median"].number(), 0.9, 1e-3);
  EXPECT_NEAR(answer["at"]["eps"].number(), 0.9, 1e-3);
  EXPECT_NEAR(answer["at"]["energy_lost"].number(), 0.19, 2e-3);
  EXPECT_EQ(answer["elsewhere"].size(), 0U) << "the same ε at every speed: " << answer["elsewhere"];
  EXPECT_EQ(answer["seen"]["n_impacts"], 20);
  EXPECT_THAT(result.out, testing::StartsWith("ε = 0."));
  EXPECT_THAT(result.out, testing::HasSubstr(" % of the energy of its motion up and down is lost in each bounce"));
  const Json input = json("out/onsets.csv.meta.json")["inputs"][0];
  EXPECT_EQ(input["path"], "drop.wav");
  EXPECT_EQ(input["sha256"].text().size(), 64u);
  const Json& drop = summary["recordings"][0]["drops"][0];
  EXPECT_EQ(drop["n_impacts"], 20);
  EXPECT_NEAR(drop["begin_s"].number(), 0.25, 1e-3);
  EXPECT_EQ(drop["odds"], 1e6);  // twenty impacts, nothing else: the most that is stated
  EXPECT_NEAR(drop["probability"].number(), 1.0 - 1e-6, 1e-9);
  EXPECT_EQ(drop["doubtful"], false);

  // the sound is kept for the report, which needs no network
  const Json sound = json("out/wave.json")["sound"];
  const std::string wav = sound["wav_base64"].text(), html = content("out/report.html");
  EXPECT_EQ(wav.substr(0, 5), "UklGR");  // "RIFF" and the first bits of its length
  EXPECT_EQ(wav.substr(32, 4), "IlYA");  // bytes 24 to 26: 22 56 00, half of 44,100 Hz
  // 44 bytes of head and two a sample at 22,050 Hz, three bytes in four characters
  const auto n_samples = static_cast<std::size_t>(std::lround(22050.0 * sound["duration_s"].number()));
  EXPECT_EQ(wav.size(), (44 + 2 * n_samples + 2) / 3 * 4);
  EXPECT_THAT(html, testing::HasSubstr("\"wav_base64\":\"UklGR"));
  EXPECT_EQ(html.find("<script src"), std::string::npos);
  EXPECT_EQ(html.find("<link"), std::string::npos);
  EXPECT_NE(html.find("Plotly"), std::string::npos);

  ASSERT_EQ(run("detect drop.wav --out o.csv").exit_code, 0);
  ASSERT_EQ(run("restitution o.csv --out s.csv").exit_code, 0);
  ASSERT_EQ(run("fit s.csv --out f.json").exit_code, 0);
  EXPECT_EQ(content("o.csv"), content("out/onsets.csv"));
  EXPECT_EQ(content("s.csv"), content("out/samples.csv"));
  EXPECT_EQ(content("f.json"), content("out/fit.json"));
  EXPECT_THAT(content("o.csv"),
              testing::StartsWith("recording,drop,impact,t_s,sigma_t_s,amplitude,snr_db,flags,probability\n"));
  EXPECT_EQ(content("o.csv").find(",nan"), std::string::npos);
  fs::rename(folder_ / "out", folder_ / "before");
  ASSERT_EQ(run("analyze drop.wav --out out").exit_code, 0);
  for (const std::string name : {"report.html", "summary.json"})
    EXPECT_TRUE(content("out/" + name) == content("before/" + name)) << name;
}

TEST_F(Analyze, AgainReplacesItsOwnReportOfTheSameRecordingAndNothingElse) {
  write("drop.wav", float_wav(bouncing(20), 44100));
  ASSERT_EQ(run("analyze drop.wav").exit_code, 0);
  EXPECT_EQ(run("analyze drop.wav --ball marble --diagnostics").exit_code, 0);
  EXPECT_EQ(run("analyze drop.wav").exit_code, 0);
  const fs::path report = folder_ / "drop-bouncelab" / "report.html";
  const auto is_refused = [&] {
    expect_one_line_error(run("analyze drop.wav"), 3, {"drop-bouncelab/onsets.csv", "exists already", "--force"});
  };
  // whatever somebody has changed is theirs
  for (const char* name : {"onsets.csv", "samples.csv", "fit.json", "wave.json", "summary.json", "report.html"}) {
    const std::string file = std::string("drop-bouncelab/") + name, ours = content_of(folder_ / file);
    write(file, ours + " ");
    is_refused();
    EXPECT_TRUE(content_of(folder_ / file) == ours + " ") << name;
    write(file, ours);
  }
  fs::rename(folder_ / "drop-bouncelab/report.html.meta.json", folder_ / "kept.json");
  is_refused();
  fs::rename(folder_ / "kept.json", folder_ / "drop-bouncelab/report.html.meta.json");
  EXPECT_EQ(run("analyze drop.wav").exit_code, 0);
  const std::string of_drop = content_of(report);
  // another recording of the same name, and another set of recordings
  write("drop.wav", float_wav(bouncing(19), 44100));
  is_refused();
  EXPECT_TRUE(content_of(report) == of_drop);
  write("drop.wav", float_wav(bouncing(20), 44100));
  write("more.wav", float_wav(bouncing(18), 44100));
  EXPECT_LE(run("analyze drop.wav more.wav").exit_code, 1);  // elsewhere
  EXPECT_TRUE(exists("drop-and-1-more-bouncelab/report.html"));
  EXPECT_TRUE(content_of(report) == of_drop);
}

TEST_F(Analyze, OfThreeImpactsFromAKnownHeightHasTheReboundOfTheRules) {
  write("drop.wav", float_wav(bouncing(3, 0.735, 1.05), 44100));
  const auto odds = [&](const std::string& options) {
    const Result found = run("detect drop.wav --json --force --out o.csv " + options);
    EXPECT_EQ(found.exit_code, 0) << found.err;
    return Json(found.out)["recordings"][0]["drops"][0]["odds"].number();
  };
  EXPECT_LT(odds(""), 10.0);
  EXPECT_GT(odds("--drop-height 2.54"), 20.0);
  const std::string analyze = "analyze drop.wav --out out --force --ball tennis --plate concrete ";
  EXPECT_EQ(run(analyze).exit_code, 1);  // it is doubtful whether a ball bounced
  const Result result = run(analyze + "--drop-height 2.54");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("\nDropped from 254 cm this ball rebounds to 13"));
  EXPECT_THAT(content("out/report.html"), testing::HasSubstr("the rule (ITF) asks for 135 to 147 cm on concrete"));
  const Json exact = json("out/fit.json")["curve"]["rebound"];
  EXPECT_EQ(exact["rule"]["most_m"], 1.47);
  // the interval of 1.05 s says how high it rose, less what the contact takes: 4 ms, of which 15 % are not known
  EXPECT_NEAR(exact["rebound_m"].number(), 9.81 * 1.046 * 1.046 / 8.0, 0.01);
  ASSERT_EQ(run(analyze + "--drop-height 2.54 --sigma-height 0.1").exit_code, 0);
  const auto width = [](const Json& rebound) { return rebound["ci95"][1].number() - rebound["ci95"][0].number(); };
  EXPECT_GT(width(json("out/fit.json")["curve"]["rebound"]), 1.2 * width(exact));
}

TEST_F(Analyze, SaysTheAnswerThenOneDoubtAtMostThenWhereTheReportIs) {
  write("drop.wav", float_wav(bouncing(12, 0.85, 0.6), 44100));
  const auto lines_of = [](const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  };
  const Result wrong = run("analyze drop.wav --drop-height 61.1 --ball marble");
  EXPECT_EQ(wrong.err, "");
  const std::vector<std::string> lines = lines_of(wrong.out);
  ASSERT_EQ(lines.size(), 8u) << wrong.out;  // value, its change, energy, drops, what was taken, doubt of two, report
  EXPECT_THAT(lines[0], testing::StartsWith("ε = 0.8"));
  EXPECT_EQ(lines[4], "Taken: plate not known, gravity 9.81 m/s^2, air 1.2 kg/m^3, rate 44100 Hz.");
  EXPECT_THAT(lines[5], testing::StartsWith("The drop height of 61.1 m (--drop-height) does not fit"));
  EXPECT_THAT(lines[7], testing::AllOf(testing::StartsWith("Report: "), testing::EndsWith("report.html")));
  // one number for one thing
  std::size_t n_eps = 0;
  for (std::size_t at = 0; (at = wrong.out.find("ε = ", at)) != std::string::npos; ++at) ++n_eps;
  EXPECT_EQ(n_eps, 1u) << wrong.out;
  // what else there is to say is kept
  EXPECT_THAT(content("drop-bouncelab/summary.json"), testing::HasSubstr("61.1 m (--drop-height) does not fit"));
}

TEST_F(Analyze, DiagnosticsShowEachDropFromTheInside) {
  write("drop.wav", float_wav(bouncing(20), 44100));
  ASSERT_EQ(run("analyze drop.wav --out out --diagnostics").exit_code, 0);
  const Json recording = json("out/diagnostics.json")["recordings"][0];
  EXPECT_GT(recording["wave"]["mean"].size(), 10u);
  EXPECT_EQ(recording["wave"]["mean"].size(), recording["wave"]["spread"].size());
  EXPECT_GT(recording["noise"]["psd"].size(), 10u);
  ASSERT_EQ(recording["drops"].size(), 1u);
  const Json& drop = recording["drops"][0];
  EXPECT_EQ(drop["marks"].size(), 20u);
  EXPECT_EQ(drop["excerpts"].size(), 4u);
  const Json& intervals = drop["intervals"];
  ASSERT_EQ(intervals["found_s"].size(), 18u);  // 20 impacts: 18 with an interval before and after
  // the sound's intervals shrink by 0.9 exactly, so that is what the fitted law expects of the next one
  for (std::size_t k = 0; k < 18; ++k)
    EXPECT_NEAR(intervals["found_s"][k].number(), intervals["expected_s"][k].number(),
                1e-3 * intervals["found_s"][k].number());
  const std::string report = content("out/report.html");
  EXPECT_EQ(report.find("\"diagnostics\":null"), std::string::npos);

  // run again without: details of the earlier run are not taken for those of this run
  ASSERT_EQ(run("analyze drop.wav --out out --force").exit_code, 0);
  EXPECT_FALSE(exists("out/diagnostics.json"));
  EXPECT_NE(content("out/report.html").find("\"diagnostics\":null"), std::string::npos);
}

TEST_F(Analyze, OneBrokenFileOfManyLosesNothing) {
  write("a.wav", float_wav(bouncing(20), 44100));
  write("b.wav", float_wav(bouncing(20), 44100).substr(0, 30));
  write("c.wav", float_wav(bouncing(20, 0.85), 44100));
  const Result result = run("analyze a.wav b.wav c.wav missing.wav --out out --diagnostics");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, testing::HasSubstr("b.wav: not readable as audio"));
  EXPECT_THAT(result.err, testing::HasSubstr("the results are those of the 2 recordings that could be read"));
  const Json summary = json("out/summary.json");
  EXPECT_EQ(summary["n_onsets"], 40);
  EXPECT_EQ(summary["recordings"][1]["status"], "unreadable");
  EXPECT_TRUE(exists("out/report.html"));

  EXPECT_THAT(run("detect a.wav c.wav --channel 1 --out none.csv").err, testing::HasSubstr("a.wav: has no channel 1"));
  EXPECT_EQ(run("detect b.wav missing.wav --out none.csv").exit_code, 3);
  EXPECT_FALSE(exists("none.csv"));
}

TEST_F(Analyze, ThreeImpactsAreADropThatIsKeptWithAWarningUnlessMoreAreAskedFor) {
  write("three.wav", float_wav(bouncing(3, 0.75, 0.5), 44100));
  write("drop.wav", float_wav(bouncing(20), 44100));
  const Result result = run("analyze three.wav drop.wav --out out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("\n1 of 2 drops is doubtful (a bouncing ball is less than 10 times as "
                                             "likely as another sound):"));
  const Json summary = json("out/summary.json");
  EXPECT_EQ(summary["n_drops"], 2);
  EXPECT_EQ(summary["n_onsets"], 23);
  const Json& drop = summary["recordings"][0]["drops"][0];
  EXPECT_EQ(drop["n_impacts"], 3);
  EXPECT_EQ(drop["doubtful"], true);
  EXPECT_LT(drop["odds"].number(), 10.0);
  EXPECT_THAT(content("out/samples.csv"), testing::HasSubstr("\nthree.wav,0,1,"));
  EXPECT_THAT(content("out/report.html"),
              testing::AllOf(testing::HasSubstr("1 of 2 drops is doubtful"), testing::HasSubstr("\"doubtful\":true")));
  const Result four = run("analyze three.wav drop.wav --out four --min-impacts 4");
  EXPECT_EQ(four.exit_code, 0) << four.err;
  EXPECT_EQ(four.err.find("is doubtful"), std::string::npos) << four.err;
  EXPECT_EQ(json("four/summary.json")["n_onsets"], 20);
  EXPECT_EQ(json("four/summary.json")["recordings"][0]["status"], "too_few_impacts");
  expect_one_line_error(run("detect three.wav --out o.csv --min-impacts 4"), 1,
                        {"three.wav", "1 drop has fewer than 4 impacts and is left out (--min-impacts"});
}

TEST_F(Analyze, WhereNoDropIsTenTimesAsLikelyABallThereIsAReportAndNoAnswer) {
  write("three.wav", float_wav(bouncing(3, 0.75, 0.5), 44100));
  const Result result = run("analyze three.wav --out out");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, testing::StartsWith("No ε is stated: a bouncing ball is only "));
  EXPECT_THAT(result.err, testing::HasSubstr("bouncelab: no ε is stated"));
  const Json summary = json("out/summary.json");
  EXPECT_EQ(summary["n_samples"], 1);
  EXPECT_TRUE(summary["answer"]["at"].is_null());
  EXPECT_NEAR(summary["eps_median"].number(), 0.75, 1e-3);
  EXPECT_THAT(content("out/report.html"), testing::HasSubstr("times as likely as another sound"));
}

}  // namespace
}  // namespace bouncelab::cli_test
