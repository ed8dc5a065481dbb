// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_table.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/table.hpp"
#include "files/hdf5_handle.hpp"

namespace bouncelab::cli {
namespace {

struct FoundType {
  H5T_class_t kind;
  std::size_t size;  // bytes of one value in the file
  bool is_unsigned, is_variable;
};

/// One column of an open file.
struct Source {
  Handle set;
  FoundType type;
  ColumnType wanted;
  std::size_t n_rows;
  std::size_t file_size;  // bytes
  std::string column;
  std::string path;

  [[noreturn]] void refuse(const std::string& what) const { throw FileError(path, "column " + column + " " + what); }
};

/// Rows of it.
struct Piece {
  std::size_t first, n;
};

template <class T>
std::vector<T> read_numbers(const Source& source, Piece piece, hid_t type) {
  std::vector<T> values(piece.n);
  if (!read_rows(source.set.get(), type, piece.first, piece.n, values.data()))
    source.refuse("cannot be read as numbers; is the file whole?");
  return values;
}

/// The library would make 2^63 - 1 of all that is larger.
std::vector<std::int64_t> read_unsigned(const Source& source, Piece piece) {
  const auto values = read_numbers<std::uint64_t>(source, piece, H5T_NATIVE_UINT64);
  const auto too_large = std::find_if(values.begin(), values.end(), [](std::uint64_t v) { return v > INT64_MAX; });
  if (too_large != values.end())
    source.refuse("holds " + std::to_string(*too_large) + " in row " +
                  std::to_string(piece.first + static_cast<std::size_t>(too_large - values.begin()) + 1) +
                  ", beyond the range of a 64-bit integer");
  return {values.begin(), values.end()};
}

/// Memory for the texts of a column, up to a limit: many rows can refer to one long text.
struct TextMemory {
  std::size_t left;  // bytes

