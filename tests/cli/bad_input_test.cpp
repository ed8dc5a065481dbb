// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <limits>

#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

/// Every error here: one line that names the file and the place, the exit code of docs/formats.md, and not one new
/// file.
class BadInput : public ProgramTest {
 protected:
  void expect_refused(const std::string& arguments, int exit_code, const std::vector<std::string>& words) {
    const auto before = files();
    SCOPED_TRACE(arguments);
    expect_one_line_error(run(arguments), exit_code, words);
    EXPECT_EQ(files(), before) << "something half-written was left";
  }
};

TEST_F(BadInput, MissingRecording) {
  expect_refused("detect nothing.wav --out o.csv", 3, {"nothing.wav"});
  expect_refused("analyze nothing.wav --out out", 3, {"nothing.wav"});
}

TEST_F(BadInput, EmptyRecording) {
  write("empty.wav", "");
  expect_refused("detect empty.wav --out o.csv", 3, {"empty.wav", "empty"});
  expect_refused("analyze empty.wav --out out", 3, {"empty.wav"});
}

TEST_F(BadInput, RecordingThatIsNoSound) {
  write("notes.wav", "dropped the ball 40 times today, all from 10 cm\n");
  expect_refused("detect notes.wav --out o.csv", 3, {"notes.wav"});
}

TEST_F(BadInput, TruncatedRecordingIsReadUpToThereWithAWarning) {
  const std::string whole = float_wav(bouncing(12), 44100);
  write("cut.wav", whole.substr(0, whole.size() / 2));
  const Result result = run("detect cut.wav --out o.csv");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, testing::HasSubstr("warning: cut.wav: the header promises 123857 samples"));
  write("cut.wav", whole.substr(0, 30));  // within the head
  expect_refused("detect cut.wav --out p.csv", 3, {"cut.wav", "not readable as audio"});
}

TEST_F(BadInput, RecordingWithNotANumberIsNamedByPlace) {
  std::vector<float> samples = bouncing(12);
  samples[4410] = std::numeric_limits<float>::quiet_NaN();
  write("nan.wav", float_wav(samples, 44100));
  expect_refused("detect nan.wav --out o.csv", 3, {"nan.wav", "4410"});
}

TEST_F(BadInput, OnsetsWithAMissingColumnAWordOrUnsortedTimes) {
  write("a.csv", "drop,impact\n0,0\n");
  expect_refused("restitution a.csv --out s.csv", 3, {"a.csv", "line 1", "t_s"});
  write("b.csv", "t_s\n0.1\nlater\n0.3\n");
  expect_refused("restitution b.csv --out s.csv", 3, {"b.csv", "line 3", "t_s", "later"});
  write("c.csv", "drop,t_s\n0,0.1\n0,0.3\n0,0.2\n");
  expect_refused("restitution c.csv --out s.csv", 3, {"c.csv", "line 4", "another drop", "--as intervals"});
  expect_refused("restitution missing.csv --out s.csv", 3, {"missing.csv"});
}

TEST_F(BadInput, SamplesWithAMissingColumnOrAWord) {
  write("a.csv", "v_mps\n1\n");
  expect_refused("fit a.csv --out f.json", 3, {"a.csv", "'v_mps'", "--columns v=COLUMN,eps=COLUMN"});
  write("b.csv", "v_mps,eps\n1,high\n");
  expect_refused("fit b.csv --out f.json", 3, {"b.csv", "line 2", "high"});
}

TEST_F(BadInput, ImpactsWithAMissingColumnOrUnsortedTimes) {
  write("a.csv", "drop,impact,t_s\n0,0,0.1\n");
  expect_refused("synthesize a.csv --out r.wav", 3, {"a.csv", "line 1", "v_mps"});
  write("b.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.4,1.3,1.2\n0,1,0.3,1.2,1.1\n");
  expect_refused("synthesize b.csv --out r.wav", 3, {"b.csv", "line 3", "t_s"});
}

