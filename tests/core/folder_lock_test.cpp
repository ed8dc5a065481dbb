// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <iterator>
#include <string>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

namespace fs = std::filesystem;

TEST(FolderLockTest, TheSecondIsRefusedWithTheNumberOfTheFirst) {
  const test::TemporaryFolder folder;
  {
    const FolderLock lock(folder);
    // whoever shares the folder may take the lock that a killed run left
    EXPECT_EQ(fs::status(fs::path(folder) / ".bouncelab.lock").permissions(), fs::perms{0666});
    try {
      const FolderLock second(folder);
      ADD_FAILURE() << "two have the folder";
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("process " + std::to_string(::getpid())));
    }
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 0);
  const FolderLock again(folder);
}

TEST(FolderLockTest, TheLockEndsWithItsProcess) {
  const test::TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    const FolderLock lock(folder);
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_NO_THROW(FolderLock{folder});
}

}  // namespace
}  // namespace bouncelab
