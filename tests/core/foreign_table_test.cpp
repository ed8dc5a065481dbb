// SPDX-License-Identifier: GPL-3.0-or-later
// Times, intervals and coefficients of restitution as other programs and people write them. The formats are written
// after: phyphox's experiments "Acoustic Stopwatch" and "(In)elastic collision" and its DataExport.java (columns named
// in quotes, 0.000000000E0, five pairs of separator and decimal sign); Tracker's help, "Exporting data" (the track's
// name, a line of titles, tabs); Raven Pro's selection tables; Audition's markers (tabs, clock times); Sonic
// Visualiser's export of a time instants layer; aubioonset's standard output.
#include "bouncelab/core/foreign_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "support/refusal.hpp"

namespace bouncelab {
namespace {

using testing::HasSubstr;

constexpr double kEps = 0.85;

/// Of a ball that bounces n times.
std::vector<double> times(int n = 12, double begin_s = 0.4, double flight_s = 0.6) {
  std::vector<double> t_s{begin_s};
  for (; std::ssize(t_s) < n; flight_s *= kEps) t_s.push_back(t_s.back() + flight_s);
  return t_s;
}

std::vector<double> intervals(int n = 12) {
  const std::vector<double> t_s = times(n);
  std::vector<double> all_s;
  for (std::size_t k = 1; k < t_s.size(); ++k) all_s.push_back(t_s[k] - t_s[k - 1]);
  return all_s;
}

std::string with_comma(std::string text) {
  for (char& c : text)
    if (c == '.') c = ',';
  return text;
}

/// As Java's pattern 0.000000000E0 writes it.
std::string phyphox(double x) {
  const int exponent = x == 0.0 ? 0 : static_cast<int>(std::floor(std::log10(std::abs(x))));
  return formatted("%.9fE%d", x / std::pow(10.0, exponent), exponent);
}

std::string clock(double t_s) { return formatted("%d:%06.3f", static_cast<int>(t_s / 60.0), std::fmod(t_s, 60.0)); }

/// A line for each value.
std::string lines(const std::vector<double>& values, const std::function<std::string(std::size_t, double)>& line) {
  std::string text;
  for (std::size_t k = 0; k < values.size(); ++k) text += line(k, values[k]) + "\n";
  return text;
}

std::string row(const std::vector<double>& values, const std::string& separator,
                const std::function<std::string(double)>& cell) {
  std::string text;
  for (std::size_t k = 0; k < values.size(); ++k) text += (k == 0 ? "" : separator) + cell(values[k]);
  return text + "\n";
}

TakenTable taken(const std::string& bytes, const ForeignOptions& options = {}) {
  return onsets_from_foreign(read_foreign_table(decoded_text(bytes, "x"), "x"), "x", options);
}

Onsets read(const std::string& bytes, const ForeignOptions& options = {}) {
  return onsets_from_table(taken(bytes, options).table, "x");
}

std::vector<double> times_of(const Onsets& onsets) {
  std::vector<double> t_s;
  for (const Onset& onset : onsets) t_s.push_back(onset.t_s);
  return t_s;
}

std::string refusal(const std::string& bytes, const ForeignOptions& options = {}) {
  return test::refusal<FileError>([&] { read(bytes, options); });
}

/// Each drop's intervals shrink by kEps.
/// @param tolerance  of the ratio, by the digits written
void expect_drops(const Onsets& onsets, std::size_t n_drops, std::size_t n_impacts, double tolerance) {
  ASSERT_EQ(onsets.size(), n_drops * n_impacts);
  EXPECT_EQ(onsets.back().drop, static_cast<std::int64_t>(n_drops) - 1);
  for (std::size_t k = 2; k < onsets.size(); ++k) {
    if (onsets[k].drop != onsets[k - 2].drop) continue;
    const double ratio = (onsets[k].t_s - onsets[k - 1].t_s) / (onsets[k - 1].t_s - onsets[k - 2].t_s);
    EXPECT_NEAR(ratio, kEps, tolerance) << "impact " << k;
  }
}

struct TableCase {
  const char* name;
  std::string text;
  std::size_t n_drops, n_impacts;
  double tolerance;
  const char* taken_for;
};

TEST(ForeignTable, OfTimesAndIntervalsIsWhatItsWriterMeant) {
  const std::vector<double> t_s = times(), T_s = intervals(), six = times(6);
  std::vector<double> unset{six[0], six[1], six[2], six[3], 0.0, 0.0};  // a stopwatch that heard four
  std::string bounces, heights;  // of phyphox's collision: times, heights and energies in turn
  for (std::size_t k = 0; k < 6; ++k) {
    const std::string n = std::to_string(k), separator = k == 0 ? "" : "\t";
    bounces +=
        separator + "\"Bounce " + n + " (s)\"\t\"Height " + n + " (m)\"" + (k > 0 ? "\t\"Energy " + n + "\"" : "");
    heights += separator + phyphox(six[k]) + "\t" + phyphox(0.44 * std::pow(kEps, 2.0 * static_cast<double>(k))) +
               (k > 0 ? "\t" + phyphox(std::pow(kEps, 2.0 * static_cast<double>(k) - 2.0)) : "");
  }
  std::vector<double> twice_s = t_s, both_s = T_s;
  for (const double t : t_s) twice_s.push_back(t_s.back() + 3.0 + t);
  both_s.insert(both_s.end(), T_s.begin(), T_s.end());
  const auto six_digits = [](std::size_t, double t) { return formatted("%.6f", t); };
  const std::string stopwatch = R"x("Start (s)","Stop 1 (s)","Stop 2 (s)","Stop 3 (s)","Stop 4 (s)","Stop 5 (s)")x";
  // six decimals of seconds: 1e-6 of the shortest interval, 0.1 s; four: 1e-3; three: 0.01
  const std::vector<TableCase> cases{
      {"aubioonset", lines(t_s, six_digits), 1, 12, 2e-5, "times in s"},
      {"comments and blank lines", "# aubio\n\n" + lines(t_s, six_digits) + "\n", 1, 12, 2e-5, "times in s"},
      {"Sonic Visualiser", lines(t_s, [](auto, double t) { return formatted("%.9f,New Point", t); }), 1, 12, 1e-7,
       "times"},
      {"phyphox stopwatch", stopwatch + "\n" + row(six, ",", phyphox), 1, 6, 1e-7, "times in s (a row"},
      {"phyphox stopwatch, four heard", stopwatch + "\n" + row(unset, ",", phyphox), 1, 4, 1e-7, "times in s"},
      {"phyphox collision, tabs, decimal comma", bounces + "\n" + with_comma(heights) + "\n", 1, 6, 1e-7,
       "decimal comma"},
      {"phyphox intervals",
       "\"Event\",\"Interval (s)\"\n" +
           lines(T_s, [](std::size_t k, double T) { return std::to_string(k + 1) + "," + phyphox(T); }),
       1, 12, 1e-7, "intervals in s"},
      {"semicolons, decimal comma",
       "t_s;note\n" + lines(t_s, [](auto, double t) { return with_comma(formatted("%.6f;x", t)); }), 1, 12, 2e-5,
       "';' between, decimal comma"},
      {"decimal comma alone", lines(t_s, [](auto, double t) { return with_comma(formatted("%.6f", t)); }), 1, 12, 2e-5,
       "decimal comma"},
      {"a spreadsheet's quotes",
       "\"Nr\",\"Zeit / s\"\r\n" + lines(t_s,
                                         [](std::size_t k, double t) {
                                           return "\"" + std::to_string(k + 1) + "\",\"" +
                                                  with_comma(formatted("%.4f", t)) + "\"\r";
                                         }),
       1, 12, 2e-3, "times in s"},
      {"milliseconds by title", "t_ms\n" + lines(t_s, [](auto, double t) { return formatted("%.3f", 1e3 * t); }), 1, 12,
       2e-5, "times in ms"},
      {"minutes", "Time (min)\n" + lines(t_s, [](auto, double t) { return formatted("%.9f", t / 60.0); }), 1, 12, 2e-6,
       "times in min"},
      {"milliseconds by size", lines(t_s, [](auto, double t) { return formatted("%.2f", 1e3 * t); }), 1, 12, 2e-4,
       "times in ms"},
      {"intervals in milliseconds", lines(T_s, [](auto, double T) { return formatted("%.1f", 1e3 * T); }), 1, 12, 2e-3,
       "intervals in ms"},
      {"intervals called times", "t_s\n" + lines(T_s, six_digits), 1, 12, 2e-5, "they fall"},
      {"a row of intervals", with_comma(row(T_s, ";", [](double T) { return formatted("%.4f", T); })), 1, 12, 2e-3,
       "intervals in s (a row"},
      {"a row for each drop",
       "drop;T1;T2;T3;T4\n1;" +
           row({T_s[0], T_s[1], T_s[2], T_s[3]}, ";", [](double T) { return formatted("%.4f", T); }) + "2;" +
           row({T_s[0], T_s[1], T_s[2], T_s[3]}, ";", [](double T) { return formatted("%.4f", T); }),
       2, 5, 1e-3, "a row for each drop"},
      {"intervals of two drops", lines(both_s, [](auto, double T) { return formatted("%.4f", T); }), 2, 12, 2e-3,
       "in 2 drops"},
      {"times of two drops", lines(twice_s, [](auto, double t) { return formatted("%.5f", t); }), 2, 12, 2e-4,
       "in 2 drops"},
      {"two drops that begin at 0", "t_s\n" + lines(t_s, six_digits) + lines(t_s, six_digits), 2, 12, 2e-5,
       "in 2 drops"},
      {"trials",
       "trial,t\n" + lines(t_s, [](auto, double t) { return formatted("1,%.5f", t); }) +
           lines(t_s, [](auto, double t) { return formatted("2,%.5f", t + 5.0); }),
       2, 12, 2e-4, "in 2 drops"},
      {"Tracker",
       "#multi:\nmass_A\nt\tx\ty\n" + lines(t_s, [](auto, double t) { return formatted("%.5f\t0.1\t0.0", t); }), 1, 12,
       2e-4, "column 't'"},
      {"Raven",
       "Selection\tView\tChannel\tBegin Time (s)\tEnd Time (s)\tLow Freq (Hz)\n" +
           lines(t_s,
                 [](std::size_t k, double t) {
                   return formatted("%d\tWaveform 1\t1\t%.9f\t%.9f\t0.0", static_cast<int>(k) + 1, t, t + 0.01);
                 }),
       1, 12, 1e-7, "'Begin Time (s)'"},
      {"Audition",
       "\xEF\xBB\xBFName\tStart\tDuration\tTime Format\tType\n" + lines(t_s,
                                                                        [](std::size_t k, double t) {
                                                                          return "Marker " + std::to_string(k) + "\t" +
                                                                                 clock(t) + "\t0:00.000\tdecimal\tCue";
                                                                        }),
       1, 12, 2e-2, "clock times"},
      {"clock times with commas", lines(t_s, [](auto, double t) { return "00:0" + with_comma(clock(t)); }), 1, 12, 2e-2,
       "clock times"},
      {"lines that end in CR", "Time (ms)\r" + row(t_s, "\r", [](double t) { return formatted("%.3f", 1e3 * t); }), 1,
       12, 2e-5, "times in ms"},
      {"Latin-1", "Zeit (\xB5s)\n" + lines(t_s, [](auto, double t) { return formatted("%.0f", 1e6 * t); }), 1, 12, 2e-5,
       "times in us"}};
  for (const TableCase& c : cases) {
    SCOPED_TRACE(c.name);
    expect_drops(read(c.text), c.n_drops, c.n_impacts, c.tolerance);
    EXPECT_THAT(taken(c.text).taken_for, HasSubstr(c.taken_for));
  }
}

TEST(ForeignTable, IsTheSameInEveryEncoding) {
  const std::string text = "Zeit (ms);Notiz\n" + lines(times(), [](auto, double t) {
                             return with_comma(formatted("%.3f", 1e3 * t)) + ";h\xC3\xB6rbar";
                           });
  const std::vector<double> expected_s = times_of(read(text));
  for (const bool is_big_endian : {false, true})
    for (const bool with_mark : {false, true}) {
      std::string utf16 = !with_mark ? "" : is_big_endian ? "\xFE\xFF" : "\xFF\xFE";
      for (std::size_t k = 0; k < text.size(); ++k) {
        const char c = text[k] == '\xC3' ? '\xF6' : text[k];  // the one character of two bytes
        if (text[k] == '\xC3') ++k;
        utf16 += is_big_endian ? std::string{'\0', c} : std::string{c, '\0'};
      }
      EXPECT_EQ(times_of(read(utf16)), expected_s) << is_big_endian << with_mark;
    }
  EXPECT_EQ(times_of(read("\xEF\xBB\xBF" + text)), expected_s);
}

TEST(ForeignTable, CarriesTheRoundingOfItsNumbers) {
  // hundredths of a second: the error of a number rounded so is 10 ms/sqrt(12)
  const Onsets onsets = read(lines(times(), [](auto, double t) { return formatted("%.2f", t); }));
  for (const Onset& onset : onsets) EXPECT_NEAR(onset.sigma_t_s.value_or(0.0), 0.01 / std::sqrt(12.0), 1e-12);
  const Onsets ms = read("t_ms\n" + lines(times(), [](auto, double t) { return formatted("%.0f", 1e3 * t); }));
  EXPECT_NEAR(ms.front().sigma_t_s.value_or(0.0), 0.001 / std::sqrt(12.0), 1e-12);
}

TEST(ForeignTable, IsTakenAsTheUserSays) {
  ForeignOptions times_in_ms;
  times_in_ms.as = "times";
  times_in_ms.unit = "ms";
  EXPECT_NEAR(read("1\n3\n4\n", times_in_ms)[1].t_s, 0.003, 1e-15);
  ForeignOptions of_column;
  of_column.columns = "t=when,drop=2";
  const Onsets onsets = read("x,n,when\n9,1,0.5\n8,1,0.9\n7,2,3.0\n", of_column);
  ASSERT_EQ(onsets.size(), 3U);
  EXPECT_EQ(onsets[1].t_s, 0.9);
  EXPECT_EQ(onsets[2].drop, 1);
}

TEST(ForeignTable, ThatCannotBeToldIsRefusedWithTheRemedy) {
  EXPECT_THAT(refusal("mass_A\nt\tx\ty\n" + lines(std::vector<double>(20),
                                                  [](std::size_t k, double) {
                                                    return formatted("%.4f\t0.1\t0.2", static_cast<double>(k) / 30.0);
                                                  })),
              testing::AllOf(HasSubstr("frames of a video"), HasSubstr("--as times")));
  EXPECT_THAT(refusal("speed;e\n1.2;0.85\n1.0;0.85\n0.8;0.86\n"), HasSubstr("bouncelab fit"));
  EXPECT_THAT(refusal("speed;e\n" + lines(std::vector<double>(20),
                                          [](std::size_t k, double) {
                                            return formatted("%.2f;0.85", 0.2 + 0.05 * static_cast<double>(
                                                                                           k));  // spaced as frames are
                                          })),
              HasSubstr("bouncelab fit"));
  EXPECT_THAT(refusal("1,600\n2,510\n3,433\n"), HasSubstr("one number or two"));
  EXPECT_THAT(refusal("400000\n1000000\n1510000\n"), HasSubstr("--unit"));
  EXPECT_THAT(refusal("t_s\n0.1\n0.2\nlater\n0.4\n"), HasSubstr("line 4, column 't_s': 'later' is no number"));
  EXPECT_THAT(refusal("once upon a time\n"), HasSubstr("line 1"));
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  ForeignOptions no_such;
  no_such.columns = "t=when";
  EXPECT_THAT(refusal("a,b\n0.1,0.2\n", no_such),
              testing::AllOf(HasSubstr("'when'"), HasSubstr("column 'a', column 'b'")));
}

TEST(ForeignTable, OfWhatIsComputedOfTimesIsRefused) {
  for (const char* title :
       {"T^2 (s^2)", "sqrt(interval)", "1/T (1/s)", "interval rate (Hz)", "half interval (s)", "Contact time (ms)",
        "sigma_t (s)", "Time (10^-3 s)", "Time (x0.1 s)", "Time (1/100 s)", "1 - dt", "t\xC2\xB2", "log time"}) {
    EXPECT_THAT(refusal(std::string(title) + "\n0.6\n0.5\n0.43\n0.36\n"), HasSubstr("--columns t=COLUMN")) << title;
    // beside times it is not taken for them
    EXPECT_EQ(read("Time (s);" + std::string(title) + "\n1.0;0.6\n1.6;0.5\n2.1;0.43\n")[1].t_s, 1.6) << title;
  }
  for (const char* title : {"Run 1 - Time (s)", "Time [s]", "t / s", "T1", "Time (run 1)", "Time/s", "(t)"})
    EXPECT_EQ(read(std::string(title) + "\n1.0\n1.6\n2.1\n2.5\n")[1].t_s, 1.6) << title;
  EXPECT_NEAR(read("time (ds)\n10\n16\n21\n25\n")[1].t_s, 1.6, 1e-12);
}

TEST(ForeignTable, WithAGapInARowIsRefused) {
  for (const char* nothing : {"", "0", "NaN", "-"})
    EXPECT_THAT(refusal("T1,T2,T3,T4,T5\n.4,.3,.25,.2,.16\n.4,.3," + std::string(nothing) + ",.2,.16\n"),
                HasSubstr("line 3, column 'T3': nothing is written between two numbers"));
  EXPECT_THAT(refusal("T1,T2,T3,T4\n.4,,.25,.2\n.4,,.25,.2\n"), HasSubstr("column 'T2': nothing is written"));
  EXPECT_EQ(read("T1,T2,T3,T4,T5\n.4,.3,.25,.2,.16\n.4,.3,.25,,\n").size(), 10U);
}

TEST(ForeignTable, ADropGoesOnInTheEmptyCellsOfAMergedOne) {
  const Onsets onsets = read("drop;time (s)\n1;1.0\n;1.4\n;1.7\n2;5.0\n;5.4\n;5.7\n");
  ASSERT_EQ(onsets.size(), 6U);
  EXPECT_EQ(onsets[2].drop, onsets[0].drop);
  EXPECT_EQ(onsets[5].drop, onsets[3].drop);
  EXPECT_NE(onsets[3].drop, onsets[0].drop);
}

TEST(ForeignTable, ItsDropsAreToldByAllColumnsThatSaySo) {
  const Onsets onsets =
      read("Run,Trial,Measurement,time (s)\n1,1,1,1.0\n1,1,2,1.4\n1,2,1,2.0\n1,2,2,2.4\n2,2,1,3.0\n2,2,2,3.4\n");
  ASSERT_EQ(onsets.size(), 6U);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(onsets[k].drop, static_cast<std::int64_t>(k / 2)) << k;
  // the number of the impact in each row begins none
  EXPECT_EQ(read("Drop,Measurement,time (s)\n1,1,1.0\n1,2,1.4\n1,3,1.7\n")[2].drop, 0);
}

/// Of a ball released from heights in their order: intervals fall along the rows and down the columns.
std::string fallen(bool a_row_is_a_drop) {
  std::string text;
  for (int row = 0; row < 5; ++row)
    for (int column = 0; column < 4; ++column) {
      const int bounce = a_row_is_a_drop ? column : row, drop = a_row_is_a_drop ? row : column;
      constexpr std::array<double, 5> kFirst_s{0.90, 0.80, 0.74, 0.55, 0.50};
      text += formatted("%.4f", kFirst_s[static_cast<std::size_t>(drop)] * std::pow(0.75, bounce)) +
              (column == 3 ? "\n" : ",");
    }
  return text;
}

TEST(ForeignTable, ARowIsADropWhereTheTitlesAreNumbersAndItsRatiosAreAlike) {
  for (const char* titles : {"T1,T2,T3,T4\n", "1,2,3,4\n"}) {
    EXPECT_EQ(read(titles + fallen(true)).back().drop, 4) << titles;
    EXPECT_THAT(refusal(titles + fallen(false)), HasSubstr("a column for each drop")) << titles;
  }
  // a number of the bounce beside them is no interval
  EXPECT_THAT(refusal("Bounce,T1,T2,T3\n1,.9,.8,.65\n2,.675,.6,.488\n3,.506,.45,.366\n"),
              HasSubstr("a column for each drop"));
  EXPECT_THAT(refusal(fallen(true)), HasSubstr("name the columns T1, T2, T3"));
  for (const char* titles : {"Bounce,Anna,Bob\n", "Bounce,Trial 1,Trial 2\n"})
    EXPECT_THAT(refusal(titles + std::string("1,.9,.8\n2,.7,.62\n3,.55,.45\n")), HasSubstr("a column for each drop"));
}

TEST(ForeignTable, ANumberOfTheImpactOrAMeanIsNoTime) {
  const Onsets onsets = read("Table,Bounce,dt (ms)\n1,1,600\n1,2,480\n1,3,384\n1,1,590\n1,2,475\n1,3,380\n");
  ASSERT_EQ(onsets.size(), 8U);
  EXPECT_NEAR(onsets[1].t_s, 0.6, 1e-12);
  EXPECT_EQ(read("Drop,T1,T2,T3\n1,.6,.5,.4\n2,.6,.5,.4\nMean,.6,.5,.4\nStd. dev.,.01,.01,.01\n").back().drop, 1);
  EXPECT_EQ(read("Series,Time (s)\nS1,1.0\nS1,1.5\nS2,3.0\nS2,3.5\nmean,2.2\n").size(), 4U) << "S1 is no unit";
  // Trial alone tells nothing where it is always 1
  EXPECT_EQ(read("Student,Trial,Interval (s)\nA,1,.6\nA,1,.5\nB,1,.6\nB,1,.5\n").back().drop, 1);
  EXPECT_EQ(read("Trial,Interval (s)\n1,.6\n1,.3\n1,.6\n1,.3\n").back().drop, 1);
}

TEST(ForeignTable, OfSeveralBallsIsRefused) {
  EXPECT_THAT(refusal("ball;time (s)\nsteel;1.0\nsteel;1.4\nsteel;1.7\nglass;5.0\nglass;5.5\n"),
              HasSubstr("line 5, column 'ball': 'glass' follows 'steel'"));
  EXPECT_THAT(refusal("Ball 1 (Material),time (s)\n1,1.0\n1,1.4\n2,5.0\n2,5.5\n"), HasSubstr("one ball on one floor"));
  EXPECT_EQ(read("floor type;time (s)\nwood;1.0\n;1.4\nWood;1.7\n").size(), 3U);
  EXPECT_EQ(read("time (s);ball\n1.0;0.01\n1.4;0.02\n1.7;0.01\n").size(), 3U) << "where it was";
  const ForeignTable two = read_foreign_table("ball;v;e\na;1.2;0.8\nb;1.1;0.7\n", "x");
  EXPECT_THAT(test::refusal<FileError>([&] { samples_from_foreign(two, "x", {}); }), HasSubstr("'b' follows 'a'"));
}

TEST(ForeignTable, OfTimesInNoOrderIsRefused) {
  EXPECT_THAT(refusal("T1,T3,T2\n.5,.3,.4\n.5,.3,.4\n"), HasSubstr("column 'T2' stands behind column 'T3'"));
  // nor is one too many
  EXPECT_EQ(read("time (s)\n1.0\n1.6\n1.6004\n2.08\n2.46\n").back().drop, 0);
  // a time that stands twice is no beginning of another drop
  EXPECT_THROW(read("time (s)\n1.0\n1.4\n1.4\n1.7\n"), FileError);
}

TEST(ForeignTable, ItsTimesAreTheColumnThatSaysSo) {
  // a number of the impact that begins anew, or has a gap
  EXPECT_EQ(read("impact,time (s)\n0,1.0\n1,1.6\n5,2.1\n6,2.5\n")[1].t_s, 1.6);
  // thousands separators are no numbers: what stands beside them is not taken instead
  EXPECT_THAT(refusal("Peak;Time (ms)\n0.9;1,000.0\n0.8;1,395.7\n0.7;1,712.8\n"),
              HasSubstr("line 2, column 'Time (ms)': '1,000.0' is no number"));
  EXPECT_THAT(refusal("Peak;Time (ms)\n0,9;1,000\n0,8;1,395\n0,7;1,712\n"), HasSubstr("does a comma part thousands?"));
  EXPECT_THAT(refusal("Time ball 1 (s),Time ball 2 (s)\n1.0,10.0\n1.6,10.5\n2.1,10.9\n"),
              HasSubstr("a column for each drop"));
  EXPECT_THAT(refusal("time\n1000 ms\n1396 ms\n1.711 s\n1.961 s\n"), HasSubstr("a unit beside its number"));
}

TEST(ForeignTable, OfSpeedsAndCoefficientsIsFoundByItsTitlesOrTold) {
  const auto samples = [](const std::string& text, const std::string& columns = {}) {
    ForeignOptions options;
    options.columns = columns;
    return samples_from_table(samples_from_foreign(read_foreign_table(text, "x"), "x", options).table, "x");
  };
  const RestitutionSamples german =
      samples("Versuch;v_in (cm/s);v_out (cm/s);COR\n1;120,5;102,4;0,850\n2;98,0;83,3;0,850\n");
  ASSERT_EQ(german.size(), 2U);
  EXPECT_NEAR(german[0].v_mps, 1.205, 1e-12);
  EXPECT_NEAR(german[1].eps, 0.85, 1e-12);
  EXPECT_NEAR(german[1].sigma_eps.value_or(0.0), 0.001 / std::sqrt(12.0), 1e-12);  // of its three decimals
  EXPECT_EQ(samples("a\tb\n0.9\t1.2\n0.8\t1.0\n", "eps=a,v=2")[1].v_mps, 1.0);
  EXPECT_THROW(samples("a\tb\n0.9\t1.2\n"), FileError);
  // our own as a spreadsheet saves it
  EXPECT_EQ(samples("drop;impact;v_mps;eps\n0;1;1,2;0,8\n1;3;1,0;0,8\n")[1].drop, 1);
  EXPECT_EQ(samples("drop;impact;v_mps;eps\n0;1;1,2;0,8\n1;3;1,0;0,8\n")[1].impact, 3);
  EXPECT_EQ(samples("drop;v_mps;eps\nfirst;1,2;0,8\nsecond;1,0;0,8\n").size(), 2U);
  EXPECT_THAT(test::refusal<FileError>([&] { samples("v;e\n1.2;89\n1.0;90\n0.8;91\n"); }), HasSubstr("per cent"));
}

TEST(DecodedText, IsTheSameInPiecesOfAnySize) {
  const std::string utf8 = "Zeit;\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80\n";
  const std::u16string utf16 = u"\uFEFFZeit;\u00E4\u20AC\U0001F600\n";
  const std::u32string utf32 = U"\uFEFFZeit;\u00E4\u20AC\U0001F600\n";
  std::string big_endian(reinterpret_cast<const char*>(utf16.data()), 2 * utf16.size());
  for (std::size_t k = 0; k < big_endian.size(); k += 2) std::swap(big_endian[k], big_endian[k + 1]);
  for (const std::string& bytes :
       {"\xEF\xBB\xBF" + utf8, big_endian, std::string(reinterpret_cast<const char*>(utf16.data()), 2 * utf16.size()),
        std::string(reinterpret_cast<const char*>(utf32.data()), 4 * utf32.size())})
    for (std::size_t n = 4; n <= bytes.size(); ++n) {
      TextDecoder decoder("x");
      std::string text;
      for (std::size_t at = 0; at < bytes.size(); at += at == 0 ? n : 1)
        decoder.append(std::string_view(bytes).substr(at, at == 0 ? n : 1), text);
      decoder.finish();
      EXPECT_EQ(text, utf8) << n;
    }
}

TEST(DecodedText, NamesWhatItIsNot) {
  const auto message = [](const std::string& bytes) -> std::string {
    try {
      return decoded_text(bytes, "x");
    } catch (const FileError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(message(std::string("\xFF\xFE\0\0a\0\0\0", 8)), "a");
  EXPECT_EQ(message(std::string("\0\0\xFE\xFF\0\0\0a", 8)), "a");
  EXPECT_THAT(message(std::string("\0\0\xFE\xFF\0\0\0", 7)), HasSubstr("cut off within a character of UTF-32"));
  const std::string zip = "PK\x03\x04" + std::string(26, ' ');
  for (const char* first : {"[Content_Types].xml", "docProps/app.xml", "xl/workbook.xml",
                            "mimetypeapplication/vnd.oasis", "Index/Document.iwa"})
    EXPECT_EQ(message(zip + first), "x: is a workbook: save the sheet as CSV") << first;
  EXPECT_EQ(message("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"), "x: is a workbook: save the sheet as CSV");
  EXPECT_EQ(message(zip + "Raw Data.csv"), "x: is a ZIP archive: unpack it, or save the sheet as CSV");
  EXPECT_THAT(message("PK\x03\x04"), HasSubstr("ZIP archive"));
  EXPECT_THAT(message(std::string("\xFF\xFE\0\xDC", 4)), HasSubstr("damaged UTF-16"));
  EXPECT_THAT(message(std::string("a\0b\0\0\0c d e f g", 15)), HasSubstr("bytes 0"));
  EXPECT_THAT(message("\x81"), HasSubstr("neither UTF-8"));
  EXPECT_EQ(message("\x80 5\n"), "\xE2\x82\xAC 5\n");                                  // the euro of Windows-1252
  EXPECT_EQ(message(std::string("\xFF\xFE\x3D\xD8\x00\xDE", 6)), "\xF0\x9F\x98\x80");  // a pair of surrogates
}

}  // namespace
}  // namespace bouncelab
