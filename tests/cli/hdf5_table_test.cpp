// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

class Hdf5Table : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  const fs::path path_ = folder_ / "a.h5";
};

TEST_F(Hdf5Table, GivesBackRealsIntegersAndTextsBitByBit) {
  const std::vector<double> reals{1.0 / 3.0, -0.0, NAN, INFINITY, 5e-324};
  const std::vector<std::int64_t> integers{0, -1, INT64_MAX, INT64_MIN, 7};
  const std::vector<std::string> texts{"", "clipped|overlap", "a,b", "\xC3\xA9", "x"};
  write_hdf5(path_, {{{"r", reals}, {"i", integers}, {"t", texts}}}, "t.h5");
  const Table table = read_hdf5(
      path_,
      {{"t", ColumnType::text}, {"r", ColumnType::real}, {"i", ColumnType::integer}, {"no", ColumnType::real, false}});
  ASSERT_EQ(table.columns.size(), 3U);
  EXPECT_EQ(*table.integers("i"), integers);
  EXPECT_EQ(*table.texts("t"), texts);
  for (std::size_t k = 0; k < reals.size(); ++k) {
    const double value = (*table.reals("r"))[k];
    EXPECT_TRUE(std::isnan(reals[k]) ? std::isnan(value) : value == reals[k]) << k;
    EXPECT_EQ(std::signbit(value), std::signbit(reals[k])) << k;
  }
}

TEST_F(Hdf5Table, HoldsAnEmptyTable) {
  write_hdf5(path_, {{{"r", std::vector<double>{}}, {"t", std::vector<std::string>{}}}}, "t.h5");
  EXPECT_EQ(read_hdf5(path_, {{"r"}, {"t", ColumnType::text}}).n_rows(), 0U);
}

TEST_F(Hdf5Table, ReadsIntegersAsRealsButNotTheOtherWay) {
  write_hdf5(path_, {{{"r", std::vector<double>{1.5}}, {"i", std::vector<std::int64_t>{2}}}}, "t.h5");
  EXPECT_EQ(read_hdf5(path_, {{"i"}}).reals("i")->front(), 2.0);
  EXPECT_THROW(read_hdf5(path_, {{"r", ColumnType::integer}}), FileError);
  EXPECT_THROW(read_hdf5(path_, {{"r", ColumnType::text}}), FileError);
}

TEST_F(Hdf5Table, NamesWhatIsWrong) {
  EXPECT_THROW(read_hdf5(path_, {{"r"}}), FileError);  // no such file
  write_hdf5(path_, {{{"r", std::vector<double>{1.5}}, {"s", std::vector<double>{1, 2}}}}, "t.h5");
  EXPECT_THROW(read_hdf5(path_, {{"missing"}}), FileError);
  EXPECT_THROW(read_hdf5(path_, {{"r"}, {"s"}}), FileError);  // of different lengths
  fs::resize_file(path_, fs::file_size(path_) / 2);
  EXPECT_THROW(read_hdf5(path_, {{"r"}}), FileError);
  std::ofstream(path_) << "r\n1\n";
  EXPECT_THROW(read_hdf5(path_, {{"r"}}), FileError);
}

}  // namespace
}  // namespace bouncelab::cli
