// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"
#include "bouncelab/detection/score.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Samples = ProgramTest;

Onsets read(const fs::path& path) {
  Onsets onsets = onsets_from_table(read_csv(path, onset_columns()), path.string());
  for (Onset& onset : onsets) onset.recording.clear();  // the truth was written under another name
  return onsets;
}

detection::OnsetScore score_of(const Result& result, const fs::path& folder, const std::string& name) {
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return detection::score_onsets(read(fs::path(test::kSamples) / (name + ".truth.csv")), read(folder / "o.csv"));
}

TEST_F(Samples, EveryImpactOfTheCleanOneIsFoundAndNoneInvented) {
  const detection::OnsetScore score =
      score_of(run(std::string("detect '") + test::kSamples + "/clean.flac' --out o.csv"), folder_, "clean");
  EXPECT_EQ(score.n_missed, 0u);
  EXPECT_EQ(score.n_invented, 0u);
  // a template refers to a point inside the contact, which moves by half of (39 - 26) us of Hertz's law from the first
  // to the last impact: an rms of 2 us is left where nothing is corrected, and a fifth of a sample is 4 us
  EXPECT_LT(*score.rms_s, 4e-6);
}

TEST_F(Samples, ImpactsOfTheHardOneAreFoundAmongKnocksAndClicks) {
  const detection::OnsetScore score =
      score_of(run(std::string("detect '") + test::kSamples + "/hard.flac' --out o.csv"), folder_, "hard");
  EXPECT_LE(score.n_missed, 1u);  // 80 impacts at .99
  EXPECT_LE(score.n_invented, 1u);
  EXPECT_LT(*score.rms_s, 4e-6);
}

}  // namespace
}  // namespace bouncelab::cli_test
