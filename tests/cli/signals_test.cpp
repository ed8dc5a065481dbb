// SPDX-License-Identifier: GPL-3.0-or-later
/// A run that is asked to stop, and two in one folder; what a stopped one leaves: tests/faults.
#include "bouncelab/core/random.hpp"
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

class Signals : public ProgramTest {
 protected:
  /// Long enough to be stopped anywhere.
  static constexpr const char* kLong = "loop --preset paper --drops 2000 --asperities 20000 --out out --quiet";
};

TEST_F(Signals, OneThatCameTwiceAtOnceIsTheSameRequest) {
  const Result result =
      shell("{ \"$B\" " + std::string(kLong) + " & } && p=$! && sleep 1 && kill -TERM $p && kill -TERM $p && wait $p");
  EXPECT_EQ(result.exit_code, 130) << result.err;
}

TEST_F(Signals, ASecondEndsAtOnceWhatDoesNotLookAtTheFirst) {
  // stopped when the first signal has come, it has no time to look at that before the second
  std::string table = "drop,impact,v_mps,eps\n";
  Random random(1, RandomStream::test, 0);
  for (int drop = 0; drop < 8000; ++drop)
    for (int k = 0; k < 50; ++k)
      table += std::to_string(drop) + "," + std::to_string(k) + "," + std::to_string(1.3 - 0.02 * k) + "," +
               std::to_string(0.95 + 0.003 * random.normal()) + "\n";
  write("s.csv", table);
  const Result result = shell(
      "{ \"$B\" fit s.csv --out f.json --quiet & } ; p=$!; sleep 3; kill -TERM $p; sleep 0.01; kill -STOP $p; "
      "sleep 0.5; kill -TERM $p; kill -CONT $p; wait $p");
  EXPECT_EQ(result.exit_code, 128 + SIGTERM) << result.err;
}

TEST_F(Signals, WaitingForAPipeEndsWithTheFirst) {
  const Result result = shell(
      "mkfifo f; { \"$B\" restitution f --out x.csv & } ; p=$!; sleep 0.5; kill -TERM $p; wait $p; s=$?; rm f; ls -A; "
      "exit $s");
  expect_one_line_error(result, 130, {"interrupted"});
  EXPECT_EQ(result.out, "") << "something is left";
}

TEST_F(Signals, TheSecondRunInAFolderIsRefusedAlsoWithForce) {
  write("rec.wav", float_wav(bouncing(12), 44100));
  for (const std::string second :
       {"loop --preset paper --out out --force", "loop --out out", "analyze rec.wav --out out --force"}) {
    const Result result = shell("{ \"$B\" " + std::string(kLong) +
                                " & } ; p=$!; until test -d out; do sleep 0.01; done; sleep 0.1; "
                                "\"$B\" " +
                                second + "; s=$?; kill -9 $p; wait $p 2>/dev/null; rm -r out; exit $s");
    expect_one_line_error(result, 3, {"out", "another bouncelab"});
  }
}

}  // namespace
}  // namespace bouncelab::cli_test
