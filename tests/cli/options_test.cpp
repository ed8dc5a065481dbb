// SPDX-License-Identifier: GPL-3.0-or-later
/// How the values of options are read: of all options in this process, and by the program.
#include <algorithm>
#include <cmath>
#include <map>

#include "bouncelab/core/error.hpp"
#include "options/commands.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

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
                                               "",
                                               "constant:1e-300",
                                               "series:A2=1e300",
                                               std::string(3000, '9'),
                                               "a\nb\x1b[31m"};
  return values;
}

/// The values in force of what need not be given, as they would be typed.
std::map<std::string, std::string> state_of(const std::vector<cli::Option>& options) {
  std::map<std::string, std::string> texts;
  for (const cli::Option& option : options)
    if (!option.member->is_required) texts[option_name(*option.member)] = default_text(*option.member, option.object);
  return texts;
}

/// With what else has to be there: names of files, which are not looked at here.
std::vector<std::string> line_with(const std::vector<cli::Option>& options, const std::string& name,
                                   const std::string& value) {
  // of "$VALUE", which is not set, nothing is left
  std::vector<std::string> line =
      value.empty() ? std::vector{"--" + name, value} : std::vector{"--" + name + "=" + value};
  std::vector<std::string> positional;
  for (const cli::Option& option : options)
    if (option.member->is_required && option.member->is_positional)
      positional.push_back(cli::value_name(*option.member).starts_with('{') ? "bash" : "x");
    else if (option.member->is_required && option_name(*option.member) != name)
      line.push_back("--" + option_name(*option.member) + "=x");
  line.emplace_back("--");
  line.insert(line.end(), positional.begin(), positional.end());
  return line;
}

void expect_in_range(const Member& member, const Value& value) {
  const auto in_range = [&](double x) { EXPECT_TRUE(std::isfinite(x) && x >= member.least && x <= member.greatest); };
  if (const auto* real = std::get_if<double>(&value)) in_range(*real);
  if (const auto* integer = std::get_if<std::int64_t>(&value)) in_range(static_cast<double>(*integer));
  if (const auto* reals = std::get_if<std::vector<double>>(&value))
    std::for_each(reals->begin(), reals->end(), in_range);
  const auto* text = std::get_if<std::string>(&value);
  const std::string form = cli::value_name(member);
  if (text != nullptr && form.starts_with('{')) {
    EXPECT_THAT(form, testing::HasSubstr(*text));
  }
}

/// Either the value is in force and all others are as they were, or one line says what is wrong with which option.
void expect_taken_or_refused(const cli::Command& command, const std::string& name, const std::string& value) {
  SCOPED_TRACE(command.name + " --" + name + "=" + value.substr(0, 100));
  cli::CommonOptions common;
  const std::vector<cli::Section> sections = all_sections(command, common);
  const std::vector<cli::Option> options = options_of(sections);
  const Member& member = *option_named(sections, name)->member;
  auto before = state_of(options);
  try {
    cli::set_options(sections, line_with(options, name, value));
    EXPECT_NE(value, "");
    auto after = state_of(options);
    if (member.kind != Member::Kind::flag && !member.is_required) {
      expect_in_range(member, value_from_text(member, value));
      const std::string& in_force = after.at(name);  // of what is not known as it is typed
      EXPECT_TRUE(in_force == text_of(value_from_text(member, value)) || in_force == value) << in_force;
    }
    before.erase(name);
    after.erase(name);
    EXPECT_EQ(after, before);
  } catch (const cli::WrongUsage& error) {
    const std::string message = error.what();
    EXPECT_THAT(message, testing::HasSubstr("--" + name));
    EXPECT_EQ(message.find_first_of("\n\x1b"), std::string::npos) << message;
    EXPECT_LT(message.size(), 1200U);
    EXPECT_EQ(state_of(options), before);
    if (!value.empty()) {
      EXPECT_THROW(value_from_text(member, value), InvalidArgument) << message;
    }
  }
}

TEST(NastyValues, OfEveryOptionAreInRangeOrRefusedInOneLine) {
  std::size_t n_options = 0;
  const std::vector<cli::Command> commands = cli::all_commands();
  for (std::size_t k = 0; k < commands.size(); ++k) {
    cli::CommonOptions common;
    for (const cli::Option& option : options_of(all_sections(commands[k], common))) {
      if (option.member->is_positional) continue;
      ++n_options;
      // a command of its own for each value: it holds what was set
      for (const std::string& value : nasty_values())
        if (!value.empty() || option.member->kind != Member::Kind::flag)
          expect_taken_or_refused(cli::all_commands()[k], option_name(*option.member), value);
    }
  }
  EXPECT_GT(n_options, 190U);
}

/// An option more, described as CONTRIBUTING's example.
struct Tries {
  int least_tries = 3;
};
Description members_of(const Tries*) {
  static constexpr Member all[]{member<&Tries::least_tries>("least_tries", "Fewer are left out").within(3, 1e6)};
  return all;
}

