// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

namespace fs = std::filesystem;
using Paths = std::vector<fs::path>;

class CheckFiles : public testing::Test {
 protected:
  CheckFiles() {
    for (const char* name : {"in.csv", "other.csv"}) std::ofstream(folder_ / name) << "x";
    fs::create_hard_link(folder_ / "in.csv", folder_ / "hard.csv");
    fs::create_symlink("in.csv", folder_ / "soft.csv");
    fs::create_symlink("new.csv", folder_ / "dangling.csv");
    fs::create_directory_symlink(".", folder_ / "here");
  }
  Paths in(const std::vector<std::string>& names) const {
    Paths paths;
    for (const std::string& name : names) paths.push_back(folder_ / name);
    return paths;
  }
  void expect_refused(const Paths& inputs, const Paths& outputs, const char* words) const {
    try {
      check_files(inputs, outputs, {}, true);
      ADD_FAILURE() << "not refused: " << words;
    } catch (const InvalidArgument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(words));
    }
  }
  test::TemporaryFolder folder_;
};

TEST_F(CheckFiles, NoOutputIsAnInputByAnyNameOrLink) {
  for (const char* name : {"in.csv", "hard.csv", "soft.csv", "here/in.csv", "./in.csv", "here/here/soft.csv"})
    expect_refused(in({"in.csv"}), in({name}), "is the input");
  expect_refused(in({"soft.csv"}), in({"hard.csv"}), "is the input");
}

TEST_F(CheckFiles, NoOutputIsAnotherOneAlsoBeforeItExists) {
  expect_refused({}, in({"new.csv", "here/new.csv"}), "two outputs");
  expect_refused({}, in({"new.csv", "dangling.csv"}), "two outputs");
  expect_refused({}, in({"other.csv", "./other.csv"}), "two outputs");
}

TEST_F(CheckFiles, WhatIsWrittenBesideAnOutputIsAnOutputToo) {
  EXPECT_THROW(check_files(in({"in.csv"}), in({"new.csv"}), in({"hard.csv"}), true), InvalidArgument);
  EXPECT_NO_THROW(check_files(in({"in.csv"}), in({"new.csv"}), in({"other.csv"}), false));
}

TEST_F(CheckFiles, TheNullDeviceTakesAllOutputsAndMayBeAnInput) {
  EXPECT_NO_THROW(check_files({"/dev/null"}, {"/dev/null", "/dev/null"}, {}, false));
}

TEST_F(CheckFiles, ExistingOutputsNeedLeaveAndMissingInputsAreLeftToTheirReader) {
  EXPECT_THROW(check_files({}, in({"other.csv"}), {}, false), FileExists);
  EXPECT_THROW(check_files({}, in({"missing/new.csv"}), {}, true), FileError);
  EXPECT_NO_THROW(check_files(in({"missing.csv"}), in({"new.csv"}), {}, false));
  EXPECT_FALSE(fs::exists(folder_ / "new.csv")) << "checking leaves something behind";
}

}  // namespace
}  // namespace bouncelab
