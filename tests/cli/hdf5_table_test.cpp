// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

Table read_hdf5(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  return hdf5_reader(path, wanted)->next(SIZE_MAX);
}
Table read_hdf5(std::span<const std::byte> bytes, const std::string& name, const std::vector<ColumnSpec>& wanted) {
  return hdf5_reader(bytes, name, wanted)->next(SIZE_MAX);
}

/// @param piece  rows of each piece
void write_hdf5(const fs::path& path, const Table& table, const std::string& name, std::size_t piece = SIZE_MAX) {
  const auto writer = hdf5_writer(path, name);
  for (std::size_t first = 0; first == 0 || first < table.n_rows(); first += std::min(piece, table.n_rows() - first)) {
    Table rows;
    for (const Column& column : table.columns)
      std::visit(
          [&](const auto& values) {
            const std::size_t n = std::min(piece, values.size() - std::min(first, values.size()));
            rows.columns.push_back(
                {column.name, std::decay_t<decltype(values)>(values.begin() + static_cast<std::ptrdiff_t>(first),
                                                             values.begin() + static_cast<std::ptrdiff_t>(first + n))});
          },
          column.values);
    writer->add(rows);
    if (table.n_rows() == 0) break;
  }
  writer->finish();
}

std::string content_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream content;
  content << in.rdbuf();
  return content.str();
}

/// Of two chunks and a half, with texts that become longer from chunk to chunk.
Table long_table() {
  constexpr std::size_t kRows = 2 * kPiece_rows + kPiece_rows / 2;
  std::vector<double> reals, same(kRows, 9.81);
  std::vector<std::int64_t> integers;
  std::vector<std::string> texts, flags(kRows);
  for (std::size_t k = 0; k < kRows; ++k) {
    reals.push_back(std::sqrt(static_cast<double>(k)));
    integers.push_back(static_cast<std::int64_t>(k % 25) - 3);
    texts.push_back("recording " + std::to_string(k / 500));
  }
  flags[kPiece_rows] = "overlap|clipped|doubtful";      // longer than the 16 bytes of the first chunk
  texts[2 * kPiece_rows + 3] = std::string(1000, 'n');  // longer than any cell of fixed length
  return {{{"t_s", reals}, {"drop", integers}, {"recording", texts}, {"gravity_mps2", same}, {"flags", flags}}};
}
const std::vector<ColumnSpec> kLongColumns{{"t_s"},
                                           {"drop", ColumnType::integer},
                                           {"recording", ColumnType::text},
                                           {"gravity_mps2"},
                                           {"flags", ColumnType::text}};

/// What was unpacked by a filter of ours: how often a chunk was read.
std::size_t n_chunks_read = 0;
std::size_t count_chunks(unsigned flags, std::size_t, const unsigned*, std::size_t n_bytes, std::size_t*, void**) {
  if ((flags & H5Z_FLAG_REVERSE) != 0) ++n_chunks_read;
  return n_bytes;
}

