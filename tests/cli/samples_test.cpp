// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"
#include "bouncelab/loop/detector_score.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

using Samples = ProgramTest;

TEST_F(Samples, ImpactsAreFoundAmongKnocksAndClicksTooAndNoneInvented) {
  for (const std::string name : {"clean", "hard"}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(run(std::string("detect '") + test::kSamples + "/" + name + ".flac' --out o.csv --force").exit_code, 0);
    const fs::path truth = fs::path(test::kSamples) / (name + ".truth.csv");
    const loop::DetectorScore score =
        loop::score_detector(loop::true_times_from_table(read_csv(truth, loop::true_time_columns()), "truth"),
                             onsets_from_table(read_csv(folder_ / "o.csv", onset_columns()), "o.csv"), 0.0, 0.0);
    const auto& [n_true, n_marked, n_found] = score.agreement[loop::kJitterTolerance];
    const std::size_t n_most = name == "clean" ? 0 : 1;  // of 80 impacts, at .99
    EXPECT_LE(n_true - n_found, n_most);
    EXPECT_LE(n_marked - n_found, n_most);
    // a template refers to a point inside the contact, which moves by half of (39 - 26) us of Hertz's law from the
    // first to the last impact: an rms of 2 us is left where nothing is corrected, and a fifth of a sample is 4 us
    EXPECT_LT(*score.jitter_s, 4e-6);
  }
}

}  // namespace
}  // namespace bouncelab::cli_test
