// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

class FileBytesTest : public ::testing::Test {
 protected:
  void write(std::size_t n) {
    content_.resize(n);
    for (std::size_t k = 0; k < n; ++k) content_[k] = static_cast<char>((k * 2654435761U) >> 13);
    std::ofstream(path_, std::ios::binary) << content_;
  }

  test::TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "bytes";
  std::string content_;
};

TEST_F(FileBytesTest, HoldsWhatTheFileHoldsForwardsBackwardsAndAcrossItsWindows) {
  write(9'000'001);  // more than two windows
  FileBytes file(path_);
  ASSERT_EQ(file.size(), 9'000'001);
  for (const std::int64_t n : {1, 70'000, 5'000'000})
    for (const std::int64_t first : {0L, 4'000'001L, 8'999'999L, 65'535L, 4'194'300L}) {
      const std::int64_t n_here = std::min<std::int64_t>(n, file.size() - first);
      const auto bytes = file.at(first, n_here);
      ASSERT_EQ(std::string(bytes.begin(), bytes.end()),
                content_.substr(static_cast<std::size_t>(first), static_cast<std::size_t>(n_here)))
          << n << " bytes from " << first;
    }
}

TEST_F(FileBytesTest, RefusesWhatLiesBeyondTheEnd) {
  write(100);
  FileBytes file(path_);
  EXPECT_EQ(file.at(99, 1).size(), 1U);
  EXPECT_TRUE(file.at(100, 0).empty());
  EXPECT_THROW(file.at(99, 2), FileError);
  EXPECT_THROW(file.at(-1, 2), FileError);
}

TEST_F(FileBytesTest, SaysThatAFileWasCutShortWhileItWasRead) {
  // a recorder's disk that goes away: an error of this file, not the end of the program
  write(2'000'000);
  FileBytes file(path_);
  file.at(0, 1000);
  std::filesystem::resize_file(path_, 1'000'000);
  EXPECT_THROW(file.at(1'500'000, 1000), FileError);
  EXPECT_EQ(file.at(900'000, 1000).size(), 1000U);
}

TEST_F(FileBytesTest, NamesAFileThatIsNotThere) { EXPECT_THROW(FileBytes("/no/such/file"), FileError); }

}  // namespace
}  // namespace bouncelab
