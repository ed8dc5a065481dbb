// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_table.hpp"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"

namespace bouncelab::cli {
namespace {

/// An HDF5 identifier and how to close it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  hid_t get() const { return id_; }
  bool is_open() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// The library prints its errors unless told not to; ours are exceptions.
void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Handle text_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return {type, H5Tclose};
}

void write_column(hid_t file, const std::string& column, hid_t type, std::size_t n_rows, const void* values,
                  const std::string& name) {
  const std::array<hsize_t, 1> size{n_rows};
  const Handle space(H5Screate_simple(1, size.data(), nullptr), H5Sclose);
  const Handle set(H5Dcreate2(file, column.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                   H5Dclose);
  if (!set.is_open() || (n_rows > 0 && H5Dwrite(set.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0))
    throw FileError(name, "column " + column + " cannot be written; is the disk full?");
}

/// One column of an open file.
struct Source {
  hid_t set;
  std::size_t n_rows;
  std::size_t file_size;  // bytes
  std::string column;
  std::string path;

  [[noreturn]] void refuse(const std::string& what) const { throw FileError(path, "column " + column + " " + what); }
};

template <class T>
std::vector<T> read_numbers(const Source& source, hid_t type) {
  std::vector<T> values(source.n_rows);
  if (source.n_rows > 0 && H5Dread(source.set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    source.refuse("cannot be read as numbers; is the file whole?");
  return values;
}

/// The library would make 2^63 - 1 of all that is larger.
std::vector<std::int64_t> read_unsigned(const Source& source) {
  const auto values = read_numbers<std::uint64_t>(source, H5T_NATIVE_UINT64);
  const auto too_large = std::find_if(values.begin(), values.end(), [](std::uint64_t v) { return v > INT64_MAX; });
  if (too_large != values.end())
    source.refuse("holds " + std::to_string(*too_large) + " in row " + std::to_string(too_large - values.begin() + 1) +
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

std::vector<std::string> read_texts(const Source& source) {
  TextMemory memory{source.file_size + source.n_rows};  // the zero at the end of each is not in the file
  const Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  H5Pset_vlen_mem_manager(transfer.get(), TextMemory::take, &memory, TextMemory::give_back, nullptr);
  std::vector<char*> pointers(source.n_rows);
  const Handle type = text_type();
  const Handle space(H5Dget_space(source.set), H5Sclose);
  const bool done =
      source.n_rows == 0 || H5Dread(source.set, type.get(), H5S_ALL, H5S_ALL, transfer.get(), pointers.data()) >= 0;
  std::vector<std::string> texts;
  texts.reserve(pointers.size());
  for (char* pointer : pointers) {
    if (done) texts.emplace_back(pointer == nullptr ? "" : pointer);
    std::free(pointer);
  }
  if (!done) source.refuse("cannot be read as texts of variable length; is the file whole?");
  return texts;
}

struct FoundType {
  H5T_class_t kind;
  std::size_t size;  // bytes of one value in the file
  bool is_unsigned;
};

FoundType type_of(hid_t set) {
  const Handle type(H5Dget_type(set), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  return {kind, H5Tget_size(type.get()), kind == H5T_INTEGER && H5Tget_sign(type.get()) == H5T_SGN_NONE};
}

/// A header can promise any number of values that were never written, or pack them so that a few bytes become as many
/// as memory holds. No honest table has more rows than its file has bytes: each has a time or a speed of its own, which
/// no compression stores in less than a byte.
void check_size(const Source& source, const FoundType& type) {
  constexpr hsize_t kRows_in_any_chunk = 1 << 20;  // a chunk may be larger than what is in it
  const auto lies = [&](const std::string& what) {
    source.refuse("promises " + what + " in a file of " + std::to_string(source.file_size) +
                  " bytes; is it whole? Write it again, without compression");
  };
  if (source.n_rows > source.file_size) lies(std::to_string(source.n_rows) + " rows");
  const Handle list(H5Dget_create_plist(source.set), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(list.get());
  if (layout == H5D_VIRTUAL || H5Pget_external_count(list.get()) > 0)
    source.refuse("keeps its values in another file; copy them into this one (h5repack)");
  hsize_t chunk = 0;
  if (layout == H5D_CHUNKED && H5Pget_chunk(list.get(), 1, &chunk) == 1 &&
      chunk > std::max<hsize_t>(source.file_size, kRows_in_any_chunk))
    lies("chunks of " + std::to_string(chunk) + " rows");
  const hsize_t stored = H5Dget_storage_size(source.set);
  const bool packed = H5Pget_nfilters(list.get()) > 0;
  // n_rows is at most the file's size: the product is checked by division
  if (stored > source.file_size || (source.n_rows > 0 && stored == 0) ||
      (!packed && source.n_rows > 0 && stored / source.n_rows < type.size))
    lies(std::to_string(source.n_rows) + " values of " + std::to_string(type.size) + " bytes where " +
         std::to_string(stored) + " are stored,");
}

Column read_column(const Source& source, ColumnType wanted) {
  const FoundType found = type_of(source.set);
  check_size(source, found);
  const bool is_number = found.kind == H5T_FLOAT || found.kind == H5T_INTEGER;
  if (wanted == ColumnType::real && is_number) return {source.column, read_numbers<double>(source, H5T_NATIVE_DOUBLE)};
  if (wanted == ColumnType::integer && found.kind == H5T_INTEGER && found.size <= sizeof(std::int64_t))
    return {source.column,
            found.is_unsigned ? read_unsigned(source) : read_numbers<std::int64_t>(source, H5T_NATIVE_INT64)};
  if (wanted == ColumnType::text && found.kind == H5T_STRING) return {source.column, read_texts(source)};
  source.refuse(std::string("holds another type than ") + (wanted == ColumnType::real      ? "numbers"
                                                           : wanted == ColumnType::integer ? "64-bit integers"
                                                                                           : "text"));
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
  const hid_t set = H5Dopen2(file, column, H5P_DEFAULT);
  if (set < 0) throw FileError(name, "column '" + spec.name + "' is not a data set");
  return {set, H5Dclose};
}

Table read_columns(hid_t file, std::size_t file_size, const std::string& name, const std::vector<ColumnSpec>& wanted) {
  Table table;
  for (const ColumnSpec& spec : wanted) {
    const Handle set = data_set(file, spec, name);
    if (!set.is_open()) continue;
    const std::size_t n_rows = length_of(set.get(), spec.name, name);
    if (!table.columns.empty() && n_rows != table.n_rows())
      throw FileError(name, "column " + spec.name + " has " + std::to_string(n_rows) + " rows where " +
                                table.columns.front().name + " has " + std::to_string(table.n_rows()));
    table.columns.push_back(read_column({set.get(), n_rows, file_size, spec.name, name}, spec.type));
  }
  return table;
}

/// @param access  property list of the file's access, or H5P_DEFAULT
Table read_file(const std::string& path, hid_t access, std::size_t file_size, const std::string& name,
                const std::vector<ColumnSpec>& wanted) {
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
  if (!file.is_open()) throw FileError(name, "is not an HDF5 file, or cut off, or not readable");
  return read_columns(file.get(), file_size, name, wanted);
}

}  // namespace

Table read_hdf5(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted) {
  silence();
  const std::string name = input_name(path);
  const std::filesystem::path file = readable(path);
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error) throw FileError(name, "cannot be read: " + error.message());
  return read_file(file.string(), H5P_DEFAULT, size, name, wanted);
}

Table read_hdf5(std::span<const std::byte> bytes, const std::string& name, const std::vector<ColumnSpec>& wanted) {
  silence();
  constexpr std::size_t kGrowth_bytes = 1 << 16;  // of the image; nothing is written to it
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // the library copies the bytes. Without any it would open the file of this name
  if (bytes.empty() || H5Pset_fapl_core(access.get(), kGrowth_bytes, false) < 0 ||
      H5Pset_file_image(access.get(), const_cast<std::byte*>(bytes.data()), bytes.size()) < 0)
    throw FileError(name, "is not an HDF5 file");
  return read_file(name, access.get(), bytes.size(), name, wanted);
}

void write_hdf5(const std::filesystem::path& path, const Table& table, const std::string& name) {
  silence();
  const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  if (!file.is_open()) throw FileError(name, "cannot be created as an HDF5 file; is the disk full?");
  for (const Column& column : table.columns) {
    const std::size_t n_rows = std::visit([](const auto& values) { return values.size(); }, column.values);
    if (const auto* reals = std::get_if<std::vector<double>>(&column.values)) {
      write_column(file.get(), column.name, H5T_NATIVE_DOUBLE, n_rows, reals->data(), name);
    } else if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&column.values)) {
      write_column(file.get(), column.name, H5T_NATIVE_INT64, n_rows, integers->data(), name);
    } else {
      std::vector<const char*> pointers;
      for (const std::string& text : std::get<std::vector<std::string>>(column.values))
        pointers.push_back(text.c_str());
      write_column(file.get(), column.name, text_type().get(), n_rows, pointers.data(), name);
    }
  }
  if (H5Fflush(file.get(), H5F_SCOPE_GLOBAL) < 0) throw FileError(name, "writing failed; is the disk full?");
}

}  // namespace bouncelab::cli
