// SPDX-License-Identifier: GPL-3.0-or-later
/// Inputs and outputs as files of all kinds: nothing is lost, whatever names, links, pipes and devices are given.
#include <chrono>

#include "program.hpp"
#include "wav.hpp"

namespace bouncelab::cli_test {
namespace {

const char* const kOnsets = "t_s\n0.1\n0.5\n0.86\n1.184\n1.4756\n";
const char* const kImpacts = "drop,impact,t_s,v_mps,v_after_mps\n0,0,0.1,1.3,1.2\n0,1,0.34,1.2,1.1\n";

class Files : public ProgramTest {
 protected:
  Files() {
    write("on.csv", kOnsets);
    write("im.csv", kImpacts);
  }
  void expect_kept(const std::string& arguments, const std::vector<std::string>& words) const {
    expect_refused(arguments, 2, words);
  }
};

TEST_F(Files, NoOutputReplacesAnInput) {
  write("rec.wav", float_wav(bouncing(12), 44100));
  fs::create_hard_link(folder_ / "rec.wav", folder_ / "hard.wav");
  fs::create_symlink("rec.wav", folder_ / "soft.wav");
  for (const char* out : {"rec.wav", "./rec.wav", "hard.wav", "soft.wav"}) {
    expect_kept(std::string("detect rec.wav --force --out ") + out, {out, "is the input rec.wav"});
    expect_kept(std::string("detect rec.wav --force --out o.csv --labels ") + out, {out, "is the input"});
  }
  expect_kept("synthesize im.csv --out s.wav --truth im.csv --force", {"im.csv", "is the input"});
  expect_kept("restitution on.csv --out on.csv --force", {"on.csv", "is the input"});
  expect_kept("convert on.csv --to on.csv --force", {"on.csv", "is the input"});
  write("x.csv.meta.json", kOnsets);
  expect_kept("restitution x.csv.meta.json --out x.csv", {"x.csv.meta.json", "is the input"});
  write("options.toml", "drops = 1\n");
  expect_kept("simulate --config options.toml --out options.toml --force", {"options.toml", "is the input"});
  write("list.txt", "rec.wav\n");
  expect_kept("detect --list list.txt --out list.txt --force", {"list.txt", "is the input"});
  expect_kept("detect --list list.txt --out o.csv --labels list.txt --force", {"list.txt", "is the input"});
  write("law.csv", "v_mps,eps\n0.01,0.9\n5,0.8\n");
  expect_kept("simulate --law table:law.csv --out law.csv --force", {"law.csv", "is the input"});
  ASSERT_EQ(run("simulate --drops 1 --impacts 9 --asperities 99 --out sim.csv").exit_code, 0);
  expect_kept("restitution sim.csv --out sim.csv.meta.json --force", {"sim.csv.meta.json", "is the input"});
  fs::create_directory(folder_ / "out");
  write("out/onsets.csv", "rec.wav\n");
  expect_kept("analyze --list out/onsets.csv --out out --force", {"out/onsets.csv", "is the input"});
  write("out/sweep.csv", "v_mps,eps\n0.01,0.9\n5,0.8\n");
  write("sweep.toml", "law = [\"table:out/sweep.csv\", \"constant:0.9\"]\n");
  expect_kept("loop --config sweep.toml --drops 2 --impacts 8 --asperities 99 --out out --force",
              {"out/sweep.csv", "is the input"});
  fs::create_hard_link(folder_ / "rec.wav", folder_ / "out" / "wave.json");
  expect_one_line_error(run("analyze rec.wav --out out --force"), 2, {"out/wave.json", "is the input"});
}

TEST_F(Files, AProvenanceReplacesNothingOfTheUsersAndFollowsNoLink) {
  write("s.csv.meta.json", "{\"mine\": 1}");
  expect_one_line_error(run("restitution on.csv --out s.csv"), 3, {"s.csv.meta.json", "exists already"});
  EXPECT_EQ(content("s.csv.meta.json"), "{\"mine\": 1}");
  write("victim", "whole");
  fs::create_symlink("victim", folder_ / "r.csv.meta.json");
  for (const char* force : {"", " --force"})
    expect_one_line_error(run("restitution on.csv --out r.csv" + std::string(force)), 3,
                          {"r.csv.meta.json", "is a link"});
  EXPECT_EQ(content("victim"), "whole");
  // one of ours, of a table that is gone, is replaced
  ASSERT_EQ(run("restitution on.csv --out own.csv").exit_code, 0);
  fs::remove(folder_ / "own.csv");
  EXPECT_EQ(run("restitution on.csv --out own.csv").exit_code, 0);
}

TEST_F(Files, ThatNobodyNamedAreReadOnlyIfTheyAreRegular) {
  write("rec.wav", float_wav(bouncing(12), 44100));
  ASSERT_EQ(run("detect rec.wav --out o.csv --labels o.txt").exit_code, 0);
  ASSERT_EQ(run("analyze rec.wav --out report").exit_code, 0);
  fs::create_directory(folder_ / "true");
  for (const std::string make : {"mkfifo", "mkdir", "ln -s nowhere", "ln -s /dev/zero", "mkfifo pipe; ln -sr pipe"}) {
    SCOPED_TRACE(make);
    const auto expect_ends = [&](const std::string& name, const std::string& command, int exit_code) {
      const Result result = shell("rm -rf pipe " + name + "; " + make + " " + name + " && timeout 20 \"$B\" " +
                                  command + " --force; code=$?; rm -rf pipe " + name + "; exit $code");
      EXPECT_EQ(result.exit_code, exit_code) << command << result.err;
    };
    for (const std::string input : {"o.csv", "o.txt"})
      expect_ends(input + ".meta.json", "restitution " + input + " --out s.csv", 0);
    expect_ends("o.txt.onsets.csv", "convert o.txt --to o.svl", 2);  // without it the recording is not known
    expect_ends("o.txt.onsets.csv", "analyze o.txt --out of_labels", 0);
    expect_ends("rec.wav.meta.json", "analyze rec.wav --out report", 0);
    expect_ends("report/wave.json", "report report", 0);
    expect_ends("true/rec.truth.csv", "validate --recordings rec.wav --truth true --detector builtin --out v", 3);
    expect_ends("rec.wav", "convert o.csv --to c.csv", 0);  // which the marks name
    expect_ends("rec.wav", "convert o.csv --to c.svl", 3);
    write("rec.wav", float_wav(bouncing(12), 44100));
    ASSERT_EQ(run("convert o.csv --to o.txt --force").exit_code, 0);
    ASSERT_EQ(run("analyze rec.wav --out report --force").exit_code, 0);
  }
  ASSERT_EQ(shell("mkfifo n.csv.meta.json").exit_code, 0);
  expect_one_line_error(run("restitution on.csv --out n.csv --force"), 3, {"n.csv.meta.json", "is no regular file"});
}

TEST_F(Files, ProvenanceThatEntersANumberIsPrinted) {
  ASSERT_EQ(run("simulate --drops 1 --impacts 9 --asperities 99 --out sim.csv").exit_code, 0);
  const std::string provenance = content("sim.csv.meta.json");
  const std::size_t gravity = provenance.find("9.81");
  ASSERT_NE(gravity, std::string::npos);
  write("sim.csv.meta.json", std::string(provenance).replace(gravity, 4, "1.62"));
  const std::string command = "restitution sim.csv --out s.csv --force";
  EXPECT_THAT(run(command).out, testing::HasSubstr("gravity 1.62 m/s^2"));
  EXPECT_EQ(run(command).err, "");
  write("sim.csv", content("sim.csv") + "\n");
  const Result changed = run(command);
  EXPECT_THAT(changed.err, testing::HasSubstr("sim.csv.meta.json is of another content"));
  EXPECT_THAT(changed.out, testing::HasSubstr("gravity 9.81 m/s^2"));
}

TEST_F(Files, NoOutputReplacesAnotherOne) {
  expect_kept("simulate --drops 1 --impacts 3 --asperities 100 --out z.csv --write-surface z.csv --force",
              {"z.csv", "two outputs"});
  expect_kept("synthesize im.csv --out s.wav --truth ./s.wav", {"s.wav", "two outputs"});
  expect_kept("convert on.csv --to a.txt a.txt --recording r.wav", {"a.txt", "two outputs"});
}

TEST_F(Files, DevicesAndPipesAreWrittenToAndStay) {
  // without --force, not to break the machine where this fails
  EXPECT_EQ(run("restitution on.csv --out /dev/null").exit_code, 0);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  ASSERT_EQ(run("restitution on.csv --out s.csv").exit_code, 0);
  const std::string table = content("s.csv");
  for (const char* out : {"-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"}) {
    const Result result = run(std::string("restitution on.csv --out ") + out);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, table) << out;
    EXPECT_THAT(result.err, testing::HasSubstr("coefficients of restitution"));
  }
  EXPECT_EQ(run("restitution on.csv --out /dev/stderr --quiet").err, table);
  const Result fifo = shell("mkfifo f && { cat f >read & } && \"$B\" restitution on.csv --out f && wait && test -p f");
  EXPECT_EQ(fifo.exit_code, 0) << fifo.err;
  EXPECT_EQ(content("read"), table);
  EXPECT_EQ(files(), (std::vector<std::string>{"f", "im.csv", "on.csv", "read", "s.csv", "s.csv.meta.json"}));
  expect_one_line_error(run("restitution on.csv --out - --json"), 2, {"--json", "standard output"});
}

TEST_F(Files, EveryCommandReadsFromPipesAndNamesTheSumOfWhatItRead) {
  write("rec.wav", float_wav(bouncing(12), 44100));
  ASSERT_EQ(run("restitution on.csv --out s.csv").exit_code, 0);
  const std::string sum = shell("sha256sum on.csv").out.substr(0, 64);
  for (const std::string in : {"-", "/dev/stdin", "/dev/fd/0"}) {
    const Result result = shell("cat on.csv | \"$B\" restitution " + in + " --out p.csv --force");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(content("p.csv"), content("s.csv"));
    const Json input = json("p.csv.meta.json")["inputs"][0];
    EXPECT_EQ(input["sha256"], sum);
    EXPECT_EQ(input["path"], in == "-" ? "standard input" : in);
  }
  EXPECT_EQ(shell("\"$B\" restitution - --out redirected.csv <on.csv").exit_code, 0);
  EXPECT_EQ(content("redirected.csv"), content("s.csv"));
  for (const std::string command : {"detect - --out o.csv", "analyze - --out out", "detect /dev/stdin --out p.csv"}) {
    const Result result = shell("cat rec.wav | \"$B\" " + command + " --force");
    EXPECT_EQ(result.exit_code, 0) << command << result.err;
  }
  EXPECT_THAT(content("o.csv"), testing::HasSubstr("standard input"));
  EXPECT_EQ(shell("cat im.csv | \"$B\" synthesize - --out s.wav").exit_code, 0);
  EXPECT_EQ(shell("cat s.csv | \"$B\" fit - --out f.json").exit_code, run("fit s.csv --out g.json").exit_code);
  EXPECT_EQ(content("f.json"), content("g.json"));
  EXPECT_EQ(shell("cat on.csv | \"$B\" convert - --to c.txt").exit_code, 0);
}

TEST_F(Files, TheSumOfARecordingIsThatOfItsFileWhateverWasReadOfIt) {
  const auto sound = bouncing(12);
  write("short.wav", float_wav(sound, 44100));
  // more than is held whole, with something behind the samples
  auto longer = sound;
  const auto rest = noise((1 << 20) + 12345 - sound.size(), 1e-4);
  longer.insert(longer.end(), rest.begin(), rest.end());
  std::string bytes = float_wav(longer, 44100);
  bytes += "LIST";
  put<std::uint32_t>(bytes, 100000);
  write("long.wav", bytes + std::string(100000, 'x'));
  fs::copy_file(fs::path(test::kSamples) / "clean.flac", folder_ / "coded.flac");
  std::vector<std::string> names{"short.wav", "long.wav", "coded.flac"};
  // sums of files that were written to a moment ago are not kept
  for (const std::string& name : names)
    fs::last_write_time(folder_ / name, fs::last_write_time(folder_ / name) - std::chrono::hours(1));
  ASSERT_EQ(run("detect short.wav long.wav coded.flac --out o.csv --threads 2").exit_code, 0);
  const Json inputs = json("o.csv.meta.json")["inputs"];
  ASSERT_EQ(inputs.size(), names.size());
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::string sum = shell("sha256sum " + names[k]).out.substr(0, 64);
    EXPECT_EQ(inputs[k]["sha256"], sum) << names[k];
    ASSERT_EQ(run("detect " + names[k] + " --force --out one.csv").exit_code, 0);
    EXPECT_EQ(json("one.csv.meta.json")["inputs"][0]["sha256"], sum) << names[k];
  }
}

