// SPDX-License-Identifier: GPL-3.0-or-later
// --threads is what the program uses: its threads are counted from outside while it works.
#include <algorithm>

#include "program.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::cli_test {
namespace {

class Threads : public ProgramTest {
 protected:
  /// Most threads that the program was seen with.
  int most_threads(const std::string& arguments) const {
    const std::string line = "cd '" + folder_.path().string() + "' && { '" + test::kProgram + "' " + arguments +
                             " >/dev/null 2>err </dev/null & } && p=$! && most=0 && "
                             "while kill -0 $p 2>/dev/null; do set -- /proc/$p/task/*; "
                             "[ $# -gt $most ] && most=$#; sleep 0.001; done; wait $p && echo $most >most";
    EXPECT_EQ(std::system(line.c_str()), 0) << content_of(folder_ / "err");
    return std::atoi(content_of(folder_ / "most").c_str());
  }
};

TEST_F(Threads, AreAsManyAsAskedForInEveryCommandThatComputesLong) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << "sanitizers start threads of their own";
  ASSERT_EQ(run("simulate --drops 40 --impacts 95 --asperities 100000 --out i.csv").exit_code, 0);
  std::string samples = "drop,impact,v_mps,eps,sigma_eps\n";
  for (int k = 0; k < 20000; ++k)
    samples += std::to_string(k / 95) + "," + std::to_string(k % 95) + "," + std::to_string(0.2 + 6e-5 * k) + "," +
               std::to_string(0.98 - 1e-5 * ((k * 7919) % 101)) + ",1e-4\n";
  write("s.csv", samples);
  // each works for some tenths of a second, a hundred times as long as the counting sleeps
  for (const std::string command : {"simulate --drops 200 --impacts 95 --asperities 100000 --out i2.csv",
                                    "synthesize i.csv --rate 48000 --out a.wav", "detect a.wav --out o.csv",
                                    "fit s.csv --out f.json --bootstrap 20", "calibrate --samples 20000 --seeds 2"}) {
    EXPECT_EQ(most_threads(command + " --force --threads 1"), 1) << command;
    const int n = most_threads(command + " --force --threads 3");
    EXPECT_GE(n, 2) << command;
    EXPECT_LE(n, 3) << command;
  }
}

// ten segments of a thread, with impacts at their ends too
TEST_F(Threads, DoNotChangeTheOnsetsOfALongRecording) {
  ASSERT_EQ(run("simulate --drops 8 --impacts 80 --asperities 2000 --out i.csv").exit_code, 0);
  ASSERT_EQ(run("synthesize i.csv --rate 16000 --max-mode 7000 --out a.wav").exit_code, 0);
  ASSERT_EQ(run("detect a.wav --threads 1 --out one.csv").exit_code, 0);
  ASSERT_EQ(run("detect a.wav --threads 3 --out three.csv").exit_code, 0);
  const std::string one = content_of(folder_ / "one.csv");
  EXPECT_GT(std::count(one.begin(), one.end(), '\n'), 600);
  EXPECT_EQ(one, content_of(folder_ / "three.csv"));
}

}  // namespace
}  // namespace bouncelab::cli_test
