// SPDX-License-Identifier: GPL-3.0-or-later
// The rule of docs/formats.md, "Files of other programs", sentence by sentence: what is read, what is asked, what is an
// error. Exports are written after: phyphox's experiments "Acoustic Stopwatch" and "(In)elastic collision" and its
// DataExport.java; Tracker's help, "Exporting data"; Raven Pro's selection tables; Audition's markers; aubioonset.
#include "bouncelab/core/foreign_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <optional>
#include <regex>
#include <stdexcept>
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
using Drops = std::vector<std::vector<double>>;

struct Taken {
  Drops drops;
  Onsets onsets;
  std::string taken_for;
};

Taken read(const std::string& bytes, const ForeignOptions& options = {}) {
  const TakenTable taken = onsets_from_foreign(read_foreign_table(decoded_text(bytes, "x"), "x", options));
  Taken result{{}, onsets_from_table(taken.table, "x"), taken.taken_for};
  for (const Onset& onset : result.onsets) {
    result.drops.resize(static_cast<std::size_t>(onset.drop) + 1);
    result.drops.back().push_back(onset.t_s);
  }
  return result;
}

RestitutionSamples samples(const std::string& text, const std::string& columns = {}) {
  ForeignOptions options;
  options.columns = columns;
  return samples_from_table(samples_from_foreign(read_foreign_table(text, "x", options)).table, "x");
}

std::string error_of(const std::string& bytes, const ForeignOptions& options = {}) {
  return test::refusal<FileError>([&] { read(bytes, options); });
}

template <class Call>
std::optional<AmbiguousTable> question_of(const Call& call) {
  try {
    call();
  } catch (const AmbiguousTable& asked) {
    return asked;
  }
  return std::nullopt;
}

/// The cases of a table: a line each, fields between " | ", in which "\n", "\t" and "\r" are those bytes.
std::vector<std::vector<std::string>> cases_of(std::string_view table) {
  std::vector<std::vector<std::string>> cases;
  for (const std::string_view line : cells_of(table, '\n')) {
    if (line.empty()) continue;
    std::vector<std::string> fields(1);
    for (std::size_t k = 0; k < line.size(); ++k) {
      const std::string_view rest = line.substr(k);
      if (rest.starts_with(" | "))
        fields.emplace_back(), k += 2;
      else if (rest.front() == '\\')
        fields.back() += rest[1] == 'n' ? '\n' : rest[1] == 't' ? '\t' : '\r', ++k;
      else
        fields.back() += rest.front();
    }
    cases.push_back(std::move(fields));
  }
  return cases;
}

/// Of "--as times --unit ms --columns t=Time (s),drop=n".
ForeignOptions options_of(const std::string& text) {
  static const std::regex kForm("(?:--as (\\w+) ?)?(?:--unit (\\w+) ?)?(?:--columns (.*))?");
  std::smatch part;
  if (!std::regex_match(text, part, kForm)) throw std::invalid_argument(text);
  return {part[1].matched ? part[1].str() : "auto", part[2].matched ? part[2].str() : "auto", part[3].str()};
}

/// Of "0.4 1 1.51, 0.1 0.6": two drops. "DAY" is 2026-11-28 at 10 o'clock.
Drops drops_in(const std::string& text) {
  Drops drops;
  for (const std::string_view drop : cells_of(text, ',')) {
    drops.emplace_back();
    double begin_s = 0.0;
    for (const std::string_view cell : cells_of(drop, ' '))
      if (cell == "DAY")
        begin_s = 1795860000.0;
      else
        drops.back().push_back(begin_s + number_of(cell, '.').value().value);
  }
  return drops;
}

void expect_near(const Drops& found, const Drops& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t drop = 0; drop < found.size(); ++drop) {
    ASSERT_EQ(found[drop].size(), expected[drop].size()) << "drop " << drop;
    // times since 1970 stand on a grid of 2.4e-7 s
    for (std::size_t k = 0; k < found[drop].size(); ++k)
      EXPECT_NEAR(found[drop][k], expected[drop][k], 1e-9 + 4e-16 * std::abs(expected[drop][k])) << drop << "." << k;
  }
}

void expect_read(const std::string& text, const ForeignOptions& options, const std::string& drops,
                 const std::string& taken_for) {
  try {
    const Taken taken = read(text, options);
    expect_near(taken.drops, drops_in(drops));
    EXPECT_THAT(taken.taken_for, HasSubstr(taken_for));
  } catch (const Error& error) {
    ADD_FAILURE() << error.what();
  }
}

