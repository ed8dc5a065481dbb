// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

class Hdf5Table : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  const fs::path path_ = folder_ / "a.h5";

  std::string message_of(const ColumnSpec& wanted) const {
    try {
      read_hdf5(path_, {wanted});
    } catch (const FileError& error) {
      return error.what();
    }
    return "no error";
  }

  /// A column as other programs can write it.
  struct Foreign {
    hsize_t n_rows = 0, chunk = 0;  // 0: contiguous
    unsigned deflate = 0;
    std::vector<double> written{};  // the first rows; the others were never written
  };
  void write_foreign(const Foreign& f, hid_t type = H5T_NATIVE_DOUBLE) const {
    const hid_t file = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t most = H5S_UNLIMITED;  // of a chunk that may be larger than what is in it
    const hid_t space = H5Screate_simple(1, &f.n_rows, f.chunk > 0 ? &most : nullptr);
    const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    if (f.chunk > 0) H5Pset_chunk(list, 1, &f.chunk);
    if (f.deflate > 0) H5Pset_deflate(list, f.deflate);
    const hid_t set = H5Dcreate2(file, "r", type, space, H5P_DEFAULT, list, H5P_DEFAULT);
    const hsize_t first = 0, n = f.written.size();
    if (n > 0) {
      const hid_t from = H5Screate_simple(1, &n, nullptr);
      H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, nullptr, &n, nullptr);
      H5Dwrite(set, H5T_NATIVE_DOUBLE, from, space, H5P_DEFAULT, f.written.data());
      H5Sclose(from);
    }
    H5Dclose(set), H5Pclose(list), H5Sclose(space), H5Fclose(file);
  }
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

TEST_F(Hdf5Table, ReadsTheSameFromBytesInMemory) {
  write_hdf5(path_, {{{"r", std::vector<double>{1.5, 2.5}}, {"t", std::vector<std::string>{"a", ""}}}}, "t.h5");
  std::ifstream in(path_, std::ios::binary);
  std::ostringstream content;
  content << in.rdbuf();
  const std::string bytes = content.str();
  fs::remove(path_);
  const auto span = std::as_bytes(std::span(bytes));
  const Table table = read_hdf5(span, path_.string(), {{"r"}, {"t", ColumnType::text}});
  EXPECT_EQ(*table.reals("r"), (std::vector<double>{1.5, 2.5}));
  EXPECT_EQ(*table.texts("t"), (std::vector<std::string>{"a", ""}));
  EXPECT_THROW(read_hdf5(span.first(bytes.size() / 2), "a.h5", {{"r"}}), FileError);
  write_hdf5(path_, {{{"r", std::vector<double>{1.5}}}}, "t.h5");
  EXPECT_THROW(read_hdf5({}, path_.string(), {{"r"}}), FileError) << "the file of that name was opened";
}

TEST_F(Hdf5Table, RowsThatTheFileCannotHoldAreRefusedBeforeMemoryIsTaken) {
  using testing::HasSubstr;
  for (const hsize_t n : {300'000'000ULL, 2'000'000'000ULL, 4'000'000'000'000'000'000ULL}) {
    write_foreign({.n_rows = n, .chunk = 1000});
    EXPECT_THAT(message_of({"r"}), HasSubstr("promises " + std::to_string(n) + " rows in a file of ")) << n;
    write_foreign({.n_rows = n, .chunk = 1000, .deflate = 9, .written = {1, 2, 3}});
    EXPECT_THAT(message_of({"r"}), HasSubstr("promises " + std::to_string(n) + " rows")) << n;
  }
  write_foreign({.n_rows = 5, .chunk = 400'000'000, .deflate = 1});
  EXPECT_THAT(message_of({"r"}), HasSubstr("chunks of 400000000 rows"));
}

TEST_F(Hdf5Table, RowsThatWereNeverWrittenAreNotTakenForZeros) {
  using testing::HasSubstr;
  write_foreign({.n_rows = 100});
  EXPECT_THAT(message_of({"r"}), HasSubstr("where 0 are stored"));
  write_foreign({.n_rows = 100, .chunk = 10, .written = {1, 2, 3}});
  EXPECT_THAT(message_of({"r"}), HasSubstr("100 values of 8 bytes where 80 are stored"));
}

TEST_F(Hdf5Table, ReadsWhatIsCompressedInChunksLargerThanTheTable) {
  const std::vector<double> values{1.5, 2.5, 3.5};
  write_foreign({.n_rows = 3, .chunk = 100'000, .deflate = 9, .written = values});
  EXPECT_EQ(*read_hdf5(path_, {{"r"}}).reals("r"), values);
}

TEST_F(Hdf5Table, AnIntegerBeyond64BitsIsRefused) {
  write_foreign({.n_rows = 2, .written = {1, 18446744073709549568.0}}, H5T_NATIVE_UINT64);
  EXPECT_THAT(message_of({"r", ColumnType::integer}), testing::HasSubstr("holds 18446744073709549568 in row 2"));
  EXPECT_EQ(read_hdf5(path_, {{"r"}}).reals("r")->at(1), 18446744073709549568.0);
}

TEST_F(Hdf5Table, ManyRowsThatReferToOneLongTextAreRefused) {
  std::vector<std::string> texts(1000, "b");
  texts[0] = std::string(100'000, 'a');
  write_hdf5(path_, {{{"t", texts}}}, "t.h5");
  const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t set = H5Dopen2(file, "t", H5P_DEFAULT);
  const auto at = static_cast<std::streamoff>(H5Dget_offset(set));
  H5Dclose(set), H5Fclose(file);
  constexpr std::streamoff kReference_bytes = 16;
  std::fstream patch(path_, std::ios::in | std::ios::out | std::ios::binary);
  char reference[kReference_bytes];
  patch.seekg(at).read(reference, kReference_bytes);
  for (int k = 1; k < 1000; ++k) patch.seekp(at + k * kReference_bytes).write(reference, kReference_bytes);
  patch.close();
  EXPECT_THAT(message_of({"t", ColumnType::text}), testing::HasSubstr("column t cannot be read as texts"));
}

TEST_F(Hdf5Table, ALinkIntoAnotherFileIsNotFollowed) {
  write_hdf5(path_, {{{"s", std::vector<double>{1.5}}}}, "t.h5");
  const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Lcreate_external("other.h5", "r", file, "r", H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(file);
  EXPECT_THAT(message_of({"r"}), testing::HasSubstr("column 'r' is a link"));
}

}  // namespace
}  // namespace bouncelab::cli
