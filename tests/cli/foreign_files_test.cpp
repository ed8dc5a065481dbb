// SPDX-License-Identifier: GPL-3.0-or-later
// What people have: times and marks of any program, recordings with gaps, several tracks or files joined, and sounds in
// which no ball is found.
#include <algorithm>
#include <cmath>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/table.hpp"
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kEps = 0.85;

/// Impact times of n bounces [s], a line each.
std::string times(int n = 12, double factor = 1.0) {
  std::string lines;
  double t_s = 0.4, flight_s = 0.6;
  for (int k = 0; k < n; ++k, t_s += flight_s, flight_s *= kEps) lines += std::to_string(factor * t_s) + "\n";
  return lines;
}

class ForeignFiles : public ProgramTest {
 protected:
  /// What the program says while it makes coefficients of a file, which are to be those of a ball.
  std::string said_of(const std::string& arguments) const {
    const Result result = run("restitution " + arguments + " --out s.csv --force");
    EXPECT_EQ(result.exit_code, 0) << arguments << ": " << result.err;
    for (const RestitutionSample& s : samples_from_table(read_csv(folder_ / "s.csv", sample_columns()), "s.csv"))
      EXPECT_NEAR(s.eps, kEps, 1e-3) << arguments;
    return result.out;
  }
};

TEST_F(ForeignFiles, OfTimesGiveTheAnswerAsARecordingDoes) {
  fs::create_directory(folder_ / "t");
  write("t/times.csv", "Time (s)\n" + times());
  const Result result = run("t/times.csv --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json answer = Json(result.out)["answer"];
  EXPECT_NEAR(answer["at"]["eps"].number(), kEps, 4e-6);  // six digits of the times: 1e-6 of eps
  EXPECT_THAT(answer["sentences"][0].text(), HasSubstr("ε = 0.8"));
  EXPECT_THAT(answer["sentences"][0].text(), HasSubstr(", of this drop; no change with the speed is seen between "));
  EXPECT_EQ(answer["seen"]["n_impacts"], 12);
  const fs::path folder = folder_ / "t/times-bouncelab";
  for (const char* name : {"onsets.csv", "samples.csv", "fit.json", "summary.json", "report.html"})
    EXPECT_TRUE(fs::exists(folder / name)) << name;
  EXPECT_FALSE(fs::exists(folder / "wave.json"));
  EXPECT_THAT(run("t/times.csv --force").out,
              HasSubstr("t/times.csv: times in s (column 'Time (s)'): 12 impacts in 1 drop"));
  write("a.wav", float_wav(bouncing(12), 44100));
  expect_one_line_error(run("analyze a.wav t/times.csv --out o"), 2, {"times.csv", "one kind at a time"});
}

TEST_F(ForeignFiles, OfWhichNoBallIsAreDoubtedByRestitutionToo) {
  write("t.csv", "Time (s)\n0.4\n1\n1.7\n2.5\n3.4\n");
  const Result result = run("restitution t.csv --out s.csv");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("3 of 3 samples have ε below 0 or above 1; check"));
}

TEST_F(ForeignFiles, GapsOfAContainersTimeStampsAreKept) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed: tools/setup --checks";
  write("a.wav", float_wav(bouncing(12, kEps, 0.6), 44100));
  // six packets are lost, none of them with an impact
  const Result made = shell(
      "ffmpeg -nostdin -v error -i a.wav -c:a aac -b:a 192k a.m4a && for f in b.mp4 b.mkv; do ffmpeg -nostdin -v error "
      "-i a.m4a -c copy -bsf:a 'noise=drop=eq(n\\,24)+eq(n\\,50)+eq(n\\,68)+eq(n\\,87)+eq(n\\,101)+eq(n\\,113)' $f; "
      "done");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  for (const char* name : {"b.mp4", "b.mkv"}) {
    const Result result = run(std::string("analyze ") + name + " --out o --force --json");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const Json found = Json(result.out)["recordings"][0];
    EXPECT_EQ(found["n_onsets"], 12) << name;
    EXPECT_EQ(found["n_gaps"], 6) << name;
    EXPECT_NEAR(found["eps_median"].number(), kEps, 1e-3) << name;
    EXPECT_THAT(result.out, AllOf(HasSubstr("have 6 gaps"), HasSubstr("6 gaps between impacts")));
  }
}

