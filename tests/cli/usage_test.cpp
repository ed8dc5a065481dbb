// SPDX-License-Identifier: GPL-3.0-or-later
#include <nlohmann/json.hpp>
#include <sstream>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Usage = ProgramTest;

TEST_F(Usage, HelpNamesEveryCommand) {
  const Result help = run("--help");
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command : {"loop", "analyze", "simulate", "synthesize", "detect", "convert", "restitution", "fit",
                              "roughness", "compare", "dem", "report"})
    EXPECT_THAT(help.out, testing::HasSubstr(command));
}

TEST_F(Usage, EveryCommandHasHelpWithAnExample) {
  for (const char* command : {"loop", "analyze", "simulate", "synthesize", "detect", "convert", "restitution", "fit",
                              "roughness", "compare", "dem", "report"}) {
    const Result help = run(std::string(command) + " --help");
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_THAT(help.out, testing::HasSubstr("Example")) << command;
    EXPECT_THAT(help.out, testing::HasSubstr("--seed")) << command;
  }
}

TEST_F(Usage, NoCommandAndUnknownCommandsAndOptionsAreWrongUsage) {
  expect_one_line_error(run("bounce"), 2, {"unknown command 'bounce'", "bouncelab --help"});
  expect_one_line_error(run("anlyze a.wav"), 2, {"unknown command 'anlyze'", "did you mean 'analyze'?"});
  expect_one_line_error(run("none.m4a"), 2, {"no such file or command 'none.m4a'"});
  expect_one_line_error(run("simulate --asperites 5 --out a.csv"), 2,
                        {"unknown option '--asperites'", "did you mean '--asperities'?"});
  // named before what is missing, which it was probably meant to be
  expect_one_line_error(run("detect a.wav --ouy b.csv"), 2, {"unknown option '--ouy'", "did you mean '--out'?"});
}

TEST_F(Usage, NothingAndHelpAreHelp) {
  const Result nothing = run(""), help = run("help");
  EXPECT_EQ(nothing.exit_code, 0);
  EXPECT_EQ(nothing.out, run("--help").out);
  EXPECT_EQ(help.out, nothing.out);
  EXPECT_EQ(run("help fit").out, run("fit --help").out);
}

TEST_F(Usage, HelpIsLegible) {
  for (const char* command : {"", "loop", "analyze", "simulate", "synthesize", "detect", "convert", "restitution",
                              "fit", "roughness", "compare", "dem", "report", "calibrate", "completion"}) {
    const std::string help = run(std::string(command) + " --help").out;
    EXPECT_THAT(help, testing::Not(testing::HasSubstr("->{"))) << command;
    EXPECT_THAT(help, testing::Not(testing::HasSubstr("=[]"))) << command;
    std::istringstream lines(help);
    // examples are whole lines to be copied
    for (std::string line; std::getline(lines, line) && line.rfind("Example", 0) != 0;)
      EXPECT_LE(line.size(), 100u) << line;
  }
  const std::string simulate = run("simulate --help").out;
  EXPECT_THAT(simulate, testing::HasSubstr("--contact {paper,frictionless,coulomb,stronge}"));
  EXPECT_THAT(simulate, testing::HasSubstr("Gravity [m/s^2] (0.001 to 1000; default 9.81)"));
  EXPECT_THAT(simulate, testing::HasSubstr("--out FILE"));
}

TEST_F(Usage, HelpExplainsTheColumnsOfImpactsAndTruth) {
  const std::string simulate = run("simulate --help").out;
  for (const char* part : {"Columns of the impacts:", "\n  v_contact_mps ",
                           "Normal approach speed of the point of contact", "\n  x_m, y_m, z_m "})
    EXPECT_THAT(simulate, testing::HasSubstr(part));
  const std::string synthesize = run("synthesize --help").out;
  for (const char* part : {"Columns of the truth, a row for each impact:", "\n  recording ", "\n  sigma_t_s ",
                           "Cramér-Rao bound", "\n  travel_time_s "})
    EXPECT_THAT(synthesize, testing::HasSubstr(part));
  EXPECT_THAT(synthesize, testing::Not(testing::HasSubstr("Likewise")));
}

