// SPDX-License-Identifier: GPL-3.0-or-later
// What people have: times and marks of any program, recordings with gaps, several tracks or files joined, and sounds in
// which no ball is found.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/table.hpp"
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

using Json = nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kEps = 0.85;

/// Impact times of n bounces.
std::vector<double> times(int n = 12, double t_s = 0.4, double flight_s = 0.6) {
  std::vector<double> all_s;
  for (int k = 0; k < n; ++k, t_s += flight_s, flight_s *= kEps) all_s.push_back(t_s);
  return all_s;
}

std::string lines(const std::vector<double>& t_s, const std::string& behind = "\n", int digits = 6) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(digits);
  for (const double t : t_s) text << t << behind;
  return text.str();
}

class ForeignFiles : public ProgramTest {
 protected:
  /// The coefficients that restitution makes of a file.
  std::vector<double> eps_of(const std::string& arguments) {
    const Result result = run("restitution " + arguments + " --out s.csv --force");
    EXPECT_EQ(result.exit_code, 0) << arguments << ": " << result.err;
    out_ = result.out;
    std::istringstream table(content_of(folder_ / "s.csv"));
    std::vector<double> eps;
    std::string line;
    for (std::getline(table, line); std::getline(table, line);) {
      std::istringstream cells(line);
      std::string cell;
      for (int k = 0; k < 6; ++k) std::getline(cells, cell, ',');
      eps.push_back(std::stod(cell));
    }
    return eps;
  }

  void expect_one_drop(const std::string& arguments, std::size_t n = 10, double tolerance = 1e-4) {
    const std::vector<double> eps = eps_of(arguments);
    EXPECT_EQ(eps.size(), n) << arguments;
    for (const double e : eps) EXPECT_NEAR(e, kEps, tolerance) << arguments;
  }

  bool has_ffmpeg() const { return shell("command -v ffmpeg && command -v ffprobe").exit_code == 0; }

  std::string out_;
};