TEST_F(ForeignFiles, OfSeveralTracksThatWithTheBallIsTaken) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed: tools/setup --checks";
  write("a.wav", float_wav(bouncing(12, kEps, 0.6), 44100));
  const Result made = shell(
      "ffmpeg -nostdin -v error -f lavfi -i anullsrc=r=44100:cl=mono:d=4 -i a.wav -map 0:a -map 1:a -c:a pcm_s16le "
      "a.mov");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Result result = run("detect a.mov --out o.csv --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json found = Json(result.out)["recordings"][0];
  EXPECT_EQ(found["track"], 1);
  EXPECT_EQ(found["n_onsets"], 12);
  EXPECT_THAT(result.err, HasSubstr("audio track 1 of 2"));
  expect_one_line_error(run("detect a.mov --track 0 --out p.csv"), 1, {"a.mov"});
  expect_one_line_error(run("detect a.mov --track 2 --out p.csv"), 2, {"track 2", "tracks 0 to 1"});
}

TEST_F(ForeignFiles, WhatFollowsInJoinedFilesIsNamed) {
  const std::string one = float_wav(bouncing(12), 44100);
  write("two.wav", one + float_wav(bouncing(8), 44100));
  const Result result = run("detect two.wav --out o.csv");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("more sound follows at byte " + std::to_string(one.size())));
  write("data.wav", one + one.substr(36));  // a second chunk of samples
  EXPECT_THAT(run("detect data.wav --out o.csv --force").err, HasSubstr("more sound follows"));
  EXPECT_THAT(run("detect two.wav --out o.csv --force --quiet").err, testing::Not(HasSubstr("follows")));
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed: tools/setup --checks";
  write("one.wav", one);
  for (const char* type : {"flac", "ogg", "mp3", "m4a"}) {
    const std::string name = std::string("one.") + type, joined = std::string("two.") + type;
    if (shell("ffmpeg -nostdin -v error -i one.wav " + name).exit_code != 0) continue;  // without this encoder
    EXPECT_THAT(run("detect " + name + " --out o.csv --force").err, testing::Not(HasSubstr("follows")));
    shell("cat " + name + " " + name + " >" + joined);
    EXPECT_THAT(run("detect " + joined + " --out o.csv --force").err, HasSubstr("more sound follows at byte"));
  }
}

TEST_F(ForeignFiles, ATableMayComeThroughAPipe) {
  const auto utf16 = [](const std::string& ascii) {
    std::string text = "\xFF\xFE";
    for (const char c : ascii) text += {c, '\0'};
    return text;
  };
  const std::string german = "interval_ms;n\n600,5;1\n540,4;2\n486,3;3\n437,6;4\n393,9;5\n354,4;6\n";
  write("i.csv", german);
  write("i16.csv", utf16(german));
  ASSERT_EQ(run("convert i.csv --to own.csv").exit_code, 0);
  write("own16.csv", utf16(content("own.csv")));
  const auto first_line = [](const std::string& text) { return text.substr(0, text.find('\n')); };
  const std::string answer = first_line(run("analyze i.csv --out file").out);
  EXPECT_THAT(answer, HasSubstr("ε = 0.9"));
  const auto piped = [&](const std::string& command) {
    const Result result = shell("B=\"$B\" bash -c '" + command + " --force'");
    EXPECT_EQ(result.exit_code, 0) << command << ": " << result.err;
    return first_line(result.out);
  };
  for (const std::string name : {"i.csv", "i16.csv", "own.csv", "own16.csv"}) {
    EXPECT_EQ(piped("cat " + name + " | \"$B\" analyze - --out piped"), answer) << name;
    piped("cat " + name + " | \"$B\" convert - --to back.csv");
    EXPECT_THAT(content("back.csv"), HasSubstr("0.6005")) << name;
    piped("cat " + name + " | \"$B\" restitution - --out s.csv");
  }
  for (const std::string command : {"analyze <(cat i.csv)", "<(cat own16.csv)", "analyze /dev/stdin <own.csv"})
    EXPECT_EQ(piped("\"$B\" " + command + " --out piped"), answer) << command;
  ASSERT_EQ(run("restitution own.csv --out s.csv --force").exit_code, 0);
  write("s16.csv", utf16(content("s.csv")));
  write("e.csv", "v_mps;eps\n2,9;0,90\n2,6;0,90\n2,4;0,90\n2,1;0,91\n1,9;0,90\n");
  write("e16.csv", utf16(content("e.csv")));
  for (const std::string name : {"s.csv", "s16.csv", "e.csv", "e16.csv"}) {
    piped("cat " + name + " | \"$B\" fit - --out piped.json");
    EXPECT_EQ(run("fit " + name + " --out file.json --force").exit_code, 0);
    EXPECT_EQ(Json(content("piped.json"))["answer"].dump(), Json(content("file.json"))["answer"].dump()) << name;
  }
}

