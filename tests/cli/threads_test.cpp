// SPDX-License-Identifier: GPL-3.0-or-later
// --threads is what the program uses: its threads are counted from outside while it works.
#include <cstdlib>

#include "program.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::cli_test {
namespace {

class Threads : public ProgramTest {
 protected:
  /// Most threads that the program was seen with.
  int most_threads(const std::string& arguments) const {
    const Result result = shell("\"$B\" " + arguments +
                                " >/dev/null & p=$!; most=0; while kill -0 $p 2>/dev/null; do set -- /proc/$p/task/*; "
                                "[ $# -gt $most ] && most=$#; sleep 0.001; done; wait $p && echo $most");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return std::atoi(result.out.c_str());
  }
};

TEST_F(Threads, AreAsManyAsAskedFor) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << "sanitizers start threads of their own";
  // works for some tenths of a second, a hundred times as long as the counting sleeps
  const std::string command = "simulate --drops 200 --impacts 95 --asperities 100000 --out i.csv --force --threads ";
  EXPECT_EQ(most_threads(command + "1"), 1);
  const int n = most_threads(command + "3");
  EXPECT_TRUE(n == 2 || n == 3) << n;
}

}  // namespace
}  // namespace bouncelab::cli_test
