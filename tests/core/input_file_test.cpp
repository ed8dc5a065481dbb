// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/table.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

namespace fs = std::filesystem;

class InputFileTest : public testing::Test {
 protected:
  /// Runs `use` while another thread writes `content` into a FIFO.
  template <class Use>
  void with_fifo(const std::string& content, const Use& use) {
    const fs::path fifo = folder_ / "fifo";
    ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
    std::thread writer([&] { std::ofstream(fifo, std::ios::binary) << content; });
    use(fifo);
    writer.join();
  }
  test::TemporaryFolder folder_;
};

TEST_F(InputFileTest, ARegularFileIsReadWhereItIs) {
  std::ofstream(folder_ / "a") << "abc";
  EXPECT_EQ(readable(folder_ / "a"), folder_ / "a");
}

TEST_F(InputFileTest, WhatComesThroughAFifoCanBeReadAgainAndAtAnyPlace) {
  std::string content(1'000'000, 'x');
  content[700'000] = 'y';
  with_fifo(content, [&](const fs::path& fifo) {
    for (int time = 0; time < 2; ++time) {
      FileBytes bytes(fifo);
      ASSERT_EQ(bytes.size(), 1'000'000);
      EXPECT_EQ(bytes.at(700'000, 1)[0], 'y');
      EXPECT_EQ(bytes.at(0, 1)[0], 'x');
    }
  });
}

TEST_F(InputFileTest, ATableComesThroughAFifoTwice) {
  with_fifo("t_s\n0.5\n", [&](const fs::path& fifo) {
    for (int time = 0; time < 2; ++time) EXPECT_EQ(read_csv(fifo, {{"t_s", ColumnType::real}}).n_rows(), 1u);
  });
}

TEST_F(InputFileTest, NothingStaysInTheTemporaryFolder) {
  with_fifo("abc", [&](const fs::path& fifo) {
    ::setenv("TMPDIR", folder_.path().c_str(), 1);
    readable(fifo);
    ::unsetenv("TMPDIR");
  });
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "more than the FIFO";
}

TEST_F(InputFileTest, FoldersDevicesWithoutEndAndMissingFilesAreRefused) {
  EXPECT_THROW(readable(folder_), FileError);
  EXPECT_THROW(readable("/dev/zero"), FileError);
  EXPECT_THROW(readable(folder_ / "missing"), FileError);
}

}  // namespace
}  // namespace bouncelab