TEST_F(ForeignFiles, AWorkbookIsNamedAsSuch) {
  const std::string zip = "PK\x03\x04" + std::string(26, '\0');
  write("lab.xlsx", zip + "[Content_Types].xml" + std::string(1000, '\0'));
  write("lab.ods", zip + "mimetypeapplication/vnd.oasis.opendocument.spreadsheet");
  write("lab.numbers", zip + "Index/Document.iwa");
  write("lab.xls", "\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1" + std::string(1000, '\0'));
  write("lab.csv", zip + "xl/workbook.xml");
  for (const std::string name : {"lab.xlsx", "lab.ods", "lab.numbers", "lab.xls", "lab.csv"})
    for (const std::string command : {"", "analyze ", "compare --out c lab.ods ", "restitution --out s.csv ",
                                      "fit --out f.json ", "convert --to o.csv "})
      expect_one_line_error(run(command + name), 3, {": is a workbook: save the sheet as CSV"});
  write("run.zip", zip + "Raw Data.csv");
  expect_one_line_error(run("run.zip"), 3, {"run.zip: is a ZIP archive: unpack it"});
  expect_one_line_error(shell("cat lab.xlsx | \"$B\" fit - --out f.json"), 3, {"standard input: is a workbook"});
}

TEST_F(ForeignFiles, TheMedianIsOfTheSamplesWithoutFlags) {
  // .80 to .84, and then an impact that was not heard
  write("t.csv", "t_s\n0.4\n1\n1.48\n1.8688\n2.187616\n2.452233\n2.674512\n3.05\n");
  EXPECT_NEAR(Json(run("restitution t.csv --out s.csv --json").out)["eps_median"].number(), 0.82, 1e-9);  // rounding
  EXPECT_THAT(content("s.csv"), HasSubstr("missing_impact"));
}

TEST_F(ForeignFiles, AreTakenAsTheUserSays) {
  write("us.csv", "a;b\n" + std::regex_replace(times(12, 1e6), std::regex("(.+)\n"), "9;$1\n"));
  EXPECT_THAT(said_of("us.csv --columns t=b --unit us --as times"), HasSubstr("times in us"));
  expect_one_line_error(run("restitution us.csv --columns t=c --out t.csv"), 3, {"'c'", "column 'a'"});
  write("letters.csv", "x,y\n0.9,1.2\n0.9,1.0\n0.9,0.8\n0.9,0.6\n");
  const Result asked = run("fit letters.csv --out f.json");
  EXPECT_EQ(asked.exit_code, 2);
  EXPECT_THAT(asked.err, AllOf(HasSubstr("letters.csv"), HasSubstr("--columns v=COLUMN,eps=COLUMN"),
                               HasSubstr("  y  1.2  1.0  0.8 ...")));
  // of one digit each value is off by up to .05: .029 by the root of four
  EXPECT_THAT(run("fit letters.csv --columns v=y,eps=x --out f.json").out, HasSubstr(" ± 0.015 (95 %: 0.8"));
  for (const std::string command : {"fit", "compare", "roughness"})  // what the question says can be typed
    EXPECT_THAT(run(command + " --help-all").out, HasSubstr("--columns ")) << command;
  EXPECT_THAT(run("roughness letters.csv --columns v=y,eps=x").err, HasSubstr("60"));
  const auto tier = [](const std::string& name, const std::string& lines) {
    return "\"TextTier\" \"" + name + "\" 0 9 " + std::to_string(std::count(lines.begin(), lines.end(), '\n')) + "\n" +
           std::regex_replace(lines, std::regex("\n"), " \"x\"\n");
  };
  write("a.TextGrid",
        "\"ooTextFile\" \"TextGrid\" 0 9 <exists> 2\n" + tier("notes", "0.1\n2.0\n") + tier("bounces", times()));
  EXPECT_THAT(said_of("a.TextGrid"), AllOf(HasSubstr("tier 'bounces' of 2"), HasSubstr("'notes'")));
  EXPECT_THAT(run("restitution a.TextGrid --tier notes --out t.csv").err, HasSubstr("no three successive impacts"));
  expect_one_line_error(run("restitution a.TextGrid --tier other --out t.csv --force"), 3, {"'other'", "'bounces'"});
  const auto layer = [](const std::string& lines) {
    std::string points;
    std::istringstream in(lines);
    for (double t_s; in >> t_s;)
      points += "<point frame='" + std::to_string(std::lround(44100 * t_s)) + "' label='x'/>";
    return "<dataset>" + points + "</dataset>";
  };
  write("a.svl",
        "<sv><data><model sampleRate='44100' name='a.wav'/>" + layer("0.1 2.0") + layer(times()) + "</data></sv>");
  EXPECT_THAT(said_of("a.svl"), HasSubstr("layer 2 of 2"));
}

