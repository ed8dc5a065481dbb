// SPDX-License-Identifier: GPL-3.0-or-later
/// Tables in pieces.
#include "stages/files/table_file.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/table.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

/// Rows first ... last - 1 of a table of onsets.
Table rows_of(std::size_t first, std::size_t last) {
  std::vector<std::string> recording;
  std::vector<std::int64_t> drop;
  std::vector<double> t, sigma;
  for (std::size_t k = first; k < last; ++k) {
    recording.push_back("r " + std::to_string(k / 5000) + ".wav");
    drop.push_back(static_cast<std::int64_t>(k / 25 % 200));
    t.push_back(std::sqrt(static_cast<double>(k)));
    sigma.push_back(k % 7 == 0 ? NAN : 1e-6);
  }
  return {{{"recording", recording}, {"drop", drop}, {"t_s", t}, {"sigma_t_s", sigma}}};
}
constexpr std::size_t kRows = kPiece_rows + 1000;  // more than a piece
const std::vector<ColumnSpec> kColumns{
    {"recording", ColumnType::text}, {"drop", ColumnType::integer}, {"t_s"}, {"sigma_t_s", ColumnType::real, false}};

std::string text_of(const Table& table) {
  std::ostringstream text;
  write_csv(text, table);
  return text.str();
}

class TableFile : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  const fs::path path_ = folder_ / "a.csv";
  stages::Run run_;

  TableFile() { run_.common.force = true; }
  std::string content() const {
    std::ifstream in(path_, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
};

TEST_F(TableFile, IsTheSameBytesInWhateverPiecesAndOrderItIsWritten) {
  write_table(run_, path_, rows_of(0, kRows));
  const std::string whole = content();
  constexpr std::size_t kPieces = 9;  // the second is empty
  const auto begin = [](std::size_t k) { return k < 2 ? 0 : kRows * (k - 1) / (kPieces - 1); };
  for (const std::size_t step : {1U, 2U, 4U, 5U, 7U, 8U}) {  // prime to 9: every piece comes once
    TableWriter writer(run_, path_);
    for (std::size_t k = 0; k < kPieces; ++k) {
      const std::size_t piece = (k * step + step - 1) % kPieces;
      writer.add(piece, rows_of(begin(piece), begin(piece + 1)));
    }
    writer.finish({});
    EXPECT_TRUE(content() == whole) << step;
  }
}

TEST_F(TableFile, IsTheSameRowsInWhateverPiecesItIsRead) {
  write_table(run_, path_, rows_of(0, kRows));
  const std::string whole = text_of(read_table(path_, kColumns));
  EXPECT_TRUE(whole == text_of(rows_of(0, kRows)));
  for (const std::size_t piece : {std::size_t{999}, kPiece_rows, kRows, 2 * kRows}) {
    TableReader reader = open_table(path_, kColumns);
    std::ostringstream all;
    write_csv(all, reader.next(piece));
    for (Table rows = reader.next(piece); rows.n_rows() > 0; rows = reader.next(piece)) write_csv_rows(all, rows);
    EXPECT_TRUE(all.str() == whole) << piece;
    EXPECT_EQ(reader.next(piece).n_rows(), 0U);
  }
}

TEST_F(TableFile, IsLeftAloneWithoutTheLastPiece) {
  write_table(run_, path_, rows_of(0, 10));
  const std::string before = content();
  { TableWriter(run_, path_).add(rows_of(0, kRows)); }
  EXPECT_TRUE(content() == before);
}

TEST(OutputFolderTest, TheSecondIsRefusedAndTheLockEndsWithItsProcess) {
  const test::TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    const OutputFolder lock(folder);
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  {
    const OutputFolder lock(folder);
    EXPECT_THROW(OutputFolder{folder}, FileError);
  }
  EXPECT_NO_THROW(OutputFolder{folder});
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 0);
}

}  // namespace
}  // namespace bouncelab::stages