/// Text | options | impact times of each drop | words of taken_for; by the numbers of the rule.
constexpr const char* kRead = R"x(
1: as people type | 0,4, 1,0, 1,51\n | --as times | 0.4 1 1.51 | times in s (a row, ';' between, decimal comma): 3 impacts in 1 drop
1: commas at the ends | 0.4,\n1,\n1.51\n | --as times | 0.4 1 1.51 | (a row, ',' between)
1: a row that goes on | 0,4, 1,0,\n1,51\n | --as times | 0.4 1 1.51 | decimal comma
1: tabs | n\tTime (s)\n1\t0.4\n2\t1\n3\t1.51\n4\t1.9435\n |  | 0.4 1 1.51 1.9435 | times in s (column 'Time (s)', tabs between)
1: semicolons | n;Time (s)\n1;0,4\n2;1\n3;1,51\n4;1,9435\n |  | 0.4 1 1.51 1.9435 | ';' between, decimal comma
1: commas | n,Time (s)\n1,0.4\n2,1\n3,1.51\n4,1.9435\n |  | 0.4 1 1.51 1.9435 | ',' between
1: blanks |   n   t/s\n  1   0.4\n 10  1\n 11 1.51\n 12   1.9435\n |  | 0.4 1 1.51 1.9435 | blanks between
1: quotes | "n","Time, here (s)"\r\n"1","0,4"\r\n2,1\r\n3,"1,51"\r\n4,"1,9435"\r\n |  | 0.4 1 1.51 1.9435 | decimal comma
1: one column | Time (s)\n0,4\n1,0\n1,51\n1,9435\n |  | 0.4 1 1.51 1.9435 | (column 'Time (s)', decimal comma)
1: lines above | Anna, trial A\n\nball;steel\n\nTime (s);x\n0.4;\n1;\n1.51;\n1.9435;;;\n |  | 0.4 1 1.51 1.9435 | times in s
1: comments | # 3 mm\n#4;5\nTime (s)\n0.4\n1\n1.51\n1.9435\n |  | 0.4 1 1.51 1.9435 | times in s
1: CR | Time (ms)\r400\r1000\r1510\r1943.5\r |  | 0.4 1 1.51 1.9435 | times in ms
1: short rows | Time (s),x\n0.4,7\n1,9\n1.51,8\n1.9435\n |  | 0.4 1 1.51 1.9435 | times in s
2: exponents | Time (s)\n4.0E-1\n1.000000000E0\n+1.51\n194.35e-2\n |  | 0.4 1 1.51 1.9435 | times in s
2: M:S | Start\n0:00.4\n0:01\n00:01.51\n0:01.9435\n |  | 0.4 1 1.51 1.9435 | times as clock times
2: H:M:S | Start;x\n1:00:00,4;\n1:00:01,0;\n1:00:01,51;\n01:00:01,9435;\n |  | 3600.4 3601 3601.51 3601.9435 | as clock times
2: dates | at\n2026-11-28T10:00:00.4Z\n2026-11-28T11:00:01+01:00\n2026-11-28 04:30:01,51-0530\n |  | DAY 0.4 1 1.51 | as clock times
2: dates without a zone | 2026-11-28 10:00:00.4\n2026-11-28T10:00:01\n2026-11-28T10:00:01.51\n |  | DAY 0.4 1 1.51 | as clock times
2: clock times are seconds | t\n0:00.4\n0:01\n0:01.51\n | --unit ms | 0.4 1 1.51 | as clock times
3: ours | Time (ms);t_s;height (m)\n9;0.4;1\n8;1;2\n7;1.51;3\n6;1.9435;4\n |  | 0.4 1 1.51 1.9435 | times in s (column 't_s'
3: [ms] | t [ms]\n400\n1000\n1510\n |  | 0.4 1 1.51 | times in ms
3: / ms | time / ms\n400\n1000\n1510\n |  | 0.4 1 1.51 | times in ms
3: in ms | Zeit in ms\n400\n1000\n1510\n |  | 0.4 1 1.51 | times in ms
3: _ms | time_ms\n400\n1000\n1510\n |  | 0.4 1 1.51 | times in ms
3: us | Zeit (us)\n400000\n1000000\n1510000\n |  | 0.4 1 1.51 | times in us
3: min | t (min)\n0.1\n0.11\n0.1185\n |  | 6 6.6 7.11 | times in min
3: by its cells | Name\tStart\nA\t0:00.4\nB\t0:01\nC\t0:01.51\n |  | 0.4 1 1.51 | as clock times (column 'Start'
3: s | at\n1795860000.4\n1795860001\n1795860001.51\n |  | DAY 0.4 1 1.51 | times in s since 1970
3: ms | at\n1795860000400\n1795860001000\n1795860001510\n |  | DAY 0.4 1 1.51 | times in ms since 1970
3: us | 1795860000400000\n1795860001000000\n1795860001510000\n |  | DAY 0.4 1 1.51 | times in us since 1970
3: ns | at\n1795860000400000000\n1795860001000000000\n1795860001510000000\n |  | DAY 0.4 1 1.51 | times in ns since 1970
3: computed of times | T^2 (s^2);Time (s);1/T (1/s)\n9;.4;9\n8;1;8\n9;1.51;7\n6;1.9435;6\n |  | 0.4 1 1.51 1.9435 | 'Time (s)'
4: dt | dt (ms)\n600\n510\n433.5\n |  | 0 0.6 1.11 1.5435 | intervals in ms (column 'dt (ms)'): 4 impacts in 1 drop
4: Δt | Δt / s\n0.6\n0.51\n0.4335\n |  | 0 0.6 1.11 1.5435 | intervals in s
4: interval | Event,interval_s\n1,0.6\n2,0.51\n3,0.4335\n |  | 0 0.6 1.11 1.5435 | intervals in s
4: phyphox's | "Event","Interval (s)"\n1,6.000000000E-1\n2,5.1E-1\n3,4.335E-1\n |  | 0 0.6 1.11 1.5435 | intervals in s
4: told times | Time (s)\n0.4\n0.2\n | --as times | 0.4, 0.2 | times in s
4: told intervals | 0.6\n0.51\n0.4335\n | --as intervals | 0 0.6 1.11 1.5435 | intervals in s
5: a column | # aubio\n0.4\n1\n1.51\n1.9435\n |  | 0.4 1 1.51 1.9435 | times in s: 4 impacts in 1 drop
5: a row | 0,4; 1; 1,51; 1,9435\n |  | 0.4 1 1.51 1.9435 | times in s (a row, ';' between, decimal comma)
5: a row that ends early | 0.4\t1\t1.51\t1.9435\t\t\n |  | 0.4 1 1.51 1.9435 | a row
5: a unit | 400\n1000\n1510\n1943.5\n | --unit ms | 0.4 1 1.51 1.9435 | times in ms
5: no ball | 1\n3\n4\n | --as times --unit ms | 0.001 0.003 0.004 | times in ms
5: one number | 0,4\n1,0\n1,51\n1,9435\n | --as times | 0.4 1 1.51 1.9435 | decimal comma
5: two numbers | 4,0\n10,1\n15,1\n | --as times --unit ms --columns t=1,drop=2 | 0.004, 0.010 0.015 | ',' between
6: a column drop | drop;Time (s)\nA 1;0.4\n;1\n;1.51\nB;2.1\n;2.6\n;3.0\n;3.3\n |  | 0.4 1 1.51, 2.1 2.6 3 3.3 | 7 impacts in 2 drops
6: a column | x,n,when\n9,1,0.4\n8,1,1\n7,2,1.51\n | --as times --unit s --columns t=when,drop=2 | 0.4 1, 1.51 | in 2 drops
6: a blank line | Time (s);x\n0.4;\n1;\n1.51;\n;\n1.9;\n2.4;\n |  | 0.4 1 1.51, 1.9 2.4 | in 2 drops
6: times that go back | Time (s)\n0.4\n1\n1.51\n0.1\n0.6\n1\n |  | 0.4 1 1.51, 0.1 0.6 1 | in 2 drops
6: both | Time (s)\n0.4\n1\n1.51\n0.1\n0.6\n1\n\n0.4\n1\n1.51\n |  | 0.4 1 1.51, 0.1 0.6 1, 0.4 1 1.51 | in 3 drops
6: a pause | Time (s)\n0.4\n1\n1.51\n4.1\n4.6\n5\n |  | 0.4 1 1.51, 4.1 4.6 5 | in 2 drops
6: an impact not heard | Time (s)\n0.4\n1\n1.51\n2.4\n2.8\n |  | 0.4 1 1.51 2.4 2.8 | in 1 drop
6: a mark too many | Time (s)\n1.0\n1.6\n1.6004\n2.08\n2.46\n |  | 1 1.6 1.6004 2.08 2.46 | in 1 drop
6: intervals that grow | dt (s)\n0.6\n0.51\n0.4335\n0.7\n0.5\n |  | 0 0.6 1.11 1.5435, 0 0.7 1.2 | in 2 drops
6: not by half | dt (s)\n0.6\n0.4\n0.59\n0.5\n |  | 0 0.6 1 1.59 2.09 | in 1 drop
6: both of intervals | dt (s)\n0.6\n0.51\n\n0.6\n.5\n.8\n |  | 0 0.6 1.11, 0 .6 1.1, 0 .8 | in 3 drops
6: a column of intervals | drop,dt (s)\n0,.6\n0,.51\n5,.7\n5,.5\n |  | 0 0.6 1.11, 0 0.7 1.2 | 6 impacts in 2 drops
6: blocks that are the drops | trial,Time (s)\n1,.4\n1,1\n1,1.51\n2,.1\n2,.6\n2,1\n |  | 0.4 1 1.51, 0.1 0.6 1 | in 2 drops
6: numbers of the impacts | impact,Time (s)\n0,.4\n1,1\n2,1.51\n0,.1\n1,.6\n2,1\n |  | 0.4 1 1.51, 0.1 0.6 1 | in 2 drops
6: blocks, answered | trial,Time (s)\n1,.4\n1,1\n2,1.51\n2,1.9435\n | --columns t=2 | 0.4 1 1.51 1.9435 | in 1 drop
6: a drop in each column | A (s),B (s)\n.4,.1\n1,.6\n1.51,1\n1.9,\n | --columns t=A (s),t=B (s) | .4 1 1.51 1.9, .1 .6 1 | times in s (2 columns, ',' between): 7 impacts in 2 drops
6: over midnight | at\n23:59:59.5\n23:59:59.9\n0:00:00.24\n0:00:00.5\n |  | 86399.5 86399.9 86400.24 86400.5 | in 1 drop
7: a mean, answered | dt (s)\n.6\n.5\n.4\n.5\n | --columns t=1 | 0 .6 1.1 1.5 2 | intervals in s
7: frames, answered | t_s\n1\n1.1\n1.2\n1.3\n1.4\n1.5\n1.6\n1.7\n | --as times | 1 1.1 1.2 1.3 1.4 1.5 1.6 1.7 | times
7: seven equal steps | t_s,y\n1,9\n1.1,9\n1.2,7\n1.3,8\n1.4,3\n1.5,5\n1.6,6\n |  | 1 1.1 1.2 1.3 1.4 1.5 1.6 | times
Audition | Name\tStart\tType\nMarker 1\t0:00.400\tCue\nMarker 2\t0:01.000\tCue\nMarker 3\t0:01.510\tCue\n |  | 0.4 1 1.51 | as clock
)x";

TEST(ForeignTable, IsReadByWhatItProves) {
  for (const std::vector<std::string>& c : cases_of(kRead)) {
    SCOPED_TRACE(c[0]);
    ASSERT_EQ(c.size(), 5U);
    expect_read(c[1], options_of(c[2]), c[3], c[4]);
  }
}

/// Text | options | words of the question | the options of each reading, and what is then read: "-" where that asks
/// again or is nothing sensible, "speeds" where samples_from_foreign reads it.
constexpr const char* kAsked = R"x(
1: one or two | 0,4\n1,0\n1,51\n |  | line 1: 0,4 is one number or several | --as times | 0.4 1 1.51 | --as intervals | - | --as heights | - | --columns t=1 | -
1: with a unit | 400,5\n1000,5\n1510,5\n | --unit ms | one number | --as times --unit ms | .4005 1.0005 1.5105 | --as intervals --unit ms | - | --unit ms --columns t=1 | .4 1 1.51
1: a clock time | 0:00,4\n0:01,0\n0:01,51\n |  | one number | --as times | 0.4 1 1.51 | --as intervals | - | --as heights | - | --columns t=1 | -
1: commas and blanks | 400, 1000, 1510\n |  | in which unit | --unit ms | 0.4 1 1.51
3: two columns | A (s),B (s)\n.4,.1\n1,.6\n1.51,1\n |  | 2 columns are of a time | --columns t=A (s) | .4 1 1.51 | --columns t=B (s) | .1 .6 1 | --as times --columns t=A (s),t=B (s) | .4 1 1.51, .1 .6 1
3: of one name | t_s,t_s\n.4,.1\n1,.6\n1.51,1\n |  | 2 columns | --columns t=1 | .4 1 1.51 | --columns t=2 | .1 .6 1 | --as times --columns t=1,t=2 | .4 1 1.51, .1 .6 1
3: drops told | A (s),B (s),n\n.4,.1,1\n1,.6,1\n1.51,1,2\n | --columns drop=n | 2 columns | --columns t=A (s),drop=n | .4 1, 1.51 | --columns t=B (s),drop=n | .1 .6, 1
3: time and height | Time (s);y (m)\n0.4;1\n1;1\n1.51;1\n |  | another measured quantity | --columns t=Time (s) | 0.4 1 1.51 | --as heights --columns h=y (m) | -
3: no unit | Time\n0.40\n1.00\n1.51\n |  | no title has a unit | --as times --unit s --columns t=Time | 0.4 1 1.51
3: two without | t,e\n600,1\n510,2\n433.5,4\n |  | no title has a unit | --as intervals --unit ms --columns t=t | 0 0.6 1.11 1.5435 | --as heights --unit mm --columns h=t | -
3: coefficients | v,e\n1.2,.85\n1,.85\n.8,.86\n |  | no title has a unit | --columns v=v,eps=e | speeds | --as intervals --unit s --columns t=v | - | --as heights --unit m --columns h=v | -
3: no whole unit | t (10^-3 s)\n0.40\n1.00\n1.51\n |  | no title has a unit | --as times --unit s --columns t=t (10^-3 s) | 0.4 1 1.51
3: another quantity | v (m/s),x\n0.4,1\n1,3\n1.51,4\n |  | no column is a time: column 'v (m/s)'
3: two columns of which none is below the other | vor;nach\n4,01;2,72\n2,74;1,92\n1,83;1,9\n |  | no title has a unit | --as intervals --unit s --columns t=vor | 0 4.01 6.75 8.58 | --as intervals --unit s --columns t=nach | - | --as heights --unit m --columns h=nach | -
3: speeds | avant,après\n4.01,2.72\n4.74,2.92\n1.83,1.2\n |  | no title has a unit | --columns v_in=avant,v_out=après | speeds | --as intervals --unit s --columns t=avant | - | --as intervals --unit s --columns t=après | -
3: heights or speeds | n,a,b\n1,.66,.8\n2,.81,1\n3,.5,.6\n |  | no title has a unit | --columns v_in=b,v_out=a | speeds | --unit m --columns h0=b,h=a | - | --as intervals --unit s --columns t=a | -
3: a path | t,x,y\n0,.1,1\n.033,.1,.9\n.067,.2,.7\n.1,.2,.4\n.133,.3,.2\n.167,.3,.4\n.2,.4,.5\n.233,.4,.6\n |  | column 't' is equally spaced, as the frames of a video
3: a path with units | t (s),y (m)\n0,1\n.033,.9\n.067,.7\n.1,.4\n.133,.2\n.167,.4\n.2,.5\n.233,.6\n |  | column 't (s)' is equally spaced | --as times --columns t=t (s) | 0 .033 .067 .1 .133 .167 .2 .233
3: positions | y\n1\n.9\n.7\n.4\n.2\n.4\n.5\n.6\n |  | column 'y' goes up and down, as the path of a video does
4: falling | 0.6\n0.51\n0.4335\n |  | do not rise | --as intervals --unit s | 0 0.6 1.11 1.5435 | --as heights --unit m | -
4: falling, titled | Time (ms)\n600\n510\n433.5\n |  | do not rise | --as intervals | 0 0.6 1.11 1.5435 | --as times | -
4: two impacts, then three | Time (s)\n0.4\n1\n0.4\n1\n1.51\n |  | do not rise | --as intervals | - | --as times | 0.4 1, 0.4 1 1.51
4: in a drop | drop;Time (s)\n1;.4\n1;1\n1;1.51\n1;.4\n1;1\n1;1.51\n |  | do not rise | --as intervals | - | --as times | -
4: a falling row | 600;510;433,5\n |  | do not rise | --as intervals --unit ms | 0 0.6 1.11 1.5435 | --as heights --unit mm | -
4: dt that rises | dt (s)\n0.4\n1\n1.51\n |  | their title says intervals | --as intervals | - | --as times | 0.4 1 1.51
5: no speeds of balls | 400\n1000\n1510\n |  | which no ball has | --unit ms | 0.4 1 1.51
5: nor by the title | Time (s)\n400\n1000\n1500\n |  | intervals of 550 s in the median | --unit ms | 0.4 1 1.5
5: clock times of no ball | at\n1:00:00\n1:00:07\n1:00:14\n |  | intervals of 7 s in the median | --unit s | 3600 3607 3614
5: two columns | -7 0.40\n-3 1.00\n-5 1.51\n |  | which column | --columns v_in=1,v_out=2 | speeds | --as times --unit s --columns t=2 | 0.4 1 1.51
6: blocks | trial,Time (s)\n1,.4\n1,1\n2,1.51\n2,1.9\n |  | 'trial' changes where no new drop is seen | --columns t=Time (s),drop=trial | .4 1, 1.51 1.9 | --columns t=Time (s) | .4 1 1.51 1.9
6: told the unit | Drop,t (s)\n1,400\n1,1000\n2,1510\n2,1900\n | --as times --unit ms | 'Drop' changes | --as times --unit ms --columns t=t (s),drop=Drop | .4 1, 1.51 1.9 | --as times --unit ms --columns t=t (s) | .4 1 1.51 1.9
6: beside a blank line | n,Time (s)\n1,.4\n1,1\n2,1.51\n2,1.9\n\n3,3\n3,4\n |  | 'n' changes | --columns t=Time (s),drop=n | .4 1, 1.51 1.9, 3 4 | --columns t=Time (s) | .4 1 1.51 1.9, 3 4
6: two columns drop | drop;drop;t_s\n1;1;.4\n1;2;1\n2;1;1.51\n |  | several columns are called drop
6: a drop in each row | Drop;t1 (s);t2 (s);t3 (s)\n1;.4;1;1.51\n2;.1;.6;1\n |  | 3 columns | --columns t=t1 (s) | - | --columns t=t2 (s) | - | --columns t=t3 (s) | - | --as times | .4 1 1.51, .1 .6 1
6: a drop of heights in each row | 100, 81, 66, 53\n100, 80, 65\n100, 82, 67, 54\n |  | which column | --as intervals --unit ms --columns t=2 | - | --as intervals --unit ms --columns t=3 | - | --as intervals --unit ms | 0 .1 .181 .247 .3, 0 .1 .18 .245, 0 .1 .182 .249 .303 | --as heights --unit cm | - | --as heights --unit mm | -
6: rows with their numbers | 1 600 510 434\n2 600 500\n |  | which column | --as intervals --unit ms --columns t=2,t=3,t=4 | 0 .6 1.11 1.544, 0 .6 1.1 | --as heights --unit mm --columns h=2,h=3,h=4 | -
6: rows below titles | trial;h0;h1;h2\nA;100;81;66\nB;100;80;\n |  | no title has a unit | --as intervals --unit ms --columns t=h0,t=h1,t=h2 | 0 .1 .181 .247, 0 .1 .18 | --as heights --unit cm --columns h=h0,h=h1,h=h2 | - | --as heights --unit mm --columns h=h0,h=h1,h=h2 | -
6: rows without titles | .4,1,1.51\n.1,.6,1.0\n |  | which column | --as times --unit s | .4 1 1.51, .1 .6 1
7: a mean without a word | dt (s)\n.6\n.5\n.4\n.5\n |  | line 5: the last number is the mean | --as intervals --columns t=dt (s) | 0 .6 1.1 1.5 2
7: a word in a row | t (s),note\n.4,\n1,\n1.51,catch\n |  | 'note' tells some rows from others: 'catch' | --columns t=t (s) | .4 1 1.51
7: rows of two kinds | t (s);valid\n.4;TRUE\n1;TRUE\n1.51;FALSE\n1.9;TRUE\n |  | 'valid' tells some rows | --columns t=t (s) | .4 1 1.51 1.9
7: falls from several heights | height,t (s)\n.2,.20\n.4,.28\n.6,.34\n |  | 'height' rises or falls beside the times | --columns t=t (s) | .2 .28 .34
7: a mean | n;Time (s)\n1;0.4\n2;1\n3;1.51\nMean;2\n |  | line 5 begins with 'Mean'
7: a mean as a drop | drop;Time (s)\n1;0.4\n1;1\n1;1.51\nMean;2\n |  | line 5 begins with 'Mean'
7: frames | t_s,y\n0,9\n.1,9\n.2,8\n.3,7\n.4,6\n.5,5\n.6,4\n.7,3\n |  | equally spaced | --as times | 0 .1 .2 .3 .4 .5 .6 .7
7: frames alone | t_s\n0\n0.033\n0.067\n0.1\n0.133\n0.167\n0.2\n0.233\n |  | frames of a video | --as times | 0 .033 .067 .1 .133 .167 .2 .233
Audition | Name\tStart\tDuration\nMarker 1\t0:00.400\t0:00.000\nMarker 2\t0:01.000\t0:00.000\n |  | 2 columns | --columns t=Start | 0.4 1 | --columns t=Duration | -
Tracker | #multi:\nmass_A\nt\tx\ty\n0.400\t0.1\t0.0\n1.000\t0.1\t0.0\n1.510\t0.1\t0.0\n |  | no title has a unit | --as times --unit s --columns t=t | 0.4 1 1.51
Raven | Selection\tBegin Time (s)\tEnd Time (s)\n1\t0.4\t0.5\n2\t1\t1.1\n3\t1.51\t1.6\n |  | 2 columns | --columns t=Begin Time (s) | .4 1 1.51 | --columns t=End Time (s) | .5 1.1 1.6 | --as times --columns t=Begin Time (s),t=End Time (s) | .4 1 1.51, .5 1.1 1.6
phyphox stopwatch | "Start (s)","Stop 1 (s)","Stop 2 (s)"\n4.0E-1,1.0E0,1.51E0\n |  | 3 columns | --as times | 0.4 1 1.51
phyphox collision | "Bounce 0 (s)"\t"Height 0 (m)"\t"Bounce 1 (s)"\n4,0E-1\t4,4E-1\t1,0E0\n |  | 2 columns | --columns t=Bounce 0 (s) | 0.4 | --columns t=Bounce 1 (s) | 1
)x";