/// The attribute `units` of a column, as another program reads it.
std::string units_of(const fs::path& path, const char* column) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  std::string units;
  if (H5Aexists_by_name(file, column, "units", H5P_DEFAULT) > 0) {
    const hid_t attribute = H5Aopen_by_name(file, column, "units", H5P_DEFAULT, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute);
    units.resize(H5Tget_size(type));
    H5Aread(attribute, type, units.data());
    H5Tclose(type), H5Aclose(attribute);
  }
  H5Fclose(file);
  return units;
}

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

  /// The column t as bouncelab wrote texts at first: of variable length, in one block.
  void write_variable(const std::vector<std::string>& texts) const {
    std::vector<const char*> pointers;
    for (const std::string& text : texts) pointers.push_back(text.c_str());
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    write_block("t", type, texts.size(), pointers.data());
    H5Tclose(type);
  }
  void write_block(const char* column, hid_t type, hsize_t n, const void* values, unsigned mode = H5F_ACC_TRUNC) const {
    const hid_t file = mode == H5F_ACC_TRUNC ? H5Fcreate(path_.c_str(), mode, H5P_DEFAULT, H5P_DEFAULT)
                                             : H5Fopen(path_.c_str(), mode, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(1, &n, nullptr);
    const hid_t set = H5Dcreate2(file, column, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
    H5Dclose(set), H5Sclose(space), H5Fclose(file);
  }
};

TEST_F(Hdf5Table, ColumnsCarryTheUnitOfTheirName) {
  const std::vector<double> reals{1.0};
  write_hdf5(path_, {{{"v_mps", reals}, {"g_mps2", reals}, {"t_s", reals}, {"eps", reals}, {"drop", reals}}}, "t.h5");
  EXPECT_EQ(units_of(path_, "v_mps"), "m s-1");
  EXPECT_EQ(units_of(path_, "g_mps2"), "m s-2");
  EXPECT_EQ(units_of(path_, "t_s"), "s");
  EXPECT_EQ(units_of(path_, "eps"), "");
  EXPECT_EQ(units_of(path_, "drop"), "");
}

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
  write_foreign({.n_rows = 1, .written = {1.5}});
  const double longer[] = {1.0, 2.0};
  write_block("s", H5T_NATIVE_DOUBLE, 2, longer, H5F_ACC_RDWR);
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
  write_variable(texts);
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

TEST_F(Hdf5Table, TheBytesDependOnTheRowsAloneNotOnThePieces) {
  const Table table = long_table();
  write_hdf5(path_, table, "t.h5");
  const std::string whole = content_of(path_);
  for (const std::size_t piece : {std::size_t{777}, kPiece_rows - 1, kPiece_rows, kPiece_rows + 1, 2 * kPiece_rows}) {
    write_hdf5(path_, table, "t.h5", piece);
    EXPECT_TRUE(content_of(path_) == whole) << piece;
  }
}

TEST_F(Hdf5Table, NoTimeIsInTheFile) {
  write_hdf5(path_, long_table(), "t.h5");
  const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  for (const char* name : {".", "t_s", "drop", "recording", "flags"}) {
    H5O_info_t info{};
    ASSERT_GE(H5Oget_info_by_name(file, name, &info, H5P_DEFAULT), 0);
    EXPECT_EQ(info.atime + info.mtime + info.ctime + info.btime, 0) << name;
  }
  H5Fclose(file);
}

TEST_F(Hdf5Table, RowsInPiecesAreThoseOfTheWhole) {
  const Table table = long_table();
  write_hdf5(path_, table, "t.h5");
  for (const std::size_t piece : {std::size_t{1000}, kPiece_rows, kPiece_rows + 1, std::size_t{SIZE_MAX}}) {
    const auto reader = hdf5_reader(path_, kLongColumns);
    Table all = reader->next(piece);
    for (Table rows = reader->next(piece); rows.n_rows() > 0; rows = reader->next(piece)) {
      EXPECT_EQ(rows.place_of(0), "row " + std::to_string(all.n_rows() + 1));
      all.append(rows);
    }
    ASSERT_EQ(all.columns.size(), table.columns.size());
    for (std::size_t k = 0; k < table.columns.size(); ++k)
      EXPECT_TRUE(all.columns[k].values == table.columns[k].values) << table.columns[k].name << " " << piece;
  }
}

TEST_F(Hdf5Table, WhatIsTheSameInEveryRowTakesNextToNothing) {
  write_hdf5(path_, long_table(), "t.h5");
  const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const auto stored_bytes = [&](const char* name) {
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
    const double bytes = static_cast<double>(H5Dget_storage_size(set));
    H5Dclose(set);
    return bytes / static_cast<double>(long_table().n_rows());
  };
  EXPECT_EQ(stored_bytes("t_s"), 3.0 * sizeof(double) / 2.5) << "as they are, the last chunk half empty";
  // deflate makes at best a thousandth of it; the chunk of a number or a text is 8 to 16 bytes a row
  for (const char* name : {"drop", "gravity_mps2"}) EXPECT_LT(stored_bytes(name), 0.2) << name;
  EXPECT_LT(stored_bytes("flags"), 0.2);
  H5Fclose(file);
}

TEST_F(Hdf5Table, ReadsTextsOfVariableLengthAsTheyWereWrittenBefore) {
  const std::vector<std::string> texts{"", "a.wav", std::string(300, 'x'), "\xC3\xA9"};
  write_variable(texts);
  EXPECT_EQ(*read_hdf5(path_, {{"t", ColumnType::text}}).texts("t"), texts);
}

TEST_F(Hdf5Table, ReadsTextsOfFixedLengthOfOtherPrograms) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, 4);
  H5Tset_strpad(type, H5T_STR_SPACEPAD);
  write_block("t", type, 3, "ab  abcd    ");
  H5Tclose(type);
  EXPECT_EQ(*read_hdf5(path_, {{"t", ColumnType::text}}).texts("t"), (std::vector<std::string>{"ab", "abcd", ""}));
}

TEST_F(Hdf5Table, EachChunkIsUnpackedOnceHoweverLargeItIs) {
  constexpr H5Z_filter_t kCounting = 300;  // a number that is free for tests
  const H5Z_class2_t counting{H5Z_CLASS_T_VERS, kCounting, 1, 1, "counts", nullptr, nullptr, count_chunks};
  ASSERT_GE(H5Zregister(&counting), 0);
  const hsize_t n = 1'000'000, chunk = 400'000;  // 3.2 MB: more than HDF5 keeps of itself
  const std::vector<double> values(n, 1.5);
  const hid_t file = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t space = H5Screate_simple(1, &n, nullptr), list = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(list, 1, &chunk);
  H5Pset_filter(list, kCounting, 0, 0, nullptr);
  const hid_t set = H5Dcreate2(file, "r", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, list, H5P_DEFAULT);
  H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(set), H5Pclose(list), H5Sclose(space), H5Fclose(file);
  n_chunks_read = 0;
  const auto reader = hdf5_reader(path_, {{"r"}});
  std::size_t n_rows = 0;
  for (Table rows = reader->next(kPiece_rows); rows.n_rows() > 0; rows = reader->next(kPiece_rows))
    n_rows += rows.n_rows();
  EXPECT_EQ(n_rows, n);
  EXPECT_EQ(n_chunks_read, 3U);
}

}  // namespace
}  // namespace bouncelab::cli
