// SPDX-License-Identifier: GPL-3.0-or-later
// Samples as numbers instead of sound, and sound through pipes.
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "program.hpp"
#include "support/bouncing_sound.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

class NumbersAndPipes : public ProgramTest {
 protected:
  void SetUp() override {
    test::BouncingSound ball;
    ball.rate_hz = 44100.0;
    ball.n_impacts = 12;
    sound_ = test::render(ball);
    write("s.wav", float_wav(sound_, 44100));
    ASSERT_EQ(run("detect s.wav --out s.csv").exit_code, 0);
  }
  /// The table of onsets with another recording's name.
  std::string onsets(const std::string& recording) const {
    std::string table = content("s.csv");
    for (std::size_t at = 0; (at = table.find("s.wav", at)) != std::string::npos;) table.replace(at, 5, recording);
    return table;
  }
  std::vector<float> sound_;
};

TEST_F(NumbersAndPipes, ATableOfSamplesGivesWhatTheSoundGives) {
  std::string with_times = "Time (ms);Recording (a.u.)\n", alone;
  for (std::size_t k = 0; k < sound_.size(); ++k) {
    std::array<char, 64> row{};
    std::snprintf(row.data(), row.size(), "%.9f;%.9g", static_cast<double>(k) / 44.1, static_cast<double>(sound_[k]));
    with_times += std::string(row.data()) + "\n";
    alone += std::string(row.data()).substr(std::string(row.data()).find(';') + 1) + "\n";
  }
  write("times.csv", with_times);
  write("alone.txt", alone);
  const Result result = run("detect times.csv --out t.csv");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(content("t.csv"), onsets("times.csv"));
  ASSERT_EQ(run("detect alone.txt --rate 44100 --out a.csv").exit_code, 0);
  EXPECT_EQ(content("a.csv"), onsets("alone.txt"));
  expect_one_line_error(run("detect alone.txt --out x.csv"), 3, {"alone.txt", "--rate"});
  expect_one_line_error(run("detect times.csv --rate 44100 --out x.csv"), 2, {"times.csv", "--rate"});
  expect_one_line_error(run("detect s.wav --rate 44100 --out x.csv"), 2, {"s.wav", "--rate", "of its own"});
}

TEST_F(NumbersAndPipes, SoundGoesThroughAPipeFromSynthesisToDetection) {
  const Result result = shell(
      "\"$B\" simulate --drops 1 --impacts 10 --asperities 100 --out i.csv --quiet && "
      "\"$B\" synthesize i.csv --out - --truth t.csv --rate 44100 --hard hum | "
      "\"$B\" detect - --out - | \"$B\" restitution - --out r.csv");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(content("r.csv"), testing::HasSubstr("standard input"));
  for (const std::string& name : files()) EXPECT_NE(name.front(), '-') << name;
  expect_one_line_error(run("synthesize i.csv --out -"), 2, {"--truth"});
}

}  // namespace
}  // namespace bouncelab::cli_test
