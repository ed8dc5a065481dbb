// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_table.hpp"

#include <hdf5.h>

#include <array>
#include <cstdint>

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

struct Source {
  hid_t set;
  std::size_t n_rows;
  std::string column;
  std::string path;
};

template <class T>
std::vector<T> read_numbers(const Source& source, hid_t type) {
  std::vector<T> values(source.n_rows);
  if (source.n_rows > 0 && H5Dread(source.set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw FileError(source.path, "column " + source.column + " cannot be read as numbers; is the file whole?");
  return values;
}

std::vector<std::string> read_texts(const Source& source) {
  std::vector<char*> pointers(source.n_rows);
  const Handle type = text_type();
  const Handle space(H5Dget_space(source.set), H5Sclose);
  if (source.n_rows > 0 && H5Dread(source.set, type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0)
    throw FileError(source.path, "column " + source.column + " cannot be read as text; is the file whole?");
  std::vector<std::string> texts;
  texts.reserve(pointers.size());
  for (const char* pointer : pointers) texts.emplace_back(pointer == nullptr ? "" : pointer);
  if (source.n_rows > 0) H5Dvlen_reclaim(type.get(), space.get(), H5P_DEFAULT, pointers.data());
  return texts;
}

H5T_class_t class_of(hid_t set) {
  const Handle type(H5Dget_type(set), H5Tclose);
  return H5Tget_class(type.get());
}

Column read_column(const Source& source, ColumnType wanted) {
  const H5T_class_t found = class_of(source.set);
  const bool is_number = found == H5T_FLOAT || found == H5T_INTEGER;
  if (wanted == ColumnType::real && is_number) return {source.column, read_numbers<double>(source, H5T_NATIVE_DOUBLE)};
  if (wanted == ColumnType::integer && found == H5T_INTEGER)
    return {source.column, read_numbers<std::int64_t>(source, H5T_NATIVE_INT64)};
  if (wanted == ColumnType::text && found == H5T_STRING) return {source.column, read_texts(source)};
  throw FileError(source.path, "column " + source.column + " holds another type than " +
                                   (wanted == ColumnType::real      ? "numbers"
                                    : wanted == ColumnType::integer ? "integers"
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

}  // namespace

Table read_hdf5(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted) {
  silence();
  const std::string name = input_name(path);
  const Handle file(H5Fopen(readable(path).c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.is_open()) throw FileError(name, "is not an HDF5 file, or cut off, or not readable");
  Table table;
  for (const ColumnSpec& spec : wanted) {
    if (H5Lexists(file.get(), spec.name.c_str(), H5P_DEFAULT) <= 0) {
      if (spec.required) throw FileError(name, "column '" + spec.name + "' is missing");
      continue;
    }
    const Handle set(H5Dopen2(file.get(), spec.name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.is_open()) throw FileError(name, "column '" + spec.name + "' is not a data set");
    const std::size_t n_rows = length_of(set.get(), spec.name, name);
    if (!table.columns.empty() && n_rows != table.n_rows())
      throw FileError(name, "column " + spec.name + " has " + std::to_string(n_rows) + " rows where " +
                                table.columns.front().name + " has " + std::to_string(table.n_rows()));
    table.columns.push_back(read_column({set.get(), n_rows, spec.name, name}, spec.type));
  }
  return table;
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
