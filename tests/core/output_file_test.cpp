// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <iterator>
#include <string>
#include <thread>

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

TEST_F(OutputFileTest, ALinkIsFollowedAndStays) {
  write_whole(folder_ / "real.csv", "old", false);
  fs::create_symlink("real.csv", folder_ / "link.csv");
  fs::create_symlink("new.csv", folder_ / "dangling.csv");
  EXPECT_THROW(write_whole(folder_ / "link.csv", "newer", false), FileExists);
  write_whole(folder_ / "link.csv", "newer", true);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.csv"));
  EXPECT_EQ(fs::file_size(folder_ / "real.csv"), 5u);
  write_whole(folder_ / "dangling.csv", "whole", false);
  EXPECT_TRUE(fs::is_symlink(folder_ / "dangling.csv"));
  EXPECT_EQ(fs::file_size(folder_ / "new.csv"), 5u);
}

TEST_F(OutputFileTest, APipeIsWrittenToAndNotReplaced) {
  const fs::path fifo = folder_ / "fifo.csv";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] { std::getline(std::ifstream(fifo), read); });
  write_whole(fifo, std::string(100'000, 'x'), false);
  reader.join();
  EXPECT_EQ(read.size(), 100'000u);
  EXPECT_TRUE(fs::is_fifo(fifo));
  write_whole("/dev/null", "x", false);  // not to break the machine where this fails
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_EQ(n_files(), 1);
}

TEST_F(OutputFileTest, AReplacedFileKeepsItsPermissionsAndANewOneHasThoseOfTheUmask) {
  write_whole(folder_ / "a.csv", "old", false);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  EXPECT_EQ(static_cast<unsigned>(fs::status(folder_ / "a.csv").permissions()), 0666u & ~mask);
  fs::permissions(folder_ / "a.csv", fs::perms{0640});
  write_whole(folder_ / "a.csv", "newer", true);
  EXPECT_EQ(fs::status(folder_ / "a.csv").permissions(), fs::perms{0640});
}

TEST_F(OutputFileTest, NamesUpToTheFileSystemsLimitAreWritten) {
  const std::string longest = std::string(251, 'n') + ".csv";
  write_whole(folder_ / longest, "whole", false);
  EXPECT_EQ(fs::file_size(folder_ / longest), 5u);
  EXPECT_THROW(OutputFile(folder_ / ("n" + longest), false), FileError);
}

TEST_F(OutputFileTest, AFileMadeByAnotherProcessMeanwhileIsKept) {
  OutputFile file(folder_ / "a.csv", false);
  std::ofstream(folder_ / "a.csv") << "other";
  EXPECT_THROW(file.commit(), FileExists);
  EXPECT_EQ(fs::file_size(folder_ / "a.csv"), 5u);
}

TEST_F(OutputFileTest, WhatAKilledProcessLeftIsRemovedAndNothingElse) {
  std::ofstream(folder_ / ".bouncelab-notes.partial.csv") << "mine";
  const pid_t child = ::fork();
  if (child == 0) {
    const OutputFile file(folder_ / "a.csv", false);
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_EQ(n_files(), 2) << "a killed process leaves its file";
  const OutputFile alive(folder_ / "b.csv", false);
  remove_abandoned_files(folder_);
  EXPECT_EQ(n_files(), 2) << "the notes and the file that is being written";
  EXPECT_TRUE(fs::exists(alive.temporary_path()));
  EXPECT_TRUE(fs::exists(folder_ / ".bouncelab-notes.partial.csv"));
}

TEST_F(OutputFileTest, WaitsForTheLockThatAKilledProcessLeftToItsChild) {
  const pid_t owner = ::fork();
  if (owner == 0) {
    const OutputFile file(folder_ / "a.csv", false);
    if (::fork() == 0) {  // has the file open too
      ::usleep(50'000);
      ::_exit(0);
    }
    ::raise(SIGKILL);
  }
  ASSERT_EQ(::waitpid(owner, nullptr, 0), owner);
  ASSERT_EQ(n_files(), 1);
  remove_abandoned_files(folder_);
  EXPECT_EQ(n_files(), 0);
}

TEST_F(OutputFileTest, KeepsTheExtensionOfTheTemporaryFile) {
  EXPECT_EQ(OutputFile(folder_ / "a.flac", false).temporary_path().extension(), ".flac");
}

}  // namespace
}  // namespace bouncelab
