// SPDX-License-Identifier: GPL-3.0-or-later
// `report --figures`: each figure of the page as SVG and PDF, drawn by a browser that may not be there.
#include <cmath>

#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

class Figures : public ProgramTest {
 protected:
  void SetUp() override {
    ASSERT_EQ(run("simulate --drops 3 --asperities 10000 --out i.csv --quiet").exit_code, 0);
    ASSERT_EQ(run("restitution i.csv --air 0 --out s.csv --quiet").exit_code, 0);
    run("fit s.csv --method asymmetric-laplace --goodness-replicates 0 --out fit.json --quiet");
    ASSERT_TRUE(exists("fit.json"));
  }
  bool has_browser() const {
    return shell("command -v chromium || command -v chromium-browser || command -v google-chrome").exit_code == 0;
  }
  /// Of the folder, without provenance.
  std::vector<std::string> figures(const std::string& folder) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_ / folder))
      if (entry.path().extension() != ".json") names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(Figures, AreFilesOfTheirOwnTheSameEachTimeAndReplaceNothingUnasked) {
  if (!has_browser()) GTEST_SKIP() << "no Chromium, no Chrome";
  const Result result = run("report . --figures figures");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(exists("report.html"));  // in place of the page
  const std::vector<std::string> names = figures("figures");
  for (const char* name : {"law", "histograms", "slopes"})
    for (const char* extension : {".svg", ".pdf", ".csv"})
      EXPECT_THAT(names, testing::Contains(std::string(name) + extension));
  for (const std::string& name : names) {
    const std::string content = content_of(folder_ / "figures" / name);
    EXPECT_THAT(content, testing::StartsWith(name.ends_with(".svg")   ? "<svg xmlns="
                                             : name.ends_with(".csv") ? "panel,series,"
                                                                      : "%PDF-"))
        << name;
    EXPECT_TRUE(fs::exists(folder_ / "figures" / (name + ".meta.json"))) << name;
  }
  expect_one_line_error(run("report . --figures figures --quiet"), 3, {"figures/", "exists already", "--force"});
  ASSERT_EQ(run("report . --figures again --out page.html --quiet").exit_code, 0);
  EXPECT_TRUE(exists("page.html"));
  for (const std::string& name : names)
    if (name.ends_with(".svg")) {
      EXPECT_EQ(content("again/" + name), content("figures/" + name)) << name;
    }
}

TEST_F(Figures, OfComparisonsAndDetectorsHaveALegendAxesInWordsAndTheirData) {
  if (!has_browser()) GTEST_SKIP() << "no Chromium, no Chrome";
  std::string samples = "recording,drop,v_mps,eps\n";
  for (int k = 0; k < 600; ++k)  // six recordings of two drops on two plates; the scatter is the same in every run
    samples += "r" + std::to_string(k / 100) + "," + std::to_string(k / 50 % 2) + "," +
               std::to_string(0.3 + 0.02 * (k % 50)) + "," +
               std::to_string(0.9 - 0.05 * (k / 300) + 0.002 * std::fmod(0.618 * k, 1.0)) + "\n";
  write("c.csv", samples);
  write("g.csv", "recording,plate\nr0,glass\nr1,glass\nr2,glass\nr3,wood\nr4,wood\nr5,wood\n");
  ASSERT_EQ(run("compare c.csv --groups g.csv --out c").exit_code, 0);
  const Result compared = run("report c --figures cf");
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_THAT(figures("cf"), testing::IsSupersetOf({"campaign.csv", "campaign.svg", "groups.csv", "groups.pdf"}));
  const std::string groups = content("cf/groups.csv");
  EXPECT_THAT(groups, testing::HasSubstr("coefficient of restitution ε at 0."));
  EXPECT_THAT(groups, testing::HasSubstr(",\"ε, 95 %\",glass,0.90"));
  const std::string campaign = content("cf/campaign.svg");  // each group, and once what its band and line are
  for (const char* entry :
       {">glass, ± standard error<", ">wood, ± standard error<", ">band of each: 95 % of its recordings<"})
    EXPECT_THAT(campaign, testing::HasSubstr(entry));
  EXPECT_THAT(content("cf/campaign.svg"), testing::HasSubstr("coefficient of restitution"));
  // of plates that differ nothing is drawn as of one ball
  ASSERT_EQ(run("fit c.csv --groups g.csv --out apart/fit.json --quiet").exit_code, 0);
  ASSERT_EQ(run("report apart --figures apart/figures").exit_code, 0);
  EXPECT_THAT(figures("apart/figures"), testing::ElementsAre("law.csv", "law.pdf", "law.svg"));
  EXPECT_THAT(content("apart/figures/law.csv"), testing::HasSubstr(",\"wood, 95 %\","));
  write("v.toml", "snr-db = [20, 10, 30, 40]\n");
  ASSERT_EQ(run("validate --config v.toml --detector builtin --drops 1 --impacts 12 --asperities 99 --out v").exit_code,
            0);
  const Result validated = run("report v --figures vf");
  ASSERT_EQ(validated.exit_code, 0) << validated.err;
  EXPECT_THAT(content("vf/found.csv"),
              testing::StartsWith("panel,series,signal-to-noise ratio (dB),F-measure at ±5 ms,"));
  EXPECT_THAT(content("vf/found.svg"), testing::HasSubstr("signal-to-noise ratio (dB)"));
  expect_one_line_error(run("report v --quiet"), 2, {"report.html", "is the input", "another name"});
  fs::create_directory(folder_ / "empty");
  expect_one_line_error(run("report empty"), 3, {"fit.json", "no such file", "compare or validate"});
}

TEST_F(Figures, WithoutABrowserAreRefusedInALineThatSaysWhatToInstall) {
  expect_one_line_error(shell("PATH=/nowhere \"$B\" report . --figures figures"), 3, {"--figures", "Chromium"});
  EXPECT_FALSE(exists("figures"));
}

TEST_F(Figures, OfABrowserThatFailsLeaveNothingBehind) {
  fs::create_directory(folder_ / "bin");
  write("bin/chromium", "#!/bin/sh\necho 'no display of any kind' >&2\nexit 1\n");
  fs::permissions(folder_ / "bin" / "chromium", fs::perms::owner_all);
  expect_one_line_error(shell("PATH=\"$PWD/bin:$PATH\" \"$B\" report . --figures figures"), 3,
                        {"--figures", "chromium cannot draw the figures", "no display of any kind"});
  // one that writes another page
  write("bin/chromium", "#!/bin/sh\necho '<html></html>'\n");
  expect_one_line_error(shell("PATH=\"$PWD/bin:$PATH\" \"$B\" report . --figures figures"), 3, {"list of figures"});
  EXPECT_FALSE(exists("figures"));
}

}  // namespace
}  // namespace bouncelab::cli_test
