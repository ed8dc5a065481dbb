// SPDX-License-Identifier: GPL-3.0-or-later
/// A run that is asked to stop, and two in one folder; what a stopped one leaves: tests/faults.
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
  // it looks between two fits, each of which takes minutes
  const Result result = shell(
      "{ \"$B\" calibrate --samples 3000000 --seeds 2 & } ; p=$!; sleep 1; kill -TERM $p; sleep 0.5; kill -TERM $p; "
      "wait $p");
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
    const Result result = shell(
        "{ \"$B\" " + std::string(kLong) +
        " & } ; p=$!; until test -s out/.bouncelab.lock; do sleep 0.01; done; "
        "echo $p; \"$B\" " +
        second + "; s=$?; test -s out/.bouncelab.lock || s=99; kill -9 $p; wait $p 2>/dev/null; rm -r out; exit $s");
    expect_one_line_error(result, 3, {"out", "process " + result.out.substr(0, result.out.find('\n'))});
  }
}

}  // namespace
}  // namespace bouncelab::cli_test
