// SPDX-License-Identifier: GPL-3.0-or-later
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

class Synthesize : public ProgramTest {
 protected:
  /// Drops of three impacts each, 0.3 s long.
  void write_drops(const std::string& name, int n_drops) const {
    std::string table = "drop,impact,t_s,v_mps,v_after_mps\n";
    for (int drop = 0; drop < n_drops; ++drop)
      for (int k = 0; k < 3; ++k)
        table += std::to_string(drop) + "," + std::to_string(k) + "," + std::to_string(0.1 * (k + 1)) + "," +
                 std::to_string(1.0 - 0.1 * k) + "," + std::to_string(0.9 - 0.1 * k) + "\n";
    write(name, table);
  }
  std::size_t n_lines(const std::string& name) const {
    const std::string text = content_of(folder_ / name);
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
  void expect_refused(const std::string& arguments, int exit_code, const std::vector<std::string>& words) {
    const auto before = files();
    SCOPED_TRACE(arguments);
    expect_one_line_error(run("synthesize " + arguments), exit_code, words);
    EXPECT_EQ(files(), before) << "something half-written was left";
  }
};

TEST_F(Synthesize, ManyDropsWithTheRobotsCycleInOneRecordingAndTheTruthBeside) {
  write_drops("i.csv", 2000);  // more rows than are read at once
  const Result result = run("synthesize i.csv --out r.wav --rate 8000 --max-mode 2000 --robot --pause 2 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("\"n_impacts\": 6000"));
  EXPECT_THAT(result.out, testing::HasSubstr("\"n_other_sounds\": 8000"));  // release, fan, pick-up, motor
  EXPECT_EQ(n_lines("r.truth.csv"), 6001u);
  EXPECT_EQ(n_lines("r.others.csv"), 8001u);
  // 0.5 s, then 2000 times 0.3 s and a pause of 2 s, 3 bytes a sample
  EXPECT_NEAR(static_cast<double>(fs::file_size(folder_ / "r.wav")), (0.5 + 2000 * 2.3) * 8000 * 3, 1000);
}

TEST_F(Synthesize, SameBytesForAnyNumberOfThreadsInOneFileAndInOneADrop) {
  write_drops("i.csv", 7);
  for (const std::string threads : {"1", "2", "5"}) {
    const std::string options = " --hard rough --threads " + threads + " --quiet";
    ASSERT_EQ(run("synthesize i.csv --out all" + threads + ".wav" + options).exit_code, 0);
    ASSERT_EQ(run("synthesize i.csv --each-drop --out each" + threads + ".flac" + options).exit_code, 0);
    EXPECT_EQ(content_of(folder_ / ("all" + threads + ".wav")), content_of(folder_ / "all1.wav"));
    EXPECT_EQ(n_lines("all" + threads + ".truth.csv"), 22u);
    for (int drop = 0; drop < 7; ++drop) {
      const std::string ending = ".000" + std::to_string(drop);
      ASSERT_TRUE(fs::exists(folder_ / ("each" + threads + ending + ".flac")));
      EXPECT_TRUE(fs::exists(folder_ / ("each" + threads + ending + ".others.csv")));
      EXPECT_EQ(content_of(folder_ / ("each" + threads + ending + ".flac")),
                content_of(folder_ / ("each1" + ending + ".flac")));
    }
  }
}

TEST_F(Synthesize, CtrlCLeavesNoHalfFile) {
  write_drops("i.csv", 2000);  // 87 minutes at 1 MHz: not done in a second
  const std::string line = "cd '" + folder_.path().string() +
                           "' && timeout --preserve-status -s INT 1 '" + test::kProgram +
                           "' synthesize i.csv --out r.w64 --rate 1000000 >/dev/null 2>&1 </dev/null";
  const int status = std::system(line.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(files(), std::vector<std::string>{"i.csv"});
}

TEST_F(Synthesize, ARateTooLowForTheModesSaysWhichAreLeftOut) {
  write_drops("i.csv", 1);
  const Result result = run("synthesize i.csv --out r.wav --rate 16000");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, testing::HasSubstr("modes from 8"));
  EXPECT_THAT(result.err, testing::HasSubstr("a rate of 16000 Hz cannot hold them"));
}

TEST_F(Synthesize, WithoutTheBallTheTruthIsAHeader) {
  write_drops("i.csv", 2);
  const std::string options = " --rate 16000 --knocks 1 --quiet";
  ASSERT_EQ(run("synthesize i.csv --out w.wav" + options).exit_code, 0);
  ASSERT_EQ(run("synthesize i.csv --out o.wav --without-ball" + options).exit_code, 0);
  EXPECT_EQ(n_lines("w.truth.csv"), 7u);
  EXPECT_EQ(n_lines("o.truth.csv"), 1u);
  EXPECT_EQ(content_of(folder_ / "o.others.csv"), content_of(folder_ / "w.others.csv"));
  EXPECT_EQ(fs::file_size(folder_ / "o.wav"), fs::file_size(folder_ / "w.wav"));
}