  static void* take(std::size_t n, void* self) {
    auto& memory = *static_cast<TextMemory*>(self);
    if (n > memory.left) return nullptr;
    memory.left -= n;
    return std::malloc(n);
  }
  static void give_back(void* text, void*) { std::free(text); }
};

std::vector<std::string> read_variable_texts(const Source& source, Piece piece) {
  TextMemory memory{source.file_size + source.n_rows};  // the zero at the end of each is not in the file
  const Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  H5Pset_vlen_mem_manager(transfer.get(), TextMemory::take, &memory, TextMemory::give_back, nullptr);
  std::vector<char*> pointers(piece.n);
  const Handle type = variable_text_type();
  const bool done = read_rows(source.set.get(), type.get(), piece.first, piece.n, pointers.data(), transfer.get());
  std::vector<std::string> texts;
  texts.reserve(pointers.size());
  for (char* pointer : pointers) {
    if (done) texts.emplace_back(pointer == nullptr ? "" : pointer);
    std::free(pointer);
  }
  if (!done) source.refuse("cannot be read as texts of variable length; is the file whole?");
  return texts;
}

/// Of fixed length, filled up with zeros or blanks. Cells may be many times as long as what is in them: a few at a
/// time.
std::vector<std::string> read_fixed_texts(const Source& source, Piece piece) {
  const std::size_t width = source.type.size;
  if (width > kLongestRow_bytes) source.refuse("promises texts of " + std::to_string(width) + " bytes; is it whole?");
  const Handle in_file(H5Dget_type(source.set.get()), H5Tclose), type(H5Tcopy(in_file.get()), H5Tclose);
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  const std::size_t most = std::max<std::size_t>(kLongestRow_bytes / width, 1);
  std::vector<char> cells(std::min(most, piece.n) * width);
  std::vector<std::string> texts;
  texts.reserve(piece.n);
  for (std::size_t done = 0; done < piece.n; done = texts.size()) {
    const std::size_t n = std::min(most, piece.n - done);
    if (!read_rows(source.set.get(), type.get(), piece.first + done, n, cells.data()))
      source.refuse("cannot be read as texts; is the file whole?");
    for (std::size_t k = 0; k < n; ++k) {
      const char* cell = cells.data() + k * width;
      texts.emplace_back(cell, std::find(cell, cell + width, '\0'));
    }
  }
  return texts;
}

FoundType type_of(hid_t set) {
  const Handle type(H5Dget_type(set), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  return {kind, H5Tget_size(type.get()), kind == H5T_INTEGER && H5Tget_sign(type.get()) == H5T_SGN_NONE,
          kind == H5T_STRING && H5Tis_variable_str(type.get()) > 0};
}

/// Of a data set in chunks: rows of one; otherwise 0.
hsize_t chunk_rows(hid_t set) {
  const Handle list(H5Dget_create_plist(set), H5Pclose);
  hsize_t rows = 0;
  return H5Pget_layout(list.get()) == H5D_CHUNKED && H5Pget_chunk(list.get(), 1, &rows) == 1 ? rows : 0;
}

/// A header can promise any number of values that were never written, or pack them so that a few bytes become as many
/// as memory holds. No honest table has more rows than its file has bytes: each has a time or a speed of its own, which
/// no compression stores in less than a byte.
void check_size(const Source& source) {
  constexpr hsize_t kBytes_in_any_chunk = 1 << 24;  // a chunk may be larger than what is in it
  const FoundType& type = source.type;
  const auto lies = [&](const std::string& what) {
    source.refuse("promises " + what + " in a file of " + std::to_string(source.file_size) +
                  " bytes; is it whole? Write it again, without compression");
  };
  if (source.n_rows > source.file_size) lies(std::to_string(source.n_rows) + " rows");
  const Handle list(H5Dget_create_plist(source.set.get()), H5Pclose);
  if (H5Pget_layout(list.get()) == H5D_VIRTUAL || H5Pget_external_count(list.get()) > 0)
    source.refuse("keeps its values in another file; copy them into this one (h5repack)");
  const hsize_t chunk = chunk_rows(source.set.get());
  if (chunk >
      std::max<hsize_t>(sizeof(double) * source.file_size, kBytes_in_any_chunk) / std::max<std::size_t>(type.size, 1))
    lies("chunks of " + std::to_string(chunk) + " rows");
  const hsize_t stored = H5Dget_storage_size(source.set.get());
  const bool packed = H5Pget_nfilters(list.get()) > 0;
  // n_rows is at most the file's size: the product is checked by division
  if (stored > source.file_size || (source.n_rows > 0 && stored == 0) ||
      (!packed && source.n_rows > 0 && stored / source.n_rows < type.size))
    lies(std::to_string(source.n_rows) + " values of " + std::to_string(type.size) + " bytes where " +
         std::to_string(stored) + " are stored,");
}

void check_type(const Source& source) {
  const FoundType& found = source.type;
  const bool is_number = found.kind == H5T_FLOAT || found.kind == H5T_INTEGER;
  if (source.wanted == ColumnType::real && !is_number) source.refuse("holds another type than numbers");
  if (source.wanted == ColumnType::integer && (found.kind != H5T_INTEGER || found.size > sizeof(std::int64_t)))
    source.refuse("holds another type than 64-bit integers");
  if (source.wanted == ColumnType::text && found.kind != H5T_STRING) source.refuse("holds another type than text");
}

Column read_column(const Source& source, Piece piece) {
  if (source.wanted == ColumnType::real) return {source.column, read_numbers<double>(source, piece, H5T_NATIVE_DOUBLE)};
  if (source.wanted == ColumnType::integer)
    return {source.column, source.type.is_unsigned ? read_unsigned(source, piece)
                                                   : read_numbers<std::int64_t>(source, piece, H5T_NATIVE_INT64)};
  return {source.column,
          source.type.is_variable ? read_variable_texts(source, piece) : read_fixed_texts(source, piece)};
}

std::size_t length_of(hid_t set, const std::string& column, const std::string& path) {
  const Handle space(H5Dget_space(set), H5Sclose);
  if (H5Sget_simple_extent_ndims(space.get()) != 1)
    throw FileError(path, "column " + column + " is not one-dimensional");
  hsize_t size = 0;
  H5Sget_simple_extent_dims(space.get(), &size, nullptr);
  return static_cast<std::size_t>(size);
}

/// The data set of a column; not open where the column is optional and absent.
Handle data_set(hid_t file, const ColumnSpec& spec, const std::string& name) {
  const char* column = spec.name.c_str();
  if (H5Lexists(file, column, H5P_DEFAULT) <= 0) {
    if (spec.required) throw FileError(name, "column '" + spec.name + "' is missing");
    return {-1, H5Dclose};
  }
  H5L_info_t link{};
  if (H5Lget_info(file, column, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    throw FileError(name, "column '" + spec.name + "' is a link; copy the data set into this file (h5repack)");
  Handle set(H5Dopen2(file, column, H5P_DEFAULT), H5Dclose);
  if (!set.is_open()) throw FileError(name, "column '" + spec.name + "' is not a data set");
  return set;
}

/// Pieces are seldom chunks: one that is read again for each of them would be unpacked each time, unless it is kept.
Handle keeping_a_chunk(Handle set, hid_t file, const std::string& column, std::size_t value_size) {
  constexpr std::size_t kKept_bytes = 1 << 20;  // without being told
  const std::size_t chunk_bytes = chunk_rows(set.get()) * value_size;
  if (chunk_bytes <= kKept_bytes) return set;
  const Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access.get(), H5D_CHUNK_CACHE_NSLOTS_DEFAULT, chunk_bytes, H5D_CHUNK_CACHE_W0_DEFAULT);
  set = Handle(-1, H5Dclose);  // or the library would hand out the one that is open
  return {H5Dopen2(file, column.c_str(), access.get()), H5Dclose};
}

class Reader final : public TableReader {
 public:
  /// @param access  property list of the file's access, or H5P_DEFAULT
  Reader(const std::string& path, hid_t access, std::size_t file_size, const std::string& name,
         const std::vector<ColumnSpec>& wanted)
      : file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose) {
    if (!file_.is_open()) throw FileError(name, "is not an HDF5 file, or cut off, or not readable");
    for (const ColumnSpec& spec : wanted) {
      Handle set = data_set(file_.get(), spec, name);
      if (!set.is_open()) continue;
      const std::size_t n_rows = length_of(set.get(), spec.name, name);
      if (!sources_.empty() && n_rows != sources_.front().n_rows)
        throw FileError(name, "column " + spec.name + " has " + std::to_string(n_rows) + " rows where " +
                                  sources_.front().column + " has " + std::to_string(sources_.front().n_rows));
      const FoundType type = type_of(set.get());
      Source source{std::move(set), type, spec.type, n_rows, file_size, spec.name, name};
      check_size(source);
      check_type(source);
      source.set = keeping_a_chunk(std::move(source.set), file_.get(), spec.name, type.size);
      sources_.push_back(std::move(source));
    }
  }

  Table next(std::size_t max_rows) override {
    const std::size_t n_rows = sources_.empty() ? 0 : sources_.front().n_rows;
    const Piece piece{n_read_, std::min(max_rows, n_rows - n_read_)};
    Table table;
    for (const Source& source : sources_) table.columns.push_back(read_column(source, piece));
    table.n_before = piece.first;
    n_read_ += piece.n;
    return table;
  }

 private:
  Handle file_;
  std::vector<Source> sources_;
  std::size_t n_read_ = 0;
};

}  // namespace

std::unique_ptr<TableReader> hdf5_reader(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted) {
  silence_hdf5();
  const std::string name = input_name(path);
  const std::filesystem::path file = readable(path);
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error) throw FileError(name, "cannot be read: " + error.message());
  return std::make_unique<Reader>(file.string(), H5P_DEFAULT, size, name, wanted);
}

std::unique_ptr<TableReader> hdf5_reader(std::span<const std::byte> bytes, const std::string& name,
                                         const std::vector<ColumnSpec>& wanted) {
  silence_hdf5();
  constexpr std::size_t kGrowth_bytes = 1 << 16;  // of the image; nothing is written to it
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // the library copies the bytes. Without any it would open the file of this name
  if (bytes.empty() || H5Pset_fapl_core(access.get(), kGrowth_bytes, false) < 0 ||
      H5Pset_file_image(access.get(), const_cast<std::byte*>(bytes.data()), bytes.size()) < 0)
    throw FileError(name, "is not an HDF5 file");
  return std::make_unique<Reader>(name, access.get(), bytes.size(), name, wanted);
}

}  // namespace bouncelab::cli
