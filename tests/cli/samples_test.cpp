// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"
#include "bouncelab/detection/detect.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Samples = ProgramTest;

TEST_F(Samples, ImpactsAreFoundAmongKnocksAndClicksTooAndNoneInvented) {
  const auto read = [](const fs::path& path) {
    Onsets onsets = onsets_from_table(read_csv(path, onset_columns()), path.string());
    for (Onset& onset : onsets) onset.recording.clear();  // the truth was written under another name
    return onsets;
  };
  for (const std::string name : {"clean", "hard"}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(run(std::string("detect '") + test::kSamples + "/" + name + ".flac' --out o.csv --force").exit_code, 0);
    const detection::OnsetScore score =
        detection::score_onsets(read(fs::path(test::kSamples) / (name + ".truth.csv")), read(folder_ / "o.csv"));
    const std::size_t n_most = name == "clean" ? 0 : 1;  // of 80 impacts, at .99
    EXPECT_LE(score.n_missed, n_most);
    EXPECT_LE(score.n_invented, n_most);
    // a template refers to a point inside the contact, which moves by half of (39 - 26) us of Hertz's law from the
    // first to the last impact: an rms of 2 us is left where nothing is corrected, and a fifth of a sample is 4 us
    EXPECT_LT(*score.rms_s, 4e-6);
  }
}

}  // namespace
}  // namespace bouncelab::cli_test
