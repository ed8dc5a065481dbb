// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/output_file.hpp"

#include <gtest/gtest.h>

#include <iterator>
#include <string>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

namespace fs = std::filesystem;

class OutputFileTest : public testing::Test {
 protected:
  long n_files() const { return std::distance(fs::directory_iterator(folder_), {}); }
  test::TemporaryFolder folder_;
};

TEST_F(OutputFileTest, AppearsOnlyWhenCommitted) {
  {
    OutputFile file(folder_ / "a.csv", false);
    std::ofstream(file.temporary_path()) << "half";
    EXPECT_FALSE(fs::exists(folder_ / "a.csv"));
  }
  EXPECT_EQ(n_files(), 0) << "an abandoned file leaves something behind";
  write_whole(folder_ / "a.csv", "whole", false);
  EXPECT_EQ(fs::file_size(folder_ / "a.csv"), 5u);
  EXPECT_EQ(n_files(), 1);
}

TEST_F(OutputFileTest, AnExistingFileIsKeptUnlessItMayBeReplaced) {
  write_whole(folder_ / "a.csv", "old", false);
  EXPECT_THROW(write_whole(folder_ / "a.csv", "newer", false), FileExists);
  EXPECT_EQ(fs::file_size(folder_ / "a.csv"), 3u);
  write_whole(folder_ / "a.csv", "newer", true);
  EXPECT_EQ(fs::file_size(folder_ / "a.csv"), 5u);
}

TEST_F(OutputFileTest, AFolderOrAMissingFolderIsAnError) {
  EXPECT_THROW(OutputFile(folder_, true), FileError);
  EXPECT_THROW(OutputFile(folder_ / "missing" / "a.csv", true), FileError);
}

TEST_F(OutputFileTest, KeepsTheExtensionOfTheTemporaryFile) {
  EXPECT_EQ(OutputFile(folder_ / "a.flac", false).temporary_path().extension(), ".flac");
}

}  // namespace
}  // namespace bouncelab