TEST_F(ForeignFiles, LabelsAreNumberedOnlyIfTheirNumbersAreOurs) {
  std::string bars;  // as beat trackers write them: no drops 1 to 3
  std::istringstream in(times());
  int k = 0;
  for (std::string t; in >> t; ++k)
    bars += t + "\t" + t + "\t" + std::to_string(1 + k / 4) + "." + std::to_string(1 + k % 4) + "\n";
  std::string taken_for;
  EXPECT_EQ(audio::onsets_of_file(bars, "bars.txt", {}, {}, taken_for).back().drop, 0);
  std::replace(bars.begin(), bars.end(), '.', ',');
  EXPECT_EQ(audio::onsets_of_file(bars, "comma.txt", {}, {}, taken_for).back().impact, 11);
}

/// The lines of a text.
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST_F(ForeignFiles, AQuestionIsAnsweredByACommandThatItPrints) {
  write("it's two.csv", "A (s);B (ms);note\n" + std::regex_replace(times(), std::regex("(.+)\n"), "$1;9;x\n"));
  write("fall.csv", "0.6\n0.51\n0.4335\n0.368475\n");
  write("columns.csv", "Zeit;Höhe\n" + std::regex_replace(times(), std::regex("(.+)\n"), "$1;0\n"));
  write("trial.csv",
        "trial,Time (s)\n" + std::regex_replace(times(6), std::regex("(.+)\n"), "1,$1\n") + "2,2.9\n2,3.1\n");
  write("speeds.csv", "v (cm/s);e\n120;0,85\n100;0,86\n90;0,85\n80;0,84\n");
  struct Asked {
    const char *command, *question, *cells;
    int n_readings;
  };
  for (const Asked& c :
       {Asked{"restitution \"it's two.csv\" --unit s --out s.csv --force", "2 columns are of a time",
              "    A (s)   0.400000  1.000000  1.510000 ...", 2},
        Asked{"fall.csv --out fall --force", "do not rise", "    1  0.6  0.51  0.4335 ...", 2},
        Asked{"analyze columns.csv --out columns --force --json", "no title has a unit", "    Höhe  0  0  0 ...", 1},
        Asked{"convert trial.csv --to own.csv --force", "'trial' changes", "    trial     1  1  1 ...", 2},
        Asked{"fit speeds.csv --out f.json --force", "which columns are", "    e         0,85  0,86  0,85 ...", 1}}) {
    SCOPED_TRACE(c.command);
    const Result result = run(c.command);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    const std::vector<std::string> said = lines_of(result.err);
    ASSERT_GT(said.size(), 2U) << result.err;
    EXPECT_THAT(said[0], AllOf(testing::StartsWith("bouncelab: "), HasSubstr(".csv: "), HasSubstr(c.question)));
    EXPECT_THAT(said, testing::Contains(c.cells));
    int n_readings = 0;
    for (const std::string& line : said) {
      const std::size_t command = line.find(": bouncelab ");
      if (command == std::string::npos || &line == &said[0]) continue;
      ++n_readings;
      EXPECT_THAT(line, testing::StartsWith("  "));
      if (line.find("B (ms)") != std::string::npos) continue;  // it holds no times
      const Result answered = shell("\"$B\" " + line.substr(command + std::string(": bouncelab ").size()));
      EXPECT_EQ(answered.exit_code, 0) << line << "\n" << answered.err;
    }
    EXPECT_EQ(n_readings, c.n_readings) << result.err;
  }
}

TEST_F(ForeignFiles, HeightsInARowAreAskedAndTheAnswerGivesTheCoefficient) {
  write("h.csv", "1, .81, .66, .53\n");
  const Result asked = run("analyze h.csv --out h");
  EXPECT_EQ(asked.exit_code, 2) << asked.err;
  std::string answer;
  for (const std::string& line : lines_of(asked.err))
    if (line.find("heights in m: bouncelab ") != std::string::npos)
      answer = line.substr(line.find(": bouncelab ") + 12);
  ASSERT_NE(answer, "") << asked.err;
  const Result answered = shell("\"$B\" " + answer);
  EXPECT_EQ(answered.exit_code, 0) << answered.err;
  EXPECT_THAT(answered.out + answered.err, HasSubstr("heights (a row, ',' between): 3 bounces in 1 drop"));
  const Json eps = Json(content("h/fit.json"))["answer"]["at"]["eps"];
  // (.53/1)^(1/6) = .8996; what air may have slowed it adds some thousandths
  EXPECT_NEAR(eps.number(), 0.905, 0.01);
}