TEST_F(BadInput, OutOfRangeOptions) {
  expect_refused("simulate --asperities 0 --out i.csv", 2, {"--asperities", "0"});
  expect_refused("simulate --drops -3 --out i.csv", 2, {"--drops", "-3"});
  expect_refused("simulate --radius-law potato --out i.csv", 2, {"radius law", "potato"});
  expect_refused("restitution o.csv --gravity 0 --out s.csv", 2, {"--gravity", "0"});
}

TEST_F(BadInput, OutputThatCannotBeWritten) {
  write("file", "");
  expect_refused("simulate --drops 1 --impacts 3 --asperities 100 --out file/i.csv", 3, {"file/i.csv"});
  expect_refused("simulate --drops 1 --impacts 3 --asperities 100 --out nowhere/i.csv", 3, {"nowhere/i.csv"});
  expect_refused("loop --drops 1 --asperities 100 --out file/loop", 3, {"file/loop"});
  write("ok.wav", float_wav(bouncing(12), 44100));
  expect_refused("analyze ok.wav --out file/out", 3, {"file/out"});
}

TEST_F(BadInput, AnExistingOutputIsKeptUnlessForced) {
  write("i.csv", "mine");
  expect_refused("simulate --drops 1 --impacts 3 --asperities 100 --out i.csv", 3, {"i.csv", "--force"});
  EXPECT_EQ(content_of(folder_ / "i.csv"), "mine");
  EXPECT_EQ(run("simulate --drops 1 --impacts 3 --asperities 100 --out i.csv --force").exit_code, 0);
  EXPECT_NE(content_of(folder_ / "i.csv"), "mine");
}

TEST_F(BadInput, OfManyRecordingsOneThatNeverEndsIsLostAndNoOther) {
  fs::copy(fs::path(test::kInputs) / "endless_chunks.wav", folder_ / "endless.wav");
  expect_refused("detect endless.wav --out o.csv", 3, {"endless.wav", "processor time", "ffmpeg"});
  write("a.wav", float_wav(bouncing(12), 44100));
  write("b.wav", float_wav(bouncing(11), 44100));
  const Result result = run("detect a.wav endless.wav b.wav --out o.csv --quiet");
  expect_one_line_error(result, 3, {"endless.wav", "processor time", "the 2 recordings that could be read"});
  const std::string onsets = content_of(folder_ / "o.csv");
  for (const std::string name : {"a.wav", "b.wav"}) EXPECT_THAT(onsets, testing::HasSubstr(name));
  EXPECT_EQ(std::count(onsets.begin(), onsets.end(), '\n'), 1 + 12 + 11);
}

TEST_F(BadInput, Hdf5IsLeftToPandas) {
  write("on.h5", "\x89HDF\r\n\x1a\n");
  for (const char* arguments :
       {"restitution on.h5 --out s.csv", "fit on.h5 --out f.json", "synthesize on.h5 --out s.wav",
        "convert on.h5 --to s.csv", "simulate --surface on.h5 --out i.csv", "detect on.h5 --out o.csv",
        "simulate --drops 1 --impacts 3 --asperities 100 --out on.h5 --force"})
    expect_refused(arguments, 2, {"on.h5", "HDF5", ".csv", "pandas"});
}

TEST_F(BadInput, AStreamedFlacIsDetectedAsTheSameFileWithItsLength) {
  // as an encoder leaves it that writes to a pipe: 0 samples in the header (RFC 9639, 8.2)
  std::string flac = content_of(fs::path(test::kSamples) / "clean.flac");
  write("a.flac", flac);
  ASSERT_EQ(run("detect a.flac --out whole.csv").exit_code, 0);
  flac[21] = static_cast<char>(flac[21] & 0xF0);
  std::fill_n(flac.begin() + 22, 4, '\0');
  write("a.flac", flac);
  ASSERT_EQ(run("detect a.flac --out streamed.csv").exit_code, 0);
  EXPECT_EQ(content_of(folder_ / "streamed.csv"), content_of(folder_ / "whole.csv"));
}

TEST_F(BadInput, MarksThatTakeMemoryWithoutEnd) {
  std::string layer = "<sv><data><model name=\"a\" sampleRate=\"44100\"/>";
  for (int k = 0; k < 20000; ++k) layer += "<point   =\"1\"";
  write("q.svl", layer);
  expect_refused("convert q.svl --to x.csv", 3, {"q.svl", "not XML"});
  write("slow.svl", "<sv><model sampleRate=\"1e-300\"/><point frame=\"1\"/></sv>");
  expect_refused("convert slow.svl --to x.csv", 3, {"slow.svl", "sampleRate '1e-300'"});
}