TEST(ForeignTable, AsksForWhatItDoesNotProve) {
  for (const std::vector<std::string>& c : cases_of(kAsked)) {
    SCOPED_TRACE(c[0]);
    ASSERT_GE(c.size(), 4U);
    const auto asked = question_of([&] { read(c[1], options_of(c[2])); });
    if (!asked) {
      ADD_FAILURE() << error_of(c[1], options_of(c[2]));
      continue;
    }
    EXPECT_THAT(asked->question(), HasSubstr(c[3]));
    EXPECT_EQ(2 * asked->readings().size() + 4, c.size()) << asked->what();
    for (std::size_t k = 0; k < asked->readings().size() && 2 * k + 5 < c.size(); ++k) {
      SCOPED_TRACE(c[2 * k + 4]);
      const ForeignOptions &found = asked->readings()[k].options, expected = options_of(c[2 * k + 4]);
      EXPECT_EQ(command_line_of(found), command_line_of(expected));
      EXPECT_THAT(asked->what(), HasSubstr(command_line_of(expected)));
      if (c[2 * k + 5] == "speeds")
        EXPECT_FALSE(samples(c[1], found.columns).empty());
      else if (c[2 * k + 5] != "-")
        expect_read(c[1], found, c[2 * k + 5], "");
    }
  }
}