TEST_F(Synthesize, TheRoomOfAMicrophoneIsChosen) {
  write_drops("i.csv", 1);
  const auto bytes_with = [&](const std::string& options) {
    const Result result = run("synthesize i.csv --out r.wav --rate 16000 --force --quiet " + options);
    EXPECT_EQ(result.exit_code, 0) << options << ": " << result.err;
    return content_of(folder_ / "r.wav");
  };
  const std::string preset = bytes_with("--sensor microphone");
  EXPECT_EQ(bytes_with("--sensor microphone --reverberation -15 --reverberation-time 0.25"), preset);
  EXPECT_EQ(bytes_with("--hard microphone --reverberation -15"), preset);
  EXPECT_NE(bytes_with("--sensor microphone --reverberation 0"), preset);
  EXPECT_NE(bytes_with("--sensor microphone --reverberation-time 1"), preset);
  expect_refused("i.csv --out p.wav --reverberation 0", 2, {"--reverberation:", "--sensor microphone"});
  expect_refused("i.csv --out p.wav --reverberation-time 1", 2, {"--reverberation-time:", "--sensor microphone"});
}

TEST_F(Synthesize, BadInputIsRefusedByValue) {
  write_drops("i.csv", 1);
  expect_refused("i.csv --out r.wav --snr-db nan", 2, {"snr", "nan"});
  expect_refused("i.csv --out r.wav --rate 4000", 2, {"--rate", "4000"});
  expect_refused("i.csv --out r.flac --rate 1000000", 2, {"FLAC", "1000000"});
  expect_refused("i.csv --out r.mp3", 2, {".mp3", ".wav"});
  expect_refused("i.csv --out r.wav --channel 0.2,0", 2, {"sensor x_m", "0.2"});
  write("long.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.1,1,0.9\n0,1,1e9,0.9,0.8\n");
  expect_refused("long.csv --out r.wav", 2, {"drop 0, impact 1", "no drop lasts longer"});
  expect_refused("i.csv --out r.wav --channel 0.1", 2, {"--channel", "'0.1'"});
  expect_refused("i.csv --out r.wav --together 9", 2, {"--together", "1 to 8"});
  expect_refused("i.csv --out r.wav --together 2 --each-drop", 2, {"together", "2"});
  expect_refused("i.csv --out r.wav --robot", 2, {"pause_s", "1"});
  write("none.csv", "drop,impact,t_s,v_mps,v_after_mps\n");
  expect_refused("none.csv --out r.wav", 2, {"no impacts"});
  write("back.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.3,1,0.9\n0,1,0.2,0.9,0.8\n");
  expect_refused("back.csv --out r.wav", 3, {"back.csv", "line 3", "t_s"});
  write("drops.csv", "drop,impact,t_s,v_mps,v_after_mps\n1,0,0.3,1,0.9\n0,0,0.4,0.9,0.8\n");
  expect_refused("drops.csv --out r.wav", 3, {"drops.csv", "line 3"});
  expect_refused("i.csv --out nowhere/r.wav", 3, {"nowhere"});
}

TEST_F(Synthesize, APositionOffThePlateIsNamed) {
  ASSERT_EQ(run("simulate --drops 1 --impacts 60 --asperities 1000 --state --out s.csv --quiet").exit_code, 0);
  std::istringstream in(content_of(folder_ / "s.csv"));
  std::string header, first;
  std::getline(in, header);
  std::getline(in, first);
  // x_m is the tenth column: the ball is moved 20 cm aside
  std::size_t at = 0;
  for (int k = 0; k < 9; ++k) at = first.find(',', at) + 1;
  first.replace(at, first.find(',', at) - at, "0.2");
  write("away.csv", header + "\n" + first + "\n");
  expect_refused("away.csv --out r.wav", 2, {"x = 0.2", "off the plate", "simulate --plate-size", "--positions drawn"});
}

TEST_F(Synthesize, EachDropFindsAllNamesFreeBeforeItWritesTheFirst) {
  write_drops("i.csv", 4);
  write("each.0002.wav", "mine");
  const std::string options = " --each-drop --rate 8000 --max-mode 2000 ";
  expect_refused("i.csv --out each.wav" + options, 3, {"each.0002.wav", "exists already"});
  write_drops("q.0001.wav", 4);
  expect_refused("q.0001.wav --out q.wav --force" + options, 2, {"q.0001.wav", "is the input"});
  expect_refused("i.csv --out r.wav --truth r.0000.wav --force" + options, 2, {"r.0000.wav", "same file"});
  write("s.0001.wav", "rate = 8000\n");
  expect_refused("i.csv --out s.wav --config s.0001.wav --force --each-drop", 2, {"s.0001.wav", "is the input"});
}

}  // namespace
}  // namespace bouncelab::cli_test