TEST_F(BadInput, SoundWithNoBounceInventsNothing) {
  write("noise.wav", float_wav(noise(3 * 44100, 0.01), 44100));
  write("silence.wav", float_wav(std::vector<float>(3 * 44100, 0.0f), 44100));
  write("one.wav", float_wav(bouncing(1), 44100));
  for (const std::string name : {"noise", "silence", "one"}) {
    SCOPED_TRACE(name);
    expect_refused("detect " + name + ".wav --out " + name + ".csv", 1, {name + ".wav"});
    expect_refused("analyze " + name + ".wav --out out", 1, {name + ".wav"});
  }
}

TEST_F(BadInput, ANegativeStandardErrorIsNotTakenForAPositiveOne) {
  write("a.csv", "t_s,sigma_t_s\n0.1,1e-6\n0.3,-1e-6\n0.4,1e-6\n");
  expect_refused("restitution a.csv --out s.csv", 3, {"a.csv", "line 3", "sigma_t_s"});
  write("b.csv", "v_mps,eps,sigma_eps\n1,0.9,0.001\n1,0.9,-0.001\n");
  expect_refused("fit b.csv --out f.json", 3, {"b.csv", "line 3", "sigma_eps"});
}

TEST_F(BadInput, OneRowBeyondPhysicsIsNamedInsteadOfFailingTheFit) {
  write("a.csv", "v_mps,eps\n1,0.9\n1,1e308\n");
  expect_refused("fit a.csv --out f.json", 3, {"a.csv", "line 3", "eps"});
  write("b.csv", "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.1,1,0.9\n0,1,0.3,1e308,0.9\n");
  expect_refused("synthesize b.csv --out s.wav", 3, {"b.csv", "line 3", "v_mps"});
}

TEST_F(BadInput, DropsOfJsonLinesAreNotLostWhereTheFirstRowHasNone) {
  std::string rows;
  for (const char* drop : {"", ",\"drop\":0", ",\"drop\":1"})
    for (const char* t_s : {"0.1", "0.3", "0.5"}) rows += "{\"t_s\":" + std::string(t_s) + drop + "}\n";
  write("a.jsonl", rows);
  expect_refused("restitution a.jsonl --out s.csv", 3, {"a.jsonl", "line 1", "drop", "line 4"});
  write("b.jsonl", "{\"t_s\":0.1,\"drop\":18446744073709551615}\n");
  expect_refused("restitution b.jsonl --out s.csv", 3, {"b.jsonl", "line 1", "18446744073709551615"});
  write("c.jsonl", "{\"t_s\":0.1}\n\n\n{\"t_s\":0.3}\n{\"t_s\":0.2}\n");
  expect_refused("restitution c.jsonl --out s.csv", 3, {"c.jsonl", "line 5"});
}

TEST_F(BadInput, WhatIsNoTableIsRefusedInAShortLine) {
  write("a.csv", float_wav(bouncing(3), 44100));
  expect_refused("restitution a.csv --out s.csv", 3, {"a.csv", "is a recording", "bouncelab analyze"});
  expect_refused("fit a.csv --out f.json", 3, {"a.csv", "a table of text"});
  write("b.csv", std::string(2'000'000, ','));
  expect_refused("fit b.csv --out f.json", 3, {"b.csv", "is empty"});
}

TEST_F(BadInput, AResultThatIsNoneOfAFitIsRefusedByTheReport) {
  fs::create_directory(folder_ / "r");
  for (const char* text : {"[]", "{}", "null", "3"}) {
    write("r/fit.json", text);
    expect_refused("report r", 3, {"r/fit.json", "is no result of a fit"});
  }
  for (const char* text : {"{\"law\":1e400}", "{\"law\":"}) {
    write("r/fit.json", text);
    expect_refused("report r", 3, {"r/fit.json", "is not JSON"});
  }
}

}  // namespace
}  // namespace bouncelab::cli_test