TEST(ForeignTable, ShowsItsColumnsWithAQuestion) {
  const auto asked = question_of([] { read("A (s);B (s);note\n0.4;0.1;a\n1;;b\n1.51;1;c\n1.9;2;d\n"); });
  ASSERT_TRUE(asked);
  ASSERT_EQ(asked->columns().size(), 3U);
  EXPECT_EQ(asked->columns()[0].title, "A (s)");
  EXPECT_EQ(asked->columns()[0].first_cells, "0.4  1  1.51");
  EXPECT_EQ(asked->columns()[2].title, "note");
  EXPECT_EQ(asked->columns()[2].first_cells, "a  b  c");
}

/// Text | options | words of the error.
constexpr const char* kErrors = R"x(
nothing |  |  | is empty
no number | once upon a time\nthere was\n |  | line 2: there was: no line holds numbers
a comment below | Time (s)\n0.4\n1\n# late\n1.51\n |  | line 4, column 'Time (s)': '# late' is not a number
two decimal signs | Time (s);n\n0.4;1\n1,0;2\n1.51;3\n |  | line 2, column 'Time (s)': '0.4' is not a number
another separator | Time (s)\n0.4;1\n |  | has 2 titles, and the rows have fewer cells
a cell below no title | Time (s),,\n0.4,,\n1,51,,\n |  | line 3 has 2 cells, and the titles are 1
more cells than titles | n,Time (s)\n1,0,4\n2,1,0\n |  | line 2 has 3 cells, and the titles are 2
no format | 1 0.4\n2 1.0\n3\n |  | line 1: 1 0.4: not every line has the same number of cells
units beside numbers | 0.4 s, 1, 1.51\n | --as times | line 1: '0.4 s': write the numbers alone
a number with a unit for a title | 1 m\n.81\n.66\n | --as heights --unit m | line 1: '1 m': write the numbers alone
units below each other | 1 m\n.81 m\n | --as heights --unit m | line 2: '.81 m': write the numbers alone
one height | 1\n | --as heights --unit m | one height; two are needed
numbers for titles | drop;1;2\n0.4;0.5;0.6\n |  | not every line has the same number of cells, all of them numbers
a gap | n;Time (s)\n0;0.4\n1;1\n2;\n3;1.51\n |  | line 4, column 'Time (s)': the cell is empty
a gap after a blank line | Time (s)\n0.4\n1\n\n""\n1.51\n""\n1.9\n |  | line 7, column 'Time (s)': the cell is empty
a gap in a row | 0.4;1;;1.51\n |  | line 1, column 3: the cell is empty
a time twice | Time (s)\n0.4\n1\n1.0\n1.51\n |  | line 4: the time of the row before it stands again
no interval | dt (s)\n0.6\n0\n0.4\n |  | line 3: an interval of 0
a drop again | drop;Time (s)\n1;0.4\n2;1\n1;1.51\n |  | line 4: drop '1' comes again
a column of units | t (s),unit\n10,ms\n12,ms\n13.7,ms\n |  | line 4, column 'unit': 'ms' beside a number in s; write all numbers in one unit
two units | a (s),b (ms)\n.4,400\n | --columns t=1,t=2 | have two units; write one
a unit in a cell | n;Time (s)\n1;0.4\n2;1.0 s\n |  | '1.0 s' is not a number; write the numbers alone
units in cells | n;Time\n1;0.4 s\n2;1.0 s\n |  | line 2, column 'Time': '0.4 s' is not a number; write the numbers alone
two of that name | a,a\n0.1,0.2\n | --columns t=a | has no column 'a' (found: column 1, column 2)
no such column | a,b\n0.1,0.2\n | --columns t=when | has no column 'when' (found: column 'a', column 'b')
a clock time among numbers | t (ms)\n58000\n59000\n1:00.0\n |  | line 4, column 't (ms)': '1:00.0' is a clock time
samples | drop,impact,v_mps,eps\n0,0,1,0.8\n |  | (bouncelab fit takes it)
a drop not in its order | drop;t_s\n1;0.4\n1;1\n1;.5\n | --as times | line 4, column t_s: times must increase within a drop
)x";

