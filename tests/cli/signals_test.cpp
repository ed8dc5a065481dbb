// SPDX-License-Identifier: GPL-3.0-or-later
/// A run that is asked to stop, or killed, and two in one folder.
#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

class Signals : public ProgramTest {
 protected:
  /// Long enough to be stopped anywhere.
  static constexpr const char* kLong = "loop --preset paper --drops 2000 --asperities 20000 --out out --quiet";
};

TEST_F(Signals, EachFirstOneStopsTheWorkAndLeavesNothingHalfWritten) {
  for (const std::string signal : {"INT", "TERM", "HUP"}) {
    SCOPED_TRACE(signal);
    const Result result =
        shell("timeout --foreground --preserve-status -s " + signal +
              " 1 env --default-signal=INT,TERM,HUP \"$B\" simulate --drops 100000 --asperities 100000 "
              "--out i.csv --quiet; s=$?; ls -A; exit $s");
    EXPECT_EQ(result.out, "") << "something is left";
    expect_one_line_error(result, 130, {"interrupted"});
  }
}

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
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(result.out, "");
}

TEST_F(Signals, TheNextRunInAFolderRemovesWhatAKilledOneLeft) {
  // ten seconds of work; before it every output is tried with a hidden file that is removed again and stays empty
  ASSERT_EQ(run("simulate --drops 1000 --impacts 60 --asperities 10000 --out i.csv").exit_code, 0);
  const Result killed = shell(
      "mkdir out; { \"$B\" synthesize i.csv --out out/s.wav & } ; p=$!; "
      "until find out -name '*partial*' -size +0 2>/dev/null | grep -q partial || ! kill -0 $p; do sleep 0.01; done; "
      "kill -9 $p; wait $p; ls -A out | grep -c partial");
  ASSERT_NE(killed.out, "0\n") << "nothing was left";
  ASSERT_EQ(run("simulate --drops 1 --impacts 5 --asperities 100 --out out/i.csv").exit_code, 0);
  EXPECT_EQ(shell("ls -A out").out, "i.csv\ni.csv.meta.json\n");
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
