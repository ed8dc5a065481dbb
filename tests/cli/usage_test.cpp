// SPDX-License-Identifier: GPL-3.0-or-later
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Usage = ProgramTest;

TEST_F(Usage, HelpNamesEveryCommand) {
  const Result help = run("--help");
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command :
       {"loop", "analyze", "simulate", "synthesize", "detect", "convert", "restitution", "fit", "roughness", "report"})
    EXPECT_THAT(help.out, testing::HasSubstr(command));
}

TEST_F(Usage, EveryCommandHasHelpWithAnExample) {
  for (const char* command : {"loop", "analyze", "simulate", "synthesize", "detect", "convert", "restitution", "fit",
                              "roughness", "report"}) {
    const Result help = run(std::string(command) + " --help");
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_THAT(help.out, testing::HasSubstr("Example")) << command;
    EXPECT_THAT(help.out, testing::HasSubstr("--seed")) << command;
  }
}

TEST_F(Usage, NoCommandAndUnknownCommandsAndOptionsAreWrongUsage) {
  expect_one_line_error(run(""), 2, {"bouncelab"});
  expect_one_line_error(run("bounce"), 2, {"unknown command 'bounce'"});
  expect_one_line_error(run("simulate --asperites 5 --out a.csv"), 2, {"--asperites"});
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
