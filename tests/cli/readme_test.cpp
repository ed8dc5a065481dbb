// SPDX-License-Identifier: GPL-3.0-or-later
// README.md shows an answer, and a picture of it: they are those of the program as it is.
#include <sstream>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Readme = ProgramTest;

TEST_F(Readme, ShowsTheAnswerThatTheProgramGives) {
  const std::string readme = content_of(fs::path(test::kSamples).parent_path() / "README.md");
  const auto [exit_code, out, err] = run("analyze '" + (fs::path(test::kSamples) / "clean.flac").string() +
                                         "' --ball steel:6mm --plate glass --out o");
  ASSERT_EQ(exit_code, 0) << err;
  std::istringstream lines(out.substr(0, out.find("Report: ")));
  std::string line, answer;
  while (std::getline(lines, line)) {
    if (answer.empty()) answer = line;
    EXPECT_THAT(readme, testing::HasSubstr("    " + line + "\n")) << "put this line into the example of README.md";
  }
  // the page says the same in fewer words
  const std::string numbers = answer.substr(0, answer.find(" m/s"));
  EXPECT_THAT(readme, testing::HasSubstr("![The page with samples/clean.flac: " + numbers))
      << "docs/page.png shows another answer: tools/web/build && tools/web/pictures";
}

}  // namespace
}  // namespace bouncelab::cli_test
