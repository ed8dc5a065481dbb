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
};

TEST_F(Synthesize, ManyDropsAndKnocksInOneRecordingAndTheTruthBeside) {
  write_drops("i.csv", 200);
  const Result result =
      run("synthesize i.csv --out r.wav --rate 8000 --max-mode 2000 --double-hits 1 --pause 2 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("\"n_impacts\": 600"));
  EXPECT_THAT(result.out, testing::HasSubstr("\"n_other_sounds\": 600"));  // a knock after each
  EXPECT_EQ(n_lines("r.truth.csv"), 601u);
  EXPECT_EQ(n_lines("r.others.csv"), 601u);
  // 0.5 s, then 200 times 0.3 s and a pause of 2 s, 3 bytes a sample
  EXPECT_NEAR(static_cast<double>(fs::file_size(folder_ / "r.wav")), (0.5 + 200 * 2.3) * 8000 * 3, 1000);
}

TEST_F(Synthesize, BadInputIsRefusedByValue) {
  write_drops("i.csv", 1);
  expect_refused("synthesize i.csv --out r.flac --rate 1000000", 2, {"FLAC", "1000000"});
  for (const std::string option : {"--reverberation", "--reverberation-time"}) {
    expect_refused("synthesize i.csv --out p.wav " + option + " 1", 2, {option + ":", "--sensor microphone"});
    EXPECT_EQ(
        run("synthesize i.csv --out " + option + ".wav --sensor microphone --rate 16000 " + option + " 1").exit_code,
        0);
  }
  EXPECT_NE(content("--reverberation.wav"), content("--reverberation-time.wav"));
  expect_refused("synthesize i.csv --out r.mp3", 2, {".mp3", ".wav"});
  expect_refused("synthesize i.csv --out r.wav --together 2 --each-drop", 2, {"together", "2"});
  expect_refused("synthesize i.csv --out r.wav --robot", 2, {"--robot", "--knocks"});
  expect_refused("fit i.csv --out r.json --bootstrap 9", 2, {"--bootstrap", "by drop"});
  write("long.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.1,1,0.9\n0,1,1e9,0.9,0.8\n");
  expect_refused("synthesize long.csv --out r.wav", 2, {"drop 0, impact 1", "no drop lasts longer"});
  write("none.csv", "drop,impact,t_s,v_mps,v_after_mps\n");
  expect_refused("synthesize none.csv --out r.wav", 2, {"no impacts"});
  write("back.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.3,1,0.9\n0,1,0.2,0.9,0.8\n");
  expect_refused("synthesize back.csv --out r.wav", 3, {"back.csv", "line 3", "t_s"});
  write("drops.csv", "drop,impact,t_s,v_mps,v_after_mps\n1,0,0.3,1,0.9\n0,0,0.4,0.9,0.8\n");
  expect_refused("synthesize drops.csv --out r.wav", 3, {"drops.csv", "line 3"});
}

TEST_F(Synthesize, APositionOffThePlateIsNamed) {
  ASSERT_EQ(run("simulate --drops 1 --impacts 60 --asperities 1000 --state --out s.csv --quiet").exit_code, 0);
  std::istringstream in(content("s.csv"));
  std::string header, first;
  std::getline(in, header);
  std::getline(in, first);
  // x_m is the tenth column: the ball is moved 20 cm aside
  std::size_t at = 0;
  for (int k = 0; k < 9; ++k) at = first.find(',', at) + 1;
  first.replace(at, first.find(',', at) - at, "0.2");
  write("away.csv", header + "\n" + first + "\n");
  expect_refused("synthesize away.csv --out r.wav", 2,
                 {"x = 0.2", "off the plate", "simulate --plate-size", "--positions drawn"});
}

TEST_F(Synthesize, EachDropFindsAllNamesFreeBeforeItWritesTheFirst) {
  write_drops("i.csv", 4);
  write("each.0002.wav", "mine");
  const std::string options = " --each-drop --rate 8000 --max-mode 2000 ";
  expect_refused("synthesize i.csv --out each.wav" + options, 3, {"each.0002.wav", "exists already"});
  write_drops("q.0001.wav", 4);
  expect_refused("synthesize q.0001.wav --out q.wav --force" + options, 2, {"q.0001.wav", "is the input"});
  expect_refused("synthesize i.csv --out r.wav --truth r.0000.wav --force" + options, 2, {"r.0000.wav", "same file"});
  write("s.0001.wav", "rate = 8000\n");
  expect_refused("synthesize i.csv --out s.wav --config s.0001.wav --force --each-drop", 2,
                 {"s.0001.wav", "is the input"});
}

}  // namespace
}  // namespace bouncelab::cli_test