TEST(AddedOption, OfOneLineIsInHelpCommandLineConfigurationAndProvenance) {
  const fs::path root = fs::path(test::kSamples).parent_path();
  const std::string line = R"(min_impacts", "Drops of fewer impacts are left out").within(3, 1'000'000))";
  EXPECT_THAT(content_of(root / "CONTRIBUTING.md"), testing::HasSubstr(line));
  EXPECT_THAT(content_of(root / "acoustic/detection/src/detect.cpp"), testing::HasSubstr(line));

  std::vector<cli::Command> commands = cli::all_commands();
  const auto detect = std::find_if(commands.begin(), commands.end(), [](const auto& c) { return c.name == "detect"; });
  Tries added;
  detect->sections.push_back(options::section_of(added));
  EXPECT_THAT(help_of(*detect, false),
              testing::ContainsRegex("--least-tries INT +Fewer are left out \\(3 to 1000000;"));
  const cli::Given given = cli::set_options(detect->sections, {"x.wav", "--out=o.csv", "--least-tries=7"});
  EXPECT_EQ(added.least_tries, 7);
  EXPECT_EQ(cli::parameters_of(detect->sections, given).back().values, std::vector<std::string>{"7"});
  const auto configured = [&](const char* text) { return cli::config_options(text, "c.toml", *detect, commands); };
  EXPECT_EQ(configured("[detect]\nleast_tries = 9").at(0).values, std::vector<std::string>{"9"});
}

class Options : public ProgramTest {
 protected:
  /// Simulates into a.csv; the table without provenance.
  std::string simulated(const std::string& options) const {
    const Result result = run("simulate --asperities 100 --out a.csv --force --quiet " + options);
    EXPECT_EQ(result.exit_code, 0) << options << ": " << result.err;
    return content("a.csv");
  }
};

TEST_F(Options, InRangeButOfNoUseGetAnAnswerInWords) {
  ASSERT_EQ(run("simulate --height 0.01 --drops 1 --impacts 8 --asperities 20 --out i.csv").exit_code, 0);
  ASSERT_EQ(
      run("synthesize i.csv --out r.wav --truth t.csv --rate 8000 --max-mode 2000 --lead-in 0.1 --pause 0.1").exit_code,
      0);
  ASSERT_EQ(run("restitution t.csv --out s.csv --quiet").exit_code, 0);
  const std::string brief = " --drops 1 --impacts 8 --asperities 20";
  for (const std::string& line : std::vector<std::string>{
           "simulate --out o.csv --height=1e-6" + brief, "simulate --out o.csv --law=series:A2=1e300" + brief,
           "simulate --out o.csv --radius-law=constant:1e-300" + brief, "synthesize i.csv --out o.wav --peak=0",
           "synthesize i.csv --out o.wav --snr-db=-1e300", "detect r.wav --out o.csv --gravity=1e300",
           "restitution t.csv --out o.csv --drop-height=1e-300",
           "fit s.csv --out o.json --goodness-replicates 0 --window-width=4.9e-324",
           "roughness s.csv --goodness-replicates 0 --ball=radius=1e-300", "convert t.csv --to o.txt --unit=nan",
           "analyze r.wav --out o --goodness-replicates 0 --drop-height=1e-300"}) {
    SCOPED_TRACE(line);
    const Result result = shell("timeout 60 \"$B\" " + line + " --force --quiet");
    EXPECT_TRUE(result.exit_code >= 0 && result.exit_code <= 3) << result.exit_code << ": " << result.err;
    EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("unexpected error")));
    if (result.exit_code >= 2) expect_one_line_error(result, result.exit_code, {"bouncelab"});
  }
}

TEST_F(Options, AreReadAsDecimalNumbersOfAllTheirBitsAndTheLastOfSeveralCounts) {
  const std::string ten = simulated("--drops 10 --impacts 3 --seed 8 --height 0.2");
  EXPECT_EQ(simulated("--drops 9 --drops 010 --impacts 003 --seed 08 --height 0.1 --height 0.2"), ten);
  const std::string meta = content("a.csv.meta.json");
  for (const char* in_force : {"\"drops\": \"10\"", "\"height\": \"0.2\"", "\"spin\": \"0,0,0\""})
    EXPECT_THAT(meta, testing::HasSubstr(in_force));
  EXPECT_NE(simulated("--drops 10 --impacts 3 --seed 8 --height 0.1,0.2"), ten);
  EXPECT_NE(simulated("--drops 1 --impacts 3 --seed 18446744073709551615"),
            simulated("--drops 1 --impacts 3 --seed 18446744073709551614"));
}

TEST_F(Options, ThatAreWrongEndTheProgramWithOneLine) {
  const std::string simulate = "simulate --asperities 100 --out a.csv ";
  for (const auto& [line, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {simulate + "--drops 0x10", {"--drops", "'0x10'", "decimal integer from 1 to 1000000000"}},
           {simulate + "--seed -1", {"--seed", "'-1'", "0 to 18446744073709551615"}},
           {simulate + "--height 0.1,0.2,0.3", {"--height", "'0.1,0.2,0.3'", "1 or 2", "LO[,HI]"}},
           {simulate + "--ball steel:1e-300m", {"--ball", "'1e-300m'", "from 2 um to 2 m"}},
           {simulate + "--radius-law potato", {"radius law", "potato"}},
           {simulate + "--contact '\x1b[31mred'", {"--contact", "\\x1b[31mred"}},
           {"detect \"\" --out o.csv", {"is empty"}},
           {"fit s.csv --out f.json --nodes=1e300", {"--nodes", "'1e300'", "to 1000"}},
           {"synthesize i.csv --out r.wav --channel nan,0", {"--channel", "'nan,0'"}}})
    expect_refused(line, 2, words);
}

}  // namespace
}  // namespace bouncelab::cli_test