TEST_F(ForeignFiles, SpeedsBeforeAndAfterAreAskedAndGoFromTheAnswerToTheReport) {
  const std::string rows = "-4.01;2.72\n-2.74;1.92\n-1.83;1.27\n-1.3;.88\n";
  write("v.csv", "before (m/s);after (m/s)\n" + rows);
  const Result asked = run("v.csv --out v");
  EXPECT_EQ(asked.exit_code, 2) << asked.err;
  const std::string remedy = "bouncelab v.csv --out v --columns 'v_in=before (m/s),v_out=after (m/s)'";
  EXPECT_THAT(asked.err, HasSubstr(remedy));
  const Result answered = shell("\"$B\" " + remedy.substr(10));
  EXPECT_EQ(answered.exit_code, 0) << answered.err;
  EXPECT_THAT(answered.out, AllOf(HasSubstr("ε = 0.6"), Not(HasSubstr("of this drop")), HasSubstr("report.html")));
  EXPECT_FALSE(fs::exists(folder_ / "v/onsets.csv"));
  const Json fit(content("v/fit.json"));
  // two digits behind the point, of numbers that scatter by a hundredth
  EXPECT_GT(fit["curve"]["errors_over_digits"].number(), 1.0);
  std::string findings;
  for (std::size_t k = 0; k < fit["answers"].size(); ++k) findings += fit["answers"][k]["answer"].text();
  EXPECT_THAT(findings, AllOf(HasSubstr("measuring the speeds"), Not(HasSubstr("timing"))));
  // a table of samples goes the same way
  const Result again = run("v/samples.csv --out again");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  const auto eps = [](const Json& of) { return of["answer"]["at"]["eps"].number(); };
  EXPECT_EQ(eps(Json(content("again/fit.json"))), eps(fit));
}