TEST(ForeignTable, NamesThePlaceOfAnError) {
  for (const std::vector<std::string>& c : cases_of(kErrors)) {
    ASSERT_EQ(c.size(), 4U) << c[0];
    EXPECT_THAT(error_of(c[1], options_of(c[2])), HasSubstr(c[3])) << c[0];
  }
  for (const char* cell : {"03. Feb", "#VALUE!", "#REF!", "0:00:01;12", "1,000.0", "later", "NaN", "1.0 s", "0:61.0",
                           "2026-02-30T10:00:00", "0x10", "1e999"})
    EXPECT_THAT(error_of(std::string("n\tTime (s)\n1\t0.4\n2\t") + cell + "\n3\t1.51\n"),
                HasSubstr(std::string("line 3, column 'Time (s)': '") + cell + "' is not a number"));
  EXPECT_THAT(test::refusal<InvalidArgument>([] {
                read("a\n1\n", {"auto", "auto", "when"});
              }),
              HasSubstr("KEY=COLUMN"));
}

/// Seconds, metres or m/s per unit | titles.
constexpr const char* kTitles = R"x(
1 | Time (s) | t [s] | time / s | Time/s | t_s | Run 1 - Time (s) | (s) | Zeit (sec) | y (m) | v (m/s) | v / m/s | v_mps | t, s | temps en s
1e-3 | t (ms) | time_ms | v (mm/s)
1e-6 | t (us) | t [µs] | t / μs | t_us
60 | t (min)
1e-9 | t (ns)
1e-2 | y (cm) | y, cm | y（cm） | y en cm | v / cm/s | t (cs)
0.0254 | y (in) | v (in/s)
0.3048 | y [ft] | v (ft/s)
0.44704 | v (mph)
0.2777777777777778 | v (km/h)
0 | T^2 (s^2) | 1/T (1/s) | f (Hz) | Time (10^-3 s) | Time (x0.1 s) | Time (1/100 s) | s | m/s | Time | time (S) | v_in
0 | t_min | t, min | height, in | Zeit (Sekunden) | time s | t (ds) | S1 | (t) | t () | log time | t (s) of A | dt
)x";