TEST_F(ForeignFiles, OfTimesGiveTheAnswerAsARecordingDoes) {
  write("times.csv", "Time (s)\n" + lines(times()));
  const Result result = run("times.csv --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json answer = Json::parse(result.out).at("answer");
  EXPECT_THAT(answer.at("sentences").at(0), HasSubstr("ε = 0.8500"));
  EXPECT_EQ(answer.at("seen").at("n_impacts"), 12);
  const fs::path folder = folder_ / "times-bouncelab";
  for (const char* name : {"onsets.csv", "samples.csv", "fit.json", "summary.json", "report.html"})
    EXPECT_TRUE(fs::exists(folder / name)) << name;
  EXPECT_FALSE(fs::exists(folder / "wave.json"));
  EXPECT_THAT(run("times.csv --force").out,
              HasSubstr("times.csv: times in s (column 'Time (s)'): 12 impacts in 1 drop"));
  write("a.wav", float_wav(bouncing(12), 44100));
  expect_one_line_error(run("analyze a.wav times.csv --out o"), 2, {"times.csv", "one kind at a time"});
  write("speeds.csv", "speed;e\n1,2;0,85\n1,0;0,85\n0,8;0,86\n");
  expect_one_line_error(run("speeds.csv"), 3, {"speeds.csv", "bouncelab fit"});
}

TEST_F(ForeignFiles, AreTakenAsTheUserSays) {
  write("x.txt", lines({0.6, 0.51, 0.4335}));
  expect_one_drop("x.txt", 2);
  EXPECT_THAT(out_, HasSubstr("they fall"));
  expect_one_drop("x.txt --as intervals", 2);
  EXPECT_THAT(run("restitution x.txt --as times --out t.csv").err, HasSubstr("no three successive impacts"));
  write("us.txt", lines({400000, 1000000, 1510000, 1943500}, "\n", 0));
  expect_one_line_error(run("restitution us.txt --out t.csv --force"), 3, {"us.txt", "--unit"});
  expect_one_drop("us.txt --unit us", 2);
  write("table.csv", "a;b\n9;0,4\n8;1,0\n7;1,51\n6;1,9435\n");
  expect_one_drop("table.csv --columns t=b", 2);
  expect_one_line_error(run("restitution table.csv --columns t=c --out t.csv --force"), 3, {"'c'", "column 'a'"});
}

TEST_F(ForeignFiles, LabelsAreReadInEveryEncodingAndNumberedOnlyIfTheirNumbersAreOurs) {
  std::string labels, bars, utf16 = "\xFF\xFE";
  int k = 0;
  for (const double t : times()) {
    const std::string time = lines({t}, "");
    labels += time + "\t" + time + "\thit\r\n";
    bars += time + "\t" + time + "\t" + std::to_string(1 + k / 4) + "." + std::to_string(1 + k % 4) + "\n";
    ++k;
  }
  for (const char c : labels) utf16 += {c, '\0'};
  std::string comma = labels;
  std::replace(comma.begin(), comma.end(), '.', ',');
  write("bom.txt", "\xEF\xBB\xBF" + labels);
  write("utf16.txt", utf16);
  write("comma.txt", comma);
  write("bars.txt", bars);  // as beat trackers write them: no drops 1 to 3
  for (const char* name : {"bom.txt", "utf16.txt", "comma.txt", "bars.txt"}) expect_one_drop(name);
}

TEST_F(ForeignFiles, OfSeveralTiersTheOneOfTheImpactsIsTaken) {
  const auto tier = [](const std::string& name, const std::vector<double>& t_s) {
    std::string text = "\"TextTier\" \"" + name + "\" 0 9 " + std::to_string(t_s.size()) + "\n";
    for (const double t : t_s) text += lines({t}, "") + " \"x\"\n";
    return text;
  };
  write("a.TextGrid",
        "\"ooTextFile\" \"TextGrid\" 0 9 <exists> 2\n" + tier("notes", {0.1, 2.0}) + tier("bounces", times()));
  expect_one_drop("a.TextGrid");
  EXPECT_THAT(out_, AllOf(HasSubstr("tier 'bounces' of 2"), HasSubstr("'notes'")));
  EXPECT_THAT(run("restitution a.TextGrid --tier notes --out t.csv").err, HasSubstr("no three successive impacts"));
  expect_one_line_error(run("restitution a.TextGrid --tier other --out t.csv --force"), 3, {"'other'", "'bounces'"});
  const auto layer = [](const std::vector<double>& t_s) {
    std::string text;
    for (const double t : t_s) text += "<point frame='" + std::to_string(std::lround(44100 * t)) + "' label='x'/>";
    return "<dataset>" + text + "</dataset>";
  };
  write("a.svl",
        "<sv><data><model sampleRate='44100' name='a.wav'/>" + layer({0.1, 2.0}) + layer(times()) + "</data></sv>");
  expect_one_drop("a.svl", 10, 1e-3);  // whole frames
  EXPECT_THAT(out_, HasSubstr("layer 2 of 2"));
}

TEST_F(ForeignFiles, OfSpeedsAndCoefficientsAreFitted) {
  write("video.csv",
        "Versuch;v (cm/s);COR\n1;120,5;0,850\n2;98,0;0,851\n3;75,1;0,849\n4;60,0;0,850\n5;40;0,85\n6;33;0,851\n");
  const Result result = run("fit video.csv --out f.json --json");
  EXPECT_THAT(Json::parse(result.out).at("answer").at("sentences").at(0), HasSubstr("ε = 0.850"));
  EXPECT_THAT(run("fit video.csv --out f.json --force").out, HasSubstr("speeds in cm/s (column 'v (cm/s)')"));
  write("letters.csv", "x,y\n0.9,1.2\n0.9,1.0\n0.9,0.8\n0.9,0.6\n");
  expect_one_line_error(run("fit letters.csv --out f.json --force"), 3,
                        {"letters.csv", "--columns v=COLUMN,eps=COLUMN"});
  EXPECT_THAT(run("fit letters.csv --columns v=y,eps=x --out f.json --force").out, HasSubstr("ε = 0.90 (95 %: 0.7"));
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
    const Json found = Json::parse(result.out).at("recordings").at(0);
    EXPECT_EQ(found.at("n_onsets"), 12) << name;
    EXPECT_EQ(found.at("n_gaps"), 6) << name;
    EXPECT_NEAR(found.at("eps_median").get<double>(), kEps, 1e-3) << name;
    EXPECT_THAT(result.out, AllOf(HasSubstr("have 6 gaps"), HasSubstr("6 gaps of the time stamps between impacts")));
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
  const Json found = Json::parse(result.out).at("recordings").at(0);
  EXPECT_EQ(found.at("track"), 1);
  EXPECT_EQ(found.at("n_onsets"), 12);
  EXPECT_THAT(result.err, HasSubstr("track 1 of 2 tracks of sound has the ball"));
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

TEST_F(ForeignFiles, SoundWithoutABallIsDescribedAsItIs) {
  write("dead.wav", float_wav(bouncing(4, 0.15, 0.8), 44100));
  expect_one_line_error(run("detect dead.wav --out o.csv"), 1,
                        {"4 sounds that rise like impacts, 0.8, 0.12 and 0.018 s apart",
                         "an ε below 0.2 is not looked for", "times.csv"});
  write("two.wav", float_wav(bouncing(2, kEps, 0.6), 44100));
  expect_one_line_error(run("detect two.wav --out o.csv"), 1,
                        {"2 sounds that rise like impacts, 0.6 s apart", "tell little"});
}

TEST_F(ForeignFiles, ASecondBallIsSaid) {
  std::vector<float> both = bouncing(12, kEps, 0.6);
  const std::vector<float> other = bouncing(9, 0.75, 0.7);
  constexpr std::size_t kLater = 22050;  // half a second
  both.resize(std::max(both.size(), other.size() + kLater));
  for (std::size_t k = 0; k < other.size(); ++k) both[k + kLater] += 0.5F * other[k];
  write("two.wav", float_wav(both, 44100));
  write("one.wav", float_wav(bouncing(12, kEps, 0.6), 44100));
  EXPECT_THAT(run("detect two.wav --out o.csv").err, HasSubstr("a second ball seems to bounce at the same time"));
  EXPECT_THAT(run("detect one.wav --out p.csv").err, testing::Not(HasSubstr("second ball")));
}

/// A table with other separators.
std::string resaved(std::string table, char separator) {
  std::replace(table.begin(), table.end(), ',', separator);
  return table;
}

TEST_F(ForeignFiles, TablesOfOursThatWereSavedAgainBySpreadsheetsAreThoseTables) {
  ASSERT_EQ(run("simulate --drops 3 --impacts 20 --asperities 99 --out i.csv").exit_code, 0);
  ASSERT_EQ(run("restitution i.csv --out s.csv").exit_code, 0);
  const auto eps_of = [&](const std::string& samples) {
    std::vector<double> all;
    for (const RestitutionSample& s : samples_from_table(read_csv(folder_ / samples, sample_columns()), samples))
      all.push_back(s.eps);
    return all;
  };
  for (const char separator : {';', '\t'}) {
    // the impacts begin at 0 in each drop, and so do their numbers
    write("o2.csv", resaved(content_of(folder_ / "i.csv"), separator));
    ASSERT_EQ(run("restitution o2.csv --out s2.csv --force").exit_code, 0);
    EXPECT_EQ(eps_of("s2.csv"), eps_of("s.csv"));
    write("s3.csv", resaved(content_of(folder_ / "s.csv"), separator));
    EXPECT_LE(run("fit s3.csv --out f3.json --force").exit_code, 1);
    EXPECT_TRUE(fs::exists(folder_ / "f3.json"));
    fs::remove(folder_ / "f3.json");
  }
}

TEST_F(ForeignFiles, DropsOfTwoBallsInOneTableAreToldApart) {
  const auto drops = [](double other) {
    std::string text = "drop,t_s\n";
    for (int drop = 0; drop < 20; ++drop) {
      double t = 0.5, interval = 0.3 + 0.01 * drop;
      for (int k = 0; k < 12; ++k, interval *= drop < 10 ? 0.8 : other)
        text += std::to_string(drop) + "," + std::to_string(t) + "\n", t += interval;
    }
    return text;
  };
  write("two.csv", drops(0.9));
  const Result two = run("analyze two.csv --out two");
  EXPECT_THAT(two.out, HasSubstr("two kinds: ε is about 0.80 in 10 of them and about 0.90 in 10"));
  EXPECT_THAT(two.out, Not(HasSubstr("ε = ")));  // no value would be that of a ball
  expect_one_line_error(run("dem two/fit.json --code lammps"), 3, {"two/fit.json", "--pool"});
  EXPECT_THAT(run("analyze two.csv --out pooled --pool").out, HasSubstr("ε = "));
  EXPECT_EQ(run("dem pooled/fit.json --code lammps").exit_code, 0);
  write("one.csv", drops(0.801));
  EXPECT_THAT(run("analyze one.csv").out, HasSubstr("ε = 0.80"));
}

TEST_F(ForeignFiles, ATableMayComeThroughAPipe) {
  write("i.csv", "interval_ms\n600\n540\n486\n437.4\n393.7\n354.3\n");
  const std::string answer = run("analyze i.csv --out file").out;
  EXPECT_THAT(answer, HasSubstr("ε = 0.9"));
  const Result piped = shell("cat i.csv | \"$B\" analyze - --out piped");
  EXPECT_EQ(piped.exit_code, 0) << piped.err;
  const auto first_line = [](const std::string& text) { return text.substr(0, text.find('\n')); };
  EXPECT_EQ(first_line(piped.out), first_line(answer));
  ASSERT_EQ(shell("cat i.csv | \"$B\" restitution /dev/stdin --out s.csv").exit_code, 0);
  ASSERT_EQ(run("restitution i.csv --out t.csv").exit_code, 0);
  EXPECT_EQ(content_of(folder_ / "s.csv"), content_of(folder_ / "t.csv"));
}

TEST_F(ForeignFiles, UnitsInTitlesAreThoseOfTheNumbers) {
  const auto taken_for = [&](const std::string& title, double unit_s) {
    std::string text = title + "\n";
    for (const double t_s : {0.0, 0.5, 0.95, 1.355}) text += std::to_string(t_s / unit_s) + "\n";
    write("u.csv", text);
    return run("convert u.csv --to o.csv --force").out;
  };
  EXPECT_THAT(taken_for("t_cs", 1e-2), HasSubstr("times in cs"));
  EXPECT_THAT(content_of(folder_ / "o.csv"), HasSubstr(",1.355,"));
  EXPECT_THAT(taken_for("time [h]", 3600.0), HasSubstr("times in h"));
  EXPECT_THAT(taken_for("Zeit (ms)", 1e-3), HasSubstr("times in ms"));
  write("f.csv", "frame\n12\n132\n240\n337\n");
  expect_one_line_error(run("convert f.csv --to p.csv"), 3, {"f.csv", "frame", "counts frames"});
  for (const auto& [title, unit] : {std::pair{"v_cmps", "cm/s"}, {"v [mm/s]", "mm/s"}, {"v_kmh", "km/h"}}) {
    write("v.csv", std::string(title) + ",eps\n80,0.8\n64,0.8\n51,0.8\n41,0.8\n");
    EXPECT_THAT(run("fit v.csv --out f.json --force").out, HasSubstr(std::string("speeds in ") + unit)) << title;
  }
}

TEST_F(ForeignFiles, WhatIsNeitherTimeNorIntervalIsTakenForNone) {
  const std::string falling = "0.5\n0.361\n0.261\n0.189\n0.136\n";
  for (const char* title :
       {"height (m)", "energy (J)", "Peak amplitude (V)", "speed (m/s)", "e", "temperature (degC)"}) {
    write("h.csv", std::string(title) + "\n" + falling);
    expect_one_line_error(run("analyze h.csv"), 3, {"h.csv", "no column of times or intervals", "--columns"});
  }
  write("b.csv", "bounce,speed (m/s)\n0,3.13\n1,2.66\n2,2.26\n3,1.92\n4,1.63\n");
  expect_one_line_error(run("analyze b.csv"), 3, {"b.csv", "no column of times or intervals"});
  write("gap.csv", "n,time (s)\n0,0.5\n1,1.0\n2,-\n3,1.355\n4,1.6\n");
  expect_one_line_error(run("analyze gap.csv"), 3, {"gap.csv", "line 4", "'-' is no number"});
  write("end.csv", "n,time (s)\n0,0.5\n1,1.0\n2,1.355\n3,1.6\n4,\n");  // the last was not heard
  EXPECT_EQ(run("analyze end.csv --out end").exit_code, 0);
}

TEST_F(ForeignFiles, SpeedsInOtherUnitsAndSquaresOfTheCoefficientAreRefused) {
  for (const auto& [titles, words] : {std::pair{"speed (mph),e", "unit that is not known"},
                                      {"v (ft/s),e", "unit that is not known"},
                                      {"speed (knots),e", "unit that is not known"},
                                      {"v (m/s),e^2", "no columns that are plainly speed"},
                                      {"v (m/s),1-e", "no columns that are plainly speed"},
                                      {"v_t (m/s),e", "no columns that are plainly speed"},
                                      {"ln(v),e", "no columns that are plainly speed"}}) {
    write("v.csv", std::string(titles) + "\n2,0.8\n1.6,0.8\n1.3,0.8\n1,0.8\n");
    expect_one_line_error(run("fit v.csv --out f.json"), 3, {"v.csv", words});
  }
  write("known.csv", "known speed,e\n2,0.8\n1.6,0.8\n1.3,0.8\n1,0.8\n");
  EXPECT_THAT(run("fit known.csv --out k.json").out, HasSubstr("speeds in m/s"));
}

TEST_F(ForeignFiles, ManyBouncesThatAreLeftOutAreSaid) {
  std::string text = "drop,t_s\n";
  for (int drop = 0; drop < 3; ++drop) {
    double t_s = drop, interval_s = 0.6;
    for (const double eps : {0.5, 0.5, 0.5, 0.9, 0.91, 0.89, 0.9, 0.9, 0.9})
      text += std::to_string(drop) + "," + std::to_string(t_s) + "\n", t_s += interval_s, interval_s *= eps;
  }
  write("two_floors.csv", text);
  EXPECT_THAT(run("analyze two_floors.csv --out r").out, HasSubstr("of 21 bounces are left out"));
}

TEST_F(ForeignFiles, DropsThatDifferAreSaid) {
  std::string text = "drop,t_s\n";
  int drop = 0;
  for (const double level : {0.78, 0.8, 0.83, 0.81}) {
    double t_s = drop, interval_s = 0.6;
    for (const double more : {0.0, 0.002, -0.003, 0.001, 0.003, -0.002, 0.0, 0.001})
      text += std::to_string(drop) + "," + std::to_string(t_s) + "\n", t_s += interval_s, interval_s *= level + more;
    ++drop;
  }
  write("d.csv", text);
  EXPECT_THAT(run("analyze d.csv --out r").out, HasSubstr("The 4 drops differ by more"));
}

TEST_F(ForeignFiles, TheSameDropTwiceIsSaid) {
  const double scatter[] = {0.85, 0.846, 0.853, 0.849, 0.855, 0.844, 0.851, 0.848};
  for (const int shift_s : {0, 3}) {
    std::string text = "t_s\n";
    double t_s = shift_s, interval_s = 0.5;
    for (const double eps : scatter) text += std::to_string(t_s) + "\n", t_s += interval_s, interval_s *= eps;
    write("c" + std::to_string(shift_s) + ".csv", text);
  }
  EXPECT_THAT(run("analyze c0.csv c3.csv --out both").out, HasSubstr("the same drop twice?"));
  EXPECT_THAT(run("analyze c0.csv --out one").out, Not(HasSubstr("twice")));
}

TEST_F(ForeignFiles, AColumnForEachDropIsNoRowForEachDrop) {
  write("c.csv", "T1 (s),T2 (s),T3 (s)\n0.1,0.2,0.15\n0.6,0.72,0.66\n1.03,1.14,1.1\n1.38,1.5,1.47\n");
  expect_one_line_error(run("analyze c.csv"), 3, {"c.csv", "a column for each drop", "T1 (s)"});
  write("r.csv", "T1 (s),T2 (s),T3 (s)\n0.1,0.6,1.03\n0.2,0.72,1.14\n0.15,0.66,1.1\n");
  EXPECT_THAT(run("analyze r.csv --out r").out, HasSubstr("a row for each drop"));
  write("v.csv", "Run 1: Time (s)\n0.5\n1.0\n1.43\n1.79\n2.1\n");
  EXPECT_THAT(run("analyze v.csv --out v").out, HasSubstr("5 impacts in 1 drop"));
}

}  // namespace
}  // namespace bouncelab::cli_test
