// SPDX-License-Identifier: GPL-3.0-or-later
/// Every stage gives the same bytes on any number of threads, and the numbers that it gave when this was written.
#include <cmath>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

/// How many rows a table has and what the values of one column add up to.
struct Golden {
  std::string column;
  std::size_t n_rows;
  double sum;
};

struct Stage {
  std::string arguments, output;
  std::vector<Golden> numbers;
};

// A change of results changes the numbers: put in what the failing test prints, and say in the commit why.
const std::vector<Stage> kStages{
    {"simulate --drops 2 --impacts 40 --asperities 5000 --out impacts.csv",
     "impacts.csv",
     {{"t_s", 80, 322.2668507578967}, {"eps_macro", 80, 78.10284892243077}}},
    {"simulate --drops 2 --impacts 25 --asperities 2000 --drag --contact coulomb --tilt 0.02 --law viscoelastic:0.02 "
     "--radius-law lognormal:1e-3,0.4 --out other.csv",
     "other.csv",
     {{"t_s", 50, 138.56049087793926}, {"eps_macro", 50, 48.784192306116509}}},
    {"simulate --drops 2 --impacts 25 --asperities 2000 --contact stronge --mu 0.02 --contact-patch --spin 30,20,0 "
     "--out patch.csv",
     "patch.csv",
     {{"t_s", 50, 141.08373947807647}, {"eps_macro", 50, 48.80931517120792}}},
    {"synthesize impacts.csv --rate 24000 --out sound.wav --truth truth.csv", "sound.wav", {}},
    {"", "truth.csv", {{"t_s", 80, 677.6191616191272}, {"sigma_t_s", 80, 6.3460035458311176e-06}}},
    {"synthesize other.csv --rate 24000 --hard rough --out hard.wav", "hard.wav", {}},
    {"synthesize other.csv --rate 24000 --each-drop --out each.flac", "each.0001.flac", {}},
    {"synthesize other.csv --rate 96000 --out fine.wav", "fine.wav", {}},
    {"detect sound.wav --out onsets.csv", "onsets.csv", {{"t_s", 80, 677.61535461800088}}},
    {"restitution onsets.csv --ball steel:6mm --plate glass --out samples.csv",
     "samples.csv",
     {{"eps", 76, 74.209310830700616}}},
    {"fit samples.csv --goodness-replicates 3 --out fit.json --table law.csv", "fit.json", {}},
    {"", "law.csv", {{"eps", 13, 12.690399813873153}}},
    {"restitution other.csv --out samples2.csv", "samples2.csv", {}},
    {"fit samples.csv --method memory --out memory.json", "memory.json", {}},
    {"compare samples.csv samples2.csv --out compared", "compared/comparison.json", {}},
    {"analyze sound.wav --ball steel:6mm --plate glass --out analyzed", "analyzed/fit.json", {}},
    {"loop --preset quick --drops 2 --impacts 40 --asperities 2000 --out loop", "loop/fit.json", {}},
};

class SameBytes : public ProgramTest {
 protected:
  void run_stage(const Stage& stage, int n_threads) const {
    if (stage.arguments.empty()) return;
    const Result result = run(stage.arguments + " --quiet --force --threads " + std::to_string(n_threads));
    // 1: the few samples do not identify the constants
    ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 1) << stage.arguments << "\n" << result.err;
  }

  void expect_numbers(const Stage& stage) const {
    for (const Golden& golden : stage.numbers) {
      const Table table = read_csv(folder_ / stage.output, {{golden.column}});
      double sum = 0.0;
      for (const double value : *table.reals(golden.column)) sum += value;
      EXPECT_EQ(table.n_rows(), golden.n_rows) << stage.output;
      // what is promised between processors and compilers
      EXPECT_NEAR(sum, golden.sum, 1e-9 * std::abs(golden.sum)) << stage.output << " " << golden.column;
    }
  }
};

TEST_F(SameBytes, AndNumbersOfEveryStageOnAnyNumberOfThreads) {
  std::vector<std::string> bytes;
  for (const Stage& stage : kStages) {
    run_stage(stage, 1);
    expect_numbers(stage);
    bytes.push_back(content_of(folder_ / stage.output));
  }
  for (const int n_threads : {2, 7})
    for (std::size_t k = 0; k < kStages.size(); ++k) {
      run_stage(kStages[k], n_threads);
      EXPECT_EQ(content_of(folder_ / kStages[k].output), bytes[k]) << kStages[k].output << " " << n_threads;
    }
}

TEST_F(SameBytes, InAnyTimeZoneAndLanguage) {
  ASSERT_EQ(run("simulate --drops 2 --impacts 12 --asperities 99 --out i.csv").exit_code, 0);
  std::string first;
  // where de_DE is not installed the language is that of C
  for (const std::string where : {"LC_ALL=C TZ=UTC", "LC_ALL=de_DE.UTF-8 TZ=Asia/Tokyo"}) {
    ASSERT_EQ(shell(where + " \"$B\" restitution i.csv --out s.csv --force --quiet").exit_code, 0);
    ASSERT_LE(shell(where + " \"$B\" fit s.csv --out f.json --force --quiet").exit_code, 1);
    const std::string both = content("s.csv") + content("f.json");
    if (first.empty()) first = both;
    EXPECT_TRUE(both == first) << where;
  }
}

}  // namespace
}  // namespace bouncelab::cli_test