TEST_F(Usage, FailuresAreSaidInJsonToo) {
  for (const char* line : {"fit none.csv --out f.json --json", "fit --json --ouy f.json", "none --json"}) {
    const Result result = run(line);
    const auto j = nlohmann::json::parse(result.out);
    EXPECT_EQ(j.at("exit_code"), result.exit_code) << line;
    EXPECT_EQ(j.at("error").get<std::string>() + "\n", result.err) << line;
  }
  // where there is a summary it has both keys beside its own
  write("s.csv", "v_mps,eps\n0.5,nan\n0.4,nan\n");
  const Result result = run("fit s.csv --out f.json --json --goodness-replicates 0");
  const auto j = nlohmann::json::parse(result.out);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(j.at("exit_code"), 1);
  EXPECT_THAT(result.err, testing::HasSubstr(j.at("error").get<std::string>()));
  EXPECT_TRUE(j.contains("status"));
}

TEST_F(Usage, ARecordingAloneIsAnalyzedBesideItself) {
  ASSERT_EQ(run("simulate --drops 1 --impacts 20 --asperities 1000 --out i.csv --quiet").exit_code, 0);
  fs::create_directory(folder_ / "sound");
  ASSERT_EQ(run("synthesize i.csv --out sound/drop.wav --quiet").exit_code, 0);
  const Result result = run("sound/drop.wav");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(folder_ / "sound/drop-bouncelab/report.html"));
  EXPECT_THAT(content_of(folder_ / "sound/drop-bouncelab/fit.json.meta.json"), testing::HasSubstr("drop-bouncelab"));
  // a second time its own report is replaced, and what somebody has changed is not
  EXPECT_EQ(run("sound/drop.wav --quiet").exit_code, 0);
  write("sound/drop-bouncelab/onsets.csv", "mine");
  expect_one_line_error(run("sound/drop.wav --quiet"), 3, {"drop-bouncelab", "--force"});
  EXPECT_EQ(run("sound/drop.wav --quiet --force").exit_code, 0);
}

TEST_F(Usage, CompletionOffersCommandsOptionsAndChoices) {
  ASSERT_EQ(shell("$B completion bash > c.bash").exit_code, 0);
  const auto offered = [&](const std::string& words, int n) {
    return shell("bash -c 'source ./c.bash; COMP_WORDS=(\"'\"$B\"'\" " + words + "); COMP_CWORD=" + std::to_string(n) +
                 "; _bouncelab; echo \"${COMPREPLY[@]}\"'")
        .out;
  };
  EXPECT_EQ(offered("an", 1), "analyze\n");
  EXPECT_EQ(offered("simulate --contact fr", 3), "frictionless\n");
  EXPECT_EQ(offered("simulate --contact-", 2), "--contact-patch\n");
  EXPECT_EQ(offered("fit --out --f", 3), "\n");  // of a file the shell knows more
  EXPECT_EQ(offered("fit --method m", 3), "memory\n");
  for (const char* name : {"zsh", "fish"})
    EXPECT_THAT(run(std::string("completion ") + name).out, testing::HasSubstr("completion words -- ")) << name;
  // what all scripts ask for; options of the words to complete are not the command's own
  EXPECT_THAT(run("completion words -- fit --config none.toml --meth").out, testing::HasSubstr("\n--method\t"));
  expect_one_line_error(run("completion tcsh"), 2, {"tcsh"});
}

TEST_F(Usage, OutOfRangeValuesNameOptionValueAndRange) {
  expect_one_line_error(run("simulate --asperities 0 --out a.csv"), 2, {"--asperities", "0"});
  EXPECT_TRUE(files().empty());
}

TEST_F(Usage, AConfigFileSetsOptionsAndTheCommandLineWins) {
  write("c.toml", "drops = 2\n[simulate]\nasperities = 1000\nimpacts = 3\n");
  const Result result = run("simulate --config c.toml --drops 1 --out a.csv");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string table = content_of(folder_ / "a.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 3);  // header and three impacts of one drop
}

TEST_F(Usage, UnknownKeysOfAConfigFileAreNamedByLine) {
  write("c.toml", "[simulate]\nasperites = 1000\n");
  expect_one_line_error(run("simulate --config c.toml --out a.csv"), 2, {"c.toml", "line 2", "asperites"});
  write("d.toml", "drops = \n");
  expect_one_line_error(run("simulate --config d.toml --out a.csv"), 3, {"d.toml", "line 1"});
}

}  // namespace
}  // namespace bouncelab::cli_test
