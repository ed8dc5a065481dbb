// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/run_journal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "bouncelab/core/error.hpp"

namespace bouncelab::loop {
namespace {

namespace fs = std::filesystem;

class RunJournals : public testing::Test {
 protected:
  void TearDown() override { fs::remove(path_); }

  /// Opens the journal and returns the records that were in it.
  std::vector<std::string> records(const RunIdentity& identity) const {
    std::vector<std::string> all;
    const RunJournal journal(path_, identity,
                             [&](const std::string&, std::string_view record) { all.emplace_back(record); });
    return all;
  }
  std::string content() const {
    std::ifstream in(path_, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }

  const RunIdentity identity_{{"seed", "1"}, {"height", "0.09,0.10"}, {"radius-law", "uniform:5e-4,1.5e-3"}};
  const fs::path path_ = fs::path(testing::TempDir()) / ("bouncelab_journal_" + std::to_string(::getpid()));
};

TEST_F(RunJournals, GivesBackEveryRecordInOrder) {
  {
    RunJournal journal(path_, identity_,
                       [](const std::string&, std::string_view) { FAIL() << "a new journal has no records"; });
    journal.append("point 0", "{\"point\":0}");
    journal.append("item", "a record\twith a tab");
  }
  EXPECT_THAT(records(identity_), testing::ElementsAre("{\"point\":0}", "a record\twith a tab"));
}

TEST_F(RunJournals, CutsOffWhatIsNotCompleteAndContinuesBehindIt) {
  {
    RunJournal journal(path_, identity_, {});
    for (const char* record : {"first", "second", "third"}) journal.append("item", record);
  }
  const std::string whole = content();
  const std::size_t third = whole.rfind("third");
  // cut at every byte of the last line, and a line whose text and checksum disagree
  for (std::size_t n = third; n < whole.size(); ++n) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << whole.substr(0, n);
    EXPECT_EQ(records(identity_).size(), 2u) << "cut at byte " << n;
  }
  std::string damaged = whole;
  damaged[third] = 'T';
  std::ofstream(path_, std::ios::binary | std::ios::trunc) << damaged;
  EXPECT_EQ(records(identity_).size(), 2u);
  {
    RunJournal journal(path_, identity_, [](const std::string&, std::string_view) {});
    journal.append("item", "third");
  }
  EXPECT_EQ(content(), whole);
}

TEST_F(RunJournals, RefusesTheRunOfOtherSettingsByTheirName) {
  records(identity_);
  RunIdentity other = identity_;
  other[1].second = "0.05,0.06";
  try {
    records(other);
    FAIL() << "not refused";
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("height was 0.09,0.10, now 0.05,0.06"));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("--")));  // remedies belong to the command line
  }
}

TEST_F(RunJournals, RefusesAJournalThatIsInUse) {
  const RunJournal journal(path_, identity_, {});
  EXPECT_THROW(records(identity_), FileError);
}

TEST_F(RunJournals, IsGoneWhenTheRunIsFinished) {
  RunJournal journal(path_, identity_, {});
  journal.remove();
  EXPECT_FALSE(fs::exists(path_));
}

}  // namespace
}  // namespace bouncelab::loop
