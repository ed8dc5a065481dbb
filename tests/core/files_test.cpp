// SPDX-License-Identifier: GPL-3.0-or-later
// Files read at any place, through pipes too; outputs that appear whole or not, never in place of an input; locks.
#include "bouncelab/core/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "bouncelab/core/error.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

namespace fs = std::filesystem;

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

TEST_F(FileBytesTest, HoldsWhatTheFileHoldsAndNoMore) {
  write(9'000'001);
  FileBytes file(path_);
  ASSERT_EQ(file.size(), 9'000'001);
  for (const std::int64_t n : {1, 70'000, 5'000'000})
    for (const std::int64_t first : {0L, 4'000'001L, 8'999'999L, 65'535L, 4'194'300L}) {
      ASSERT_EQ(file.text(first, static_cast<std::size_t>(n)),
                content_.substr(static_cast<std::size_t>(first), static_cast<std::size_t>(n)))
          << n << " bytes from " << first;
    }
  EXPECT_EQ(file.text(9'000'001, 1) + file.text(-1, 2), "");
}

TEST_F(FileBytesTest, AFileThatWasCutShortMeanwhileIsReadUpToThere) {
  write(2'000'000);
  FileBytes file(path_);
  std::filesystem::resize_file(path_, 1'000'000);
  EXPECT_EQ(file.text(999'000, 2000).size(), 1000U);
}

TEST_F(FileBytesTest, NamesAFileThatIsNotThere) { EXPECT_THROW(FileBytes("/no/such/file"), FileError); }

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
    EXPECT_THAT(test::refusal<InvalidArgument>([&] { check_files(inputs, outputs, {}, true); }),
                testing::HasSubstr(words));
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
  EXPECT_THROW(check_files({}, in({"other.csv/new.csv"}), {}, true), FileError);
  EXPECT_NO_THROW(check_files(in({"missing.csv"}), in({"new.csv", "missing/new.csv"}), {}, false));
  for (const char* name : {"new.csv", "missing"})
    EXPECT_FALSE(fs::exists(folder_ / name)) << "checking leaves something behind";
}

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
      EXPECT_EQ(bytes.text(700'000, 1) + bytes.text(0, 1), "yx");
    }
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

class OutputFileTest : public testing::Test {
 protected:
  long n_files() const { return std::distance(fs::directory_iterator(folder_), {}); }
  [[noreturn]] void replace_until_killed(const std::string& content) const {
    try {
      for (;;) write_whole(folder_ / "a.csv", content, true);
    } catch (...) {
      ::_exit(1);
    }
  }
  test::TemporaryFolder folder_;
};

TEST_F(OutputFileTest, AppearsOnlyWhenCommitted) {
  {
    OutputFile file(folder_ / "a.csv", false);
    file.write("half");
    EXPECT_FALSE(fs::exists(folder_ / "a.csv"));
  }
  EXPECT_EQ(n_files(), 0) << "an abandoned file leaves something behind";
  write_whole(folder_ / "a.csv", "whole", false);
  EXPECT_EQ(fs::file_size(folder_ / "a.csv"), 5u);
  EXPECT_EQ(n_files(), 1);
}

TEST_F(OutputFileTest, AFolderIsAnErrorAndOneThatIsMissingIsMadeAndStaysIfTheFileDoes) {
  EXPECT_THROW(OutputFile(folder_, true), FileError);
  const fs::path folder = folder_ / "missing" / "too";
  OutputFile(folder / "a.csv", true).write("not committed");
  EXPECT_FALSE(fs::exists(folder));
  write_whole(folder / "a.csv", "whole", false);
  EXPECT_EQ(fs::file_size(folder / "a.csv"), 5u);
  EXPECT_THROW(OutputFile(folder / "a.csv" / "b.csv", true), FileError);
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
  ::setenv("TMPDIR", folder_.path().c_str(), 1);
  std::string read;
  std::thread reader([&] { std::getline(std::ifstream(fifo), read); });
  write_whole(fifo, std::string(100'000, 'x'), false);
  reader.join();
  EXPECT_EQ(read.size(), 100'000u);
  EXPECT_TRUE(fs::is_fifo(fifo));
  write_whole("/dev/null", "x", false);  // not to break the machine where this fails
  ::unsetenv("TMPDIR");
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

TEST_F(OutputFileTest, AFileMadeByAnotherProcessMeanwhileIsKept) {
  OutputFile file(folder_ / "a.csv", false);
  std::ofstream(folder_ / "a.csv") << "other";
  EXPECT_THROW(file.commit(), FileExists);
  EXPECT_EQ(fs::file_size(folder_ / "a.csv"), 5u);
}

TEST_F(OutputFileTest, AKilledProcessLeavesNothing) {
  const pid_t child = ::fork();
  if (child == 0) {
    OutputFile file(folder_ / "a.csv", false);
    file.write("half");
    ::raise(SIGKILL);
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  EXPECT_EQ(n_files(), 0) << "on a drive that has no files without a name (O_TMPFILE) one stays";
}

TEST_F(OutputFileTest, AProcessKilledBetweenLinkAndRenameLeavesANameThatTheNextRunTakesAway) {
  write_whole(folder_ / "a.csv", "old", false);
  // one of some 60 kills finds the name: all of 4000 miss it with a probability of 1e-28
  for (int k = 0; k < 4000 && n_files() == 1; ++k) {
    const pid_t child = ::fork();
    if (child == 0) replace_until_killed("of a process that was killed");
    ::usleep(2000 + 37 * (k % 100));
    ::kill(child, SIGKILL);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  }
  ASSERT_EQ(n_files(), 2) << "no process was killed while the name was there";
  write_whole(folder_ / "a.csv", "new", true);
  EXPECT_EQ(n_files(), 1);
  EXPECT_EQ(fs::file_size(folder_ / "a.csv"), 3u);
}

TEST_F(OutputFileTest, ProcessesThatReplaceTheSameFileAtOnceLeaveTheWholeFileOfOne) {
  write_whole(folder_ / "a.csv", "old", false);
  const pid_t child = ::fork();
  if (child == 0) replace_until_killed(std::string(2000, 'b'));
  for (int k = 0; k < 2000; ++k) {
    write_whole(folder_ / "a.csv", std::string(1000, 'a'), true);
    const auto size = fs::file_size(folder_ / "a.csv");
    EXPECT_TRUE(size == 1000u || size == 2000u) << size;
  }
  ::kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status)) << "it could not write";
}

}  // namespace
}  // namespace bouncelab
