// SPDX-License-Identifier: GPL-3.0-or-later
/// Every option of every command, as --help lists them, with values that nobody means.
#include <regex>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

struct NastyCommand {
  std::string name;
  std::string line;  ///< that runs, as briefly as it can
};

const std::string kBrief = " --drops 1 --impacts 8 --asperities 20 --force --quiet";
const std::string kCoarse = " --rate 8000 --max-mode 2000 --lead-in 0.1 --pause 0.1 --force --quiet";

const std::vector<NastyCommand> kNastyCommands{
    {"simulate", "simulate --out o.csv" + kBrief},
    {"synthesize", "synthesize i.csv --out o.wav" + kCoarse},
    {"detect", "detect r.wav --out o.csv --force --quiet"},
    {"convert", "convert t.csv --to o.txt --force --quiet"},
    {"restitution", "restitution t.csv --out o.csv --force --quiet"},
    {"fit", "fit s.csv --out f.json --goodness-replicates 0 --force --quiet"},
    {"roughness", "roughness s.csv --out g.json --goodness-replicates 0 --force --quiet"},
    {"compare", "compare s.csv --out c --force --quiet"},
    {"report", "report folder --force --quiet"},
    {"calibrate", "calibrate --samples 100 --seeds 2 --quiet"},
    {"analyze", "analyze r.wav --out o --goodness-replicates 0 --force --quiet"},
    {"loop", "loop --out o" + kBrief + kCoarse},
};

void PrintTo(const NastyCommand& command, std::ostream* out) { *out << command.name; }

std::vector<std::string> option_names(const std::string& help) {
  std::vector<std::string> names;
  const std::regex option("\n  (--[a-z-]+)");
  for (std::sregex_iterator at(help.begin(), help.end(), option), end; at != end; ++at) names.push_back((*at)[1]);
  return names;
}

const std::vector<std::string>& nasty_values() {
  static const std::vector<std::string> values{"1e-300",
                                               "1e300",
                                               "4.9e-324",
                                               "0",
                                               "-0",
                                               "-1",
                                               "nan",
                                               "inf",
                                               "0x10",
                                               "1e400",
                                               "-1e300,1e300",
                                               "0,0,0,0",
                                               "18446744073709551616",
                                               "''",
                                               "constant:1e-300",
                                               "'series:A2=1e300'",
                                               std::string(3000, '9'),
                                               "'a\nb\x1b[31m'"};
  return values;
}

class NastyValues : public ProgramTest, public testing::WithParamInterface<NastyCommand> {
 protected:
  void SetUp() override {
    ASSERT_EQ(run("simulate --out i.csv --height 0.01" + kBrief).exit_code, 0);
    ASSERT_EQ(run("synthesize i.csv --out r.wav --truth t.csv" + kCoarse).exit_code, 0);
    ASSERT_EQ(run("restitution t.csv --out s.csv --quiet").exit_code, 0);
    fs::create_directory(folder_ / "folder");
    run("fit s.csv --out folder/fit.json --goodness-replicates 0 --quiet");
  }
};

TEST_P(NastyValues, OfEveryOptionGetAnAnswerInWords) {
  std::string help = run(GetParam().name + " --help").out;
  // what every command has is tried with one of them
  if (GetParam().name != "simulate") help.resize(help.find("Every command has"));
  const std::vector<std::string> names = option_names(help);
  EXPECT_FALSE(names.empty());
  for (const std::string& name : names)
    for (const std::string& value : nasty_values()) {
      SCOPED_TRACE(name + "=" + value.substr(0, 100));
      const Result result = shell("timeout 60 \"$B\" " + GetParam().line + " " + name + "=" + value);
      EXPECT_TRUE(result.exit_code >= 0 && result.exit_code <= 3) << result.exit_code << ": " << result.err;
      EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("unexpected error")));
      EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("please report")));
      EXPECT_LE(result.err.size(), 4000u);
      if (result.exit_code >= 2) {
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Of, NastyValues, testing::ValuesIn(kNastyCommands),
                         [](const auto& nasty) { return nasty.param.name; });

}  // namespace
}  // namespace bouncelab::cli_test
