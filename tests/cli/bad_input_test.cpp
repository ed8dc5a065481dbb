// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

/// Every error here: one line that names the file and the place, the exit code of docs/formats.md, and not one new
/// file.
using BadInput = ProgramTest;

TEST_F(BadInput, IsNamedWithItsPlace) {
  write("empty.wav", "");
  write("notes.wav", "dropped the ball 40 times today, all from 10 cm\n");
  write("a.csv", "t_s\n0.1\nlater\n0.3\n");
  write("b.csv", "drop,t_s\n0,0.1\n0,0.3\n0,0.2\n");
  write("c.csv", "v_mps,eps\n1,high\n");
  write("d.csv", "drop,impact,t_s\n0,0,0.1\n");
  for (const auto& [arguments, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"detect nothing.wav --out o.csv", {"nothing.wav"}},
           {"analyze nothing.wav --out out", {"nothing.wav"}},
           {"detect empty.wav --out o.csv", {"empty.wav", "empty"}},
           {"detect notes.wav --out o.csv", {"notes.wav"}},
           {"restitution a.csv --out s.csv", {"a.csv", "line 3", "t_s", "later"}},
           {"restitution b.csv --out s.csv", {"b.csv", "line 4", "another drop", "--as intervals"}},
           {"fit c.csv --out f.json", {"c.csv", "line 2", "high"}},
           {"synthesize d.csv --out r.wav", {"d.csv", "line 1", "v_mps"}}})
    expect_refused(arguments, 3, words);
  write("noise.wav", float_wav(noise(3 * 44100, 0.01), 44100));
  expect_refused("detect noise.wav --out o.csv", 1, {"noise.wav"});
  expect_refused("analyze noise.wav --out out", 1, {"noise.wav"});
}

TEST_F(BadInput, OutputsThatExistOrCannotBeWritten) {
  write("i.csv", "mine");
  const std::string simulate = "simulate --drops 1 --impacts 3 --asperities 100 --out ";
  expect_refused(simulate + "i.csv", 3, {"i.csv", "--force"});
  expect_refused(simulate + "i.csv/i.csv", 3, {"i.csv/i.csv"});
  expect_refused("loop --drops 1 --asperities 100 --out i.csv/loop", 3, {"i.csv/loop"});
  write("a.wav", float_wav(bouncing(12), 44100));
  expect_refused("analyze a.wav --out i.csv", 3, {"i.csv", "cannot be made (", "--out FOLDER"});
  EXPECT_EQ(run(simulate + "i.csv --force").exit_code, 0);
  EXPECT_NE(content("i.csv"), "mine");
  EXPECT_EQ(run(simulate + "missing/folder/i.csv").exit_code, 0);
  EXPECT_EQ(content("missing/folder/i.csv"), content("i.csv"));
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

TEST_F(BadInput, OfManyRecordingsOneThatNeverEndsIsLostAndNoOther) {
  fs::copy(fs::path(test::kInputs) / "endless_chunks.wav", folder_ / "endless.wav");
  expect_refused("detect endless.wav --out o.csv", 3, {"endless.wav", "processor time", "ffmpeg"});
  write("a.wav", float_wav(bouncing(12), 44100));
  write("b.wav", float_wav(bouncing(11), 44100));
  const Result result = run("detect a.wav endless.wav b.wav --out o.csv --quiet");
  expect_one_line_error(result, 3, {"endless.wav", "processor time", "the 2 recordings that could be read"});
  const std::string onsets = content("o.csv");
  for (const std::string name : {"a.wav", "b.wav"}) EXPECT_THAT(onsets, testing::HasSubstr(name));
  EXPECT_EQ(std::count(onsets.begin(), onsets.end(), '\n'), 1 + 12 + 11);
}

TEST_F(BadInput, Hdf5AndJsonLinesAreLeftToPandas) {
  write("on.h5", "\x89HDF\r\n\x1a\n");
  for (const char* arguments : {"restitution on.h5 --out s.csv", "fit on.h5 --out f.json", "detect on.h5 --out o.csv",
                                "simulate --drops 1 --impacts 3 --asperities 100 --out on.h5 --force"})
    expect_refused(arguments, 2, {"on.h5", "HDF5", ".csv", "pandas"});
  write("o.jsonl", "{\"t_s\":0.1}\n{\"t_s\":0.2}\n");
  for (const char* arguments : {"restitution o.jsonl --out s.csv", "o.jsonl", "fit o.jsonl --out f.json"})
    expect_refused(arguments, 2, {"o.jsonl", "JSON Lines", ".csv", "pandas.read_json"});
}

TEST_F(BadInput, WhatIsNoTableIsRefusedInAShortLine) {
  write("a.csv", float_wav(bouncing(3), 44100));
  expect_refused("restitution a.csv --out s.csv", 3, {"a.csv", "is a recording", "bouncelab analyze"});
  expect_refused("fit a.csv --out f.json", 3, {"a.csv", "a table of text"});
  write("b.csv", std::string(2'000'000, ','));
  expect_refused("fit b.csv --out f.json", 3, {"b.csv", "is empty"});
}

TEST_F(BadInput, AFitOfAnEarlierVersionIsRefusedByTheReport) {
  fs::create_directory(folder_ / "r");
  write("r/fit.json", R"({"averaged":{"nodes":[]},"law":{}})");
  expect_refused("report r", 3, {"r/fit.json", "of this version", "bouncelab fit"});
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