TEST(ForeignTable, ATitlesUnitIsWholeOrNone) {
  for (const std::vector<std::string>& c : cases_of(kTitles))
    for (std::size_t k = 1; k < c.size(); ++k) {
      const auto unit = unit_of_title(c[k]);
      EXPECT_EQ(unit ? unit->si : 0.0, number_of(c[0], '.').value().value) << c[k];
      const int dimension = c[k].front() == 'y' ? 1 : c[k].front() == 'v' ? 2 : 0;
      EXPECT_EQ(unit ? static_cast<int>(unit->dimension) : dimension, dimension) << c[k];
    }
}

TEST(ForeignTable, IsTheSameInEveryEncoding) {
  const std::string text = "Zeit (\xC2\xB5s);Notiz\n400000,5;\xC2\xB5\n1000000;\n1510000;\n1943500;\n";
  const Drops expected = read(text).drops;
  std::string latin;
  for (const char c : text)
    if (c != '\xC2') latin += c;
  EXPECT_EQ(read(latin).drops, expected);
  EXPECT_EQ(read("\xEF\xBB\xBF" + text).drops, expected);
  for (const bool is_big_endian : {false, true})
    for (const bool with_mark : {false, true}) {
      std::string utf16 = !with_mark ? "" : is_big_endian ? "\xFE\xFF" : "\xFF\xFE";
      for (const char c : latin) utf16 += is_big_endian ? std::string{'\0', c} : std::string{c, '\0'};
      EXPECT_EQ(read(utf16).drops, expected) << is_big_endian << with_mark;
    }
}

