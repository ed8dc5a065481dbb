// SPDX-License-Identifier: GPL-3.0-or-later
#include <sstream>

#include "options/commands.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Usage = ProgramTest;

TEST(Help, OfEveryCommandIsLegibleAndHasAnExample) {
  const std::string all = cli::help_of_all();
  for (const cli::Command& named : cli::all_commands()) {
    SCOPED_TRACE(named.name);
    EXPECT_THAT(all, testing::HasSubstr("\n  " + named.name + " "));
    const std::string help = cli::help_of(named, true);
    EXPECT_THAT(help, testing::AllOf(testing::HasSubstr("Example"), testing::HasSubstr("--seed"),
                                     testing::Not(testing::HasSubstr("->{")), testing::Not(testing::HasSubstr("=[]"))));
    std::istringstream lines(help);
    // examples are whole lines to be copied
    for (std::string line; std::getline(lines, line) && line.rfind("Example", 0) != 0;)
      EXPECT_LE(line.size(), 100u) << line;
  }
}

TEST_F(Usage, HelpHasChoicesRangesDefaultsAndColumns) {
  const std::string simulate = run("simulate --help").out, synthesize = run("help synthesize").out;
  for (const char* part :
       {"--contact {paper,frictionless,coulomb,stronge}", "Gravity [m/s^2] (0.001 to 1000; default 9.81)", "--out FILE",
        "Columns of the impacts:", "\n  v_contact_mps ", "Normal approach speed of the point of contact", "\n  x_m"})
    EXPECT_THAT(simulate, testing::HasSubstr(part));
  for (const char* part : {"Columns of the truth, a row for each impact", "`recording`", "\n  sigma_t_s ",
                           "Cramér-Rao bound", "\n  travel_time_s "})
    EXPECT_THAT(synthesize, testing::HasSubstr(part));
  const Result nothing = run("");
  EXPECT_EQ(nothing.exit_code, 0);
  EXPECT_EQ(nothing.out, run("help").out);
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

TEST_F(Usage, FailuresAreSaidInJsonToo) {
  for (const char* line : {"fit none.csv --out f.json --json", "fit --json --ouy f.json", "none --json"}) {
    const Result result = run(line);
    const auto j = Json(result.out);
    EXPECT_EQ(j["exit_code"], result.exit_code) << line;
    EXPECT_EQ(j["error"].text() + "\n", result.err) << line;
  }
  // where there is a summary it has both keys beside its own
  write("s.csv", "v_mps,eps\n0.5,nan\n0.4,nan\n");
  const Result result = run("fit s.csv --out f.json --json --goodness-replicates 0");
  const auto j = Json(result.out);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(j["exit_code"], 1);
  EXPECT_THAT(result.err, testing::HasSubstr(j["error"].text()));
  EXPECT_TRUE(j.contains("constants"));
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

}  // namespace
}  // namespace bouncelab::cli_test