TEST_F(Files, WhatCannotBeAnInputIsRefusedInOneLine) {
  fs::create_directory(folder_ / "folder");
  for (const char* command : {"restitution folder --out x.csv", "detect folder --out x.csv", "fit folder --out f.json",
                              "synthesize folder --out x.wav", "convert folder --to x.csv"})
    expect_one_line_error(run(command), 3, {"folder"});
  expect_one_line_error(shell("timeout 60 \"$B\" fit /dev/zero --out f.json"), 3, {"/dev/zero", "device"});
  expect_one_line_error(shell("timeout 60 \"$B\" detect - --out o.csv </dev/zero"), 3, {"standard input", "device"});
  expect_one_line_error(shell("cat on.csv | \"$B\" restitution - - --out x.csv"), 2, {"standard input", "only once"});
  expect_one_line_error(shell("\"$B\" restitution - --out x.csv <&-"), 3, {"standard input"});
}

TEST_F(Files, NamesThatAreNotUtf8AreNamedInValidJson) {
  write("a\xff.wav", float_wav(bouncing(12), 44100));
  const Result result = run("detect a\xff.wav --out o\xfe.csv --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Json(result.out)["recordings"][0]["recording"], "a\xEF\xBF\xBD.wav");
  EXPECT_EQ(json("o\xfe.csv.meta.json")["inputs"][0]["path"], "a\xEF\xBF\xBD.wav");
  write("b.wav", float_wav(bouncing(13), 44100));
  EXPECT_LE(run("analyze 'a\xff.wav' b.wav --out out\xfd --diagnostics --json").exit_code, 1);
  EXPECT_EQ(json("out\xfd/summary.json")["n_onsets"], 25);
  write("fl.csv", "drop,impact,t_s,flags\n0,0,0.1,a\xff\n0,1,0.4,\n0,2,0.6,\n0,3,0.75,\n");
  EXPECT_EQ(run("restitution fl.csv --out fls.csv").exit_code, 0);
  EXPECT_LE(run("fit fls.csv --out f.json --json").exit_code, 1);
}

TEST_F(Files, ANameThatLeavesNoRoomForItsProvenanceIsRefused) {
  EXPECT_EQ(run("restitution on.csv --out " + std::string(241, 'n') + ".csv").exit_code, 0);
  for (const std::size_t n : {242U, 252U})
    expect_one_line_error(run("restitution on.csv --out " + std::string(n, 'n') + ".csv"), 3, {"nnn", "too long"});
}

TEST_F(Files, StandardOutputThatIsFullOrClosedIsAnError) {
  for (const std::string to : {"--json >/dev/full", ">/dev/full", "--json >&-", "--version >/dev/full"}) {
    const Result result = shell(
        "\"$B\" " + std::string(to.starts_with("--version") ? "" : "restitution on.csv --out x.csv --force ") + to);
    expect_one_line_error(result, 3, {"standard output"});
  }
  EXPECT_EQ(shell("\"$B\" restitution on.csv --out x.csv --force --quiet >&-").exit_code, 0);
  EXPECT_THAT(content("x.csv"), testing::StartsWith("recording,"));
  EXPECT_EQ(shell("\"$B\" restitution on.csv --out - >/dev/full").exit_code, 3);
  expect_one_line_error(shell("ulimit -f 16; \"$B\" simulate --drops 300 --asperities 100 --out big.csv"), 3,
                        {"big.csv", "writing failed", "ulimit -f"});
}

TEST_F(Files, AReaderThatHasGoneIsNoFault) {
  const Result result = shell("{ sleep 0.5; \"$B\" convert on.csv --to - other.csv; echo $? >code; } | true");
  EXPECT_EQ(result.err.find("bouncelab:"), std::string::npos) << result.err;
  EXPECT_TRUE(exists("other.csv"));
}

TEST_F(Files, EverythingThatIsReadIsInTheProvenance) {
  write("a.wav", float_wav(bouncing(12), 44100));
  write("list.txt", "a.wav\r\n");
  ASSERT_EQ(run("detect --list list.txt --out o.csv").exit_code, 0);
  EXPECT_THAT(content("o.csv.meta.json"), testing::HasSubstr("\"path\": \"a.wav\""));
  ASSERT_EQ(run("convert on.csv --to m.txt").exit_code, 0);
  ASSERT_EQ(run("convert m.txt --to back.csv").exit_code, 0);
  EXPECT_THAT(content("back.csv.meta.json"), testing::HasSubstr("\"m.txt.onsets.csv\""));
  EXPECT_LE(run("restitution m.txt --out s.csv").exit_code, 1);
  EXPECT_THAT(content("s.csv.meta.json"), testing::HasSubstr("\"m.txt.onsets.csv\""));
  write("law.csv", "v_mps,eps\n0.01,0.9\n5,0.8\n");
  write("sw.toml", "law = [\"table:law.csv\", \"constant:0.9\"]\n");
  ASSERT_LE(run("loop --config sw.toml --drops 2 --impacts 8 --asperities 99 --out sw").exit_code, 1);
  for (const char* file : {"\"path\": \"law.csv\"", "\"path\": \"sw.toml\""})
    EXPECT_THAT(content("sw/sweep.csv.meta.json"), testing::HasSubstr(file));
}

TEST_F(Files, AReportIsNotMadeOfTwoRuns) {
  write("rec.wav", float_wav(bouncing(12), 44100));
  write("other.wav", float_wav(bouncing(20), 44100));
  ASSERT_LE(run("analyze rec.wav --out a").exit_code, 1);
  ASSERT_LE(run("analyze other.wav --out b").exit_code, 1);
  EXPECT_EQ(run("report a --force").exit_code, 0);
  fs::copy_file(folder_ / "b/samples.csv", folder_ / "a/samples.csv", fs::copy_options::overwrite_existing);
  expect_one_line_error(run("report a --force"), 3, {"a/fit.json", "other samples"});
}

}  // namespace
}  // namespace bouncelab::cli_test