TEST(ForeignTable, CarriesTheRoundingOfItsNumbers) {
  // hundredths of a second: the error of a number rounded so is 10 ms/sqrt(12)
  for (const Onset& onset : read("Time (s)\n0.40\n1.00\n1.51\n1.94\n").onsets)
    EXPECT_NEAR(onset.sigma_t_s.value_or(0.0), 0.01 / std::sqrt(12.0), 1e-12);
  EXPECT_NEAR(read("t_ms\n400\n1000\n1510\n1943\n").onsets[0].sigma_t_s.value_or(0.0), 0.001 / std::sqrt(12.0), 1e-12);
  // frames of a video, 60 a second
  const Onsets frames = read("Time (s)\n0.400000\n1.000000\n1.516667\n1.950000\n2.316667\n").onsets;
  EXPECT_NEAR(frames[0].sigma_t_s.value_or(0.0), 1.0 / 60.0 / std::sqrt(12.0), 1e-4);
}

TEST(ForeignTable, OfSpeedsAndCoefficientsIsFoundByOurTitlesOrTold) {
  const RestitutionSamples ours = samples("drop;impact;v_mps;eps\n0;1;1,2;0,800\n1;3;1,0;\n1;4;0,9;0,850\n");
  ASSERT_EQ(ours.size(), 2U);
  EXPECT_EQ(ours[1].drop, 1);
  EXPECT_EQ(ours[1].impact, 4);
  EXPECT_NEAR(ours[1].eps, 0.85, 1e-12);
  EXPECT_NEAR(ours[1].sigma_eps.value_or(0.0), 0.001 / std::sqrt(12.0), 1e-12);  // of its three decimals
  EXPECT_EQ(samples("drop;v_mps;eps\nfirst;1,2;0,8\nsecond;1,0;0,8\n").size(), 2U);
  EXPECT_EQ(samples("a\tb\n0.9\t1.2\n0.8\t1.0\n", "eps=a,v=2")[1].v_mps, 1.0);
  for (const std::vector<std::string>& c :
       cases_of("v (m/s) | 2\nv [cm/s] | .02\nv_mps | 2\nv (km/h) | 0.5555555555556\nv | 2"))
    EXPECT_NEAR(samples(c[0] + ";e\n2;0.8\n1;0.8\n", "v=1,eps=e")[0].v_mps, number_of(c[1], '.').value().value, 1e-12);
  const std::string table = "v (cm/s);e\n120;0.85\n98;0.85\n";
  const auto asked = question_of([&] { samples(table); });
  ASSERT_TRUE(asked);
  ASSERT_EQ(asked->readings().size(), 1U);
  EXPECT_NEAR(samples(table, asked->readings()[0].options.columns)[0].v_mps, 1.2, 1e-12);
  const auto error = [](const std::string& text, const std::string& columns) {
    return test::refusal<FileError>([&] { samples(text, columns); });
  };
  EXPECT_THAT(error("v;e\n1.2;89\n1.0;90\n0.8;91\n", "v=v,eps=e"), HasSubstr("per cent"));
  EXPECT_THAT(error("t (s);e\n1.2;.8\n", "v=1,eps=e"), HasSubstr("is no speed"));
  EXPECT_THAT(error("v;e\n1.2;.8\n1;x\n", "v=v,eps=e"), HasSubstr("line 3, column 'e': 'x'"));
  EXPECT_THAT(error("drop,impact,t_s,v_mps,v_after_mps,eps_macro\n0,0,.1,1.3,1.2,.9\n", ""),
              HasSubstr("impacts, no coefficients of restitution; make them first: bouncelab restitution x"));
  EXPECT_TRUE(question_of([&] { samples("n;v_mps;eps\n1;1.2;.8\n2;1;.8\nmean;1.1;.8\n"); }));
}

}  // namespace
}  // namespace bouncelab