TEST_F(ForeignFiles, SpeedsWithoutAUnitAreAskedAndEveryCommandTakesTheAnswer) {
  write("v.csv", "vorher;nachher\n4,01;2,72\n2,74;1,92\n1,83;1,27\n1,3;0,88\n");
  const std::string answer = "--columns v_in=vorher,v_out=nachher";
  for (const std::string command :
       {"analyze v.csv --out v", "restitution v.csv --out s.csv", "fit v.csv --out f.json"}) {
    const Result asked = run(command);
    EXPECT_EQ(asked.exit_code, 2) << command;
    EXPECT_THAT(asked.err, HasSubstr("speeds before and after a bounce, in m/s: bouncelab " + command + " " + answer));
    const Result answered = run(command + " " + answer);
    EXPECT_EQ(answered.exit_code, 0) << command << answered.err;
    EXPECT_THAT(answered.out, HasSubstr("speeds in m/s")) << command;
  }
  EXPECT_THAT(run("restitution v.csv --out t.csv " + answer).out, HasSubstr("\n4 coefficients of restitution\n"));
  const auto samples = [&](const std::string& file) {
    return samples_from_table(read_csv(folder_ / file, sample_columns()), file);
  };
  const RestitutionSamples by_restitution = samples("s.csv"), by_analyze = samples("v/samples.csv");
  ASSERT_EQ(by_restitution.size(), 4U);
  ASSERT_EQ(by_analyze.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(by_restitution[k].eps, by_analyze[k].eps);
  // speeds have no times: convert neither takes nor proposes them
  EXPECT_THAT(run("convert v.csv --to o.csv").err, Not(HasSubstr("v_in")));
  expect_one_line_error(run("convert v.csv --to o.csv " + answer), 3, {"holds speeds", "no times"});
}

TEST_F(ForeignFiles, NumbersOfRowsBesideTimesAreNoLabels) {
  for (const char* table :
       {"1\t400\n2\t1000\n3\t1510\n", "1\t400\tx\n2\t1000\ty\n3\t1510\tz\n", "1\t400\t7\n2\t1000\t8\n3\t1510\t9\n"}) {
    write("t.txt", table);
    EXPECT_NE(run("restitution t.txt --out s.csv --force").exit_code, 0) << table;
  }
}

TEST_F(ForeignFiles, AQuestionIsInTheJsonOfTheFailure) {
  write("fall.csv", "0.6\n0.51\n0.4335\n0.368475\n");
  const Result result = run("analyze fall.csv --out o --json");
  EXPECT_EQ(result.exit_code, 2);
  const Json failure(result.out);
  EXPECT_EQ(failure["exit_code"], 2);
  EXPECT_THAT(failure["error"].text(),
              AllOf(HasSubstr("do not rise"), HasSubstr("--as intervals --unit s (intervals in s)")));
}

TEST_F(ForeignFiles, OfManyThatAreReadAlikeOneLineSaysHow) {
  std::string names;
  for (int k = 1; k <= 5; ++k) {
    const std::string name = "t" + std::to_string(k) + ".csv";
    write(name, "t (s)\n0.1\n0.7\n1.2\n1.6" + std::to_string(k) + "\n");
    names += name + " ";
  }
  write("ms.csv", "t (ms)\n100\n700\n1200\n1620\n");
  const Result result = run("restitution " + names + "ms.csv --out s.csv");
  EXPECT_THAT(result.out, testing::StartsWith("t1.csv, t2.csv, t3.csv and 2 more: times in s (column 't (s)')\n"
                                              "ms.csv: times in ms (column 't (ms)'): 4 impacts in 1 drop"));
}

TEST_F(ForeignFiles, WhatTheirDropsSayAgainstOneValueIsSaid) {
  const auto table = [](const std::vector<std::vector<double>>& drops) {
    std::string text = "drop,t_s\n";
    for (std::size_t drop = 0; drop < drops.size(); ++drop) {
      double t_s = static_cast<double>(drop), interval_s = drops.size() < 12 ? 0.6 : 0.3 + 0.01 * t_s;
      for (const double eps : drops[drop])
        text += std::to_string(drop) + "," + std::to_string(t_s) + "\n", t_s += interval_s, interval_s *= eps;
    }
    return text;
  };
  std::vector<std::vector<double>> drops(6, std::vector(12, 0.8));
  drops.resize(12, std::vector(12, 0.9));
  write("two.csv", table(drops));
  const Result two = run("analyze two.csv --out two");
  EXPECT_THAT(two.out, HasSubstr("two kinds: ε is about 0.80 in 6 of them and about 0.90 in 6"));
  EXPECT_THAT(two.out, Not(HasSubstr("ε = ")));  // no value would be that of a ball
  expect_one_line_error(run("dem two/fit.json --code lammps"), 3, {"two/fit.json", "--pool"});
  EXPECT_THAT(run("analyze two.csv --out pooled --pool").out, HasSubstr("ε = "));
  EXPECT_EQ(run("dem pooled/fit.json --code lammps").exit_code, 0);
  write("floors.csv", table(std::vector<std::vector<double>>(3, {0.5, 0.5, 0.5, 0.9, 0.91, 0.89, 0.9, 0.9, 0.9})));
  EXPECT_THAT(run("analyze floors.csv --out r").out, HasSubstr("of 21 bounces are left out"));
  drops.clear();
  for (const double x : {0.78, 0.8, 0.83, 0.81})
    drops.push_back({x, x + 0.002, x - 0.003, x + 0.001, x + 0.003, x - 0.002, x, x + 0.001});
  write("differ.csv", table(drops));
  EXPECT_THAT(run("analyze differ.csv --out d").out, HasSubstr("The 4 drops differ by more"));
}

TEST_F(ForeignFiles, SoundOfNoBallOrOfTwoIsDescribedAsItIs) {
  write("dead.wav", float_wav(bouncing(4, 0.15, 0.8), 44100));
  expect_one_line_error(
      run("detect dead.wav --out o.csv"), 1,
      {"4 sounds like impacts", "no three of them follow each other", "let it bounce until", "times.csv"});
  std::vector<float> both = bouncing(12, kEps, 0.6);
  const std::vector<float> other = bouncing(9, 0.75, 0.7);
  constexpr std::size_t kLater = 22050;  // half a second
  both.resize(std::max(both.size(), other.size() + kLater));
  for (std::size_t k = 0; k < other.size(); ++k) both[k + kLater] += 0.5F * other[k];
  write("two.wav", float_wav(both, 44100));
  EXPECT_THAT(run("detect two.wav --out o.csv").err, HasSubstr("2 balls bounce at the same time from 0."));
}

}  // namespace
}  // namespace bouncelab::cli_test
