// SPDX-License-Identifier: GPL-3.0-or-later
/// Names of files that break what is not careful with them.

#include "bouncelab/core/table.hpp"
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

/// For the shell, whatever is in it.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

class Names : public ProgramTest {
 protected:
  void expect_whole_way(const std::string& name, const std::string& in_table) const {
    SCOPED_TRACE(testing::PrintToString(name));
    write(name, float_wav(bouncing(12), 44100));
    const Result detected = run("detect --force --out o.csv -- " + quoted("./" + name));
    ASSERT_EQ(detected.exit_code, 0) << detected.err;
    const Result samples = run("restitution --force o.csv --out s.csv");
    ASSERT_EQ(samples.exit_code, 0) << samples.err;
    const Table back = read_csv(folder_ / "s.csv", {{"recording", ColumnType::text}, {"t_s"}});
    EXPECT_EQ(back.n_rows(), 10U);
    EXPECT_EQ(back.texts("recording")->front(), in_table);
  }
};

TEST_F(Names, WithLineBreaksQuotesAndEscapeSequencesGoThroughEveryTable) {
  for (const std::string& name :
       std::vector<std::string>{"new\nline.wav", "car\rriage.wav", "a, \"b\" .wav", "\x1b[31mred.wav", " blank.wav",
                                std::string(240, 'n') + ".wav"})
    expect_whole_way(name, "./" + name);
}

TEST_F(Names, ReachTheTerminalEscapedAndCut) {
  const Result absent =
      run("detect " + quoted("no\x1b[2J\nsuch\xFF" + std::string(3000, 'x') + ".wav") + " --out o.csv");
  expect_one_line_error(absent, 3, {"no\\x1b[2J\\nsuch\\xff", "xxx.wav"});
  EXPECT_LT(absent.err.size(), 1000U);
  EXPECT_EQ(absent.err.find('\x1b'), std::string::npos);
  write("a.csv", "t_s\n1\n2\n\x1b[31m" + std::string(500'000, 'x') + "\n");
  const Result cell = run("restitution a.csv --out s.csv");
  expect_one_line_error(cell, 3, {"line 4, column 't_s': '\\x1b[31mxxx"});
  EXPECT_LT(cell.err.size(), 1000U);
}

TEST_F(Names, ThatLookLikeAScriptOrAnEscapeSequenceAreShownAsTheyAre) {
  write("<!--<script>.wav", float_wav(bouncing(20), 44100));
  const Result result = run("analyze '<!--<script>.wav' --out 'o\x1b[31mred'");
  ASSERT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, testing::HasSubstr("o\\x1b[31mred/report.html"));
  EXPECT_EQ(result.out.find('\x1b'), std::string::npos);
  const std::string html = content("o\x1b[31mred/report.html");
  EXPECT_EQ(html.find("<!--<script>"), std::string::npos) << "the page's own script would be swallowed";
  EXPECT_NE(html.find("\\u003c!--\\u003cscript>.wav"), std::string::npos);
  const std::string begin = "<script type=\"application/json\" id=\"data\">";
  const std::size_t at = html.find(begin) + begin.size();
  const std::string data = html.substr(at, html.find("</script>", at) - at);
  EXPECT_EQ(data.find('<'), std::string::npos);
  EXPECT_EQ(Json(data)["wave"]["recording"], "<!--<script>.wav");
}

}  // namespace
}  // namespace bouncelab::cli_test
