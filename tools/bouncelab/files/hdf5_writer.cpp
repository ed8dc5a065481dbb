// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string_view>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "files/hdf5_handle.hpp"
#include "files/hdf5_table.hpp"

namespace bouncelab::cli {
namespace {

/// The unit that a column's name ends with, as UDUNITS writes it ("m s-1"); empty where it ends with none.
std::string_view unit_of(std::string_view column) {
  using Unit = std::pair<std::string_view, std::string_view>;
  constexpr std::array<Unit, 11> kUnits{{{"_s", "s"},
                                         {"_m", "m"},
                                         {"_mps", "m s-1"},
                                         {"_mps2", "m s-2"},
                                         {"_radps", "rad s-1"},
                                         {"_rad", "rad"},
                                         {"_deg", "degree"},
                                         {"_hz", "Hz"},
                                         {"_db", "dB"},
                                         {"_j", "J"},
                                         {"_kgpm3", "kg m-3"}}};
  const auto found =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return column.ends_with(u.first); });
  return found == kUnits.end() ? std::string_view{} : found->second;
}

// Texts are nearly always those of the row before: compressed, one of fixed length takes a byte or so and is read ten
// times as fast as one of variable length, which is an object of its own in the file.
constexpr std::size_t kShortestFixed_bytes = 16, kLongestFixed_bytes = 256;
constexpr std::size_t kVariable = 0;

/// Of a column of texts, the longest of which has so many bytes. Powers of two: a column is seldom made wider.
std::size_t width_for(std::size_t longest) {
  return longest > kLongestFixed_bytes ? kVariable : std::bit_ceil(std::max(longest, kShortestFixed_bytes));
}

std::size_t longest_of(std::span<const std::string> texts) {
  std::size_t longest = 0;
  for (const std::string& text : texts) longest = std::max(longest, text.size());
  return longest;
}

Handle fixed_text_type(std::size_t width) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, width);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return {type, H5Tclose};
}

/// Compared by their bytes: NaN is the same as NaN.
bool are_all_same(std::span<const double> reals) {
  const auto bits = [](double real) { return std::bit_cast<std::uint64_t>(real); };
  return std::all_of(reals.begin(), reals.end(), [&](double real) { return bits(real) == bits(reals.front()); });
}

/// Rows first ... first + n of a column.
struct Slice {
  const Column& column;
  std::size_t first, n;

  /// Of T, or nothing where the column is of another type.
  template <class T>
  std::span<const T> of() const {
    const auto* values = std::get_if<std::vector<T>>(&column.values);
    return values == nullptr ? std::span<const T>() : std::span(*values).subspan(first, n);
  }
  bool is_text() const { return std::holds_alternative<std::vector<std::string>>(column.values); }
};

/// A column in the file.
struct StoredColumn {
  Handle set;
  std::size_t width = kVariable;  // of texts [bytes]
};

class Writer final : public TableSink {
 public:
  Writer(const std::filesystem::path& path, std::string name)
      : name_(std::move(name)), file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose) {
    if (!file_.is_open()) throw FileError(name_, "cannot be created as an HDF5 file; is the disk full?");
  }

  void add(const Table& rows) override {
    const std::size_t n = rows.n_rows();
    if (waiting_.columns.empty())
      for (const Column& column : rows.columns) waiting_.columns.push_back(without_values(column));
    check_columns(rows);
    std::size_t done = std::min(n, kPiece_rows - waiting_.n_rows());
    append_to_waiting(rows, 0, done);
    if (waiting_.n_rows() < kPiece_rows) return;
    write_waiting();
    for (; n - done >= kPiece_rows; done += kPiece_rows) write(rows, done, kPiece_rows);
    append_to_waiting(rows, done, n - done);
  }

  void finish() override {
    if (waiting_.n_rows() > 0 || stored_.empty()) write_waiting();
    stored_.clear();
    if (H5Fflush(file_.get(), H5F_SCOPE_GLOBAL) < 0) throw FileError(name_, "writing failed; is the disk full?");
  }

 private:
  static Column without_values(const Column& column) {
    return {column.name,
            std::visit([](const auto& values) -> decltype(Column::values) { return std::decay_t<decltype(values)>{}; },
                       column.values)};
  }

  void check_columns(const Table& rows) const {
    const auto agree = [&](const Column& a, const Column& b) {
      const std::size_t n = std::visit([](const auto& values) { return values.size(); }, b.values);
      return a.name == b.name && a.values.index() == b.values.index() && n == rows.n_rows();
    };
    if (!std::equal(waiting_.columns.begin(), waiting_.columns.end(), rows.columns.begin(), rows.columns.end(), agree))
      throw InvalidArgument(name_ + ": the columns of a piece differ in length, or from those of the table");
  }

  /// So that whole chunks are written, whatever the pieces.
  void append_to_waiting(const Table& rows, std::size_t first, std::size_t n) {
    for (std::size_t k = 0; k < rows.columns.size(); ++k)
      std::visit(
          [&](auto& values) {
            const auto& more = std::get<std::decay_t<decltype(values)>>(rows.columns[k].values);
            const auto begin = more.begin() + static_cast<std::ptrdiff_t>(first);
            values.insert(values.end(), begin, begin + static_cast<std::ptrdiff_t>(n));
          },
          waiting_.columns[k].values);
  }

  void write_waiting() {
    write(waiting_, 0, waiting_.n_rows());
    for (Column& column : waiting_.columns) std::visit([](auto& values) { values.clear(); }, column.values);
  }

  void write(const Table& rows, std::size_t first, std::size_t n) {
    if (stored_.empty()) {
      chunk_rows_ = std::max<std::size_t>(n, 1);
      for (const Column& column : rows.columns) stored_.push_back(stored(Slice{column, first, n}));
    }
    for (std::size_t k = 0; k < stored_.size(); ++k) write(Slice{rows.columns[k], first, n}, stored_[k]);
    n_written_ += n;
  }

  [[noreturn]] void fail(const std::string& column) const {
    throw FileError(name_, "column " + column + " cannot be written; is the disk full?");
  }

  /// @param column  its first rows
  StoredColumn stored(const Slice& column) const {
    const std::string& name = column.column.name;
    if (column.is_text()) {
      const std::size_t width = width_for(longest_of(column.of<std::string>()));
      return {create(name, text_type(width).get(), true), width};
    }
    if (const auto reals = column.of<double>(); std::holds_alternative<std::vector<double>>(column.column.values))
      return {create(name, H5T_NATIVE_DOUBLE, are_all_same(reals)), kVariable};
    return {create(name, H5T_NATIVE_INT64, true), kVariable};
  }

  static Handle text_type(std::size_t width) {
    return width == kVariable ? variable_text_type() : fixed_text_type(width);
  }

  /// The last digits of what is measured are noise: compression would take a quarter of reals that vary, and most of
  /// the time of writing.
  Handle create(const std::string& name, hid_t type, bool is_compressed) const {
    const hsize_t none = 0, any = H5S_UNLIMITED, chunk = chunk_rows_;
    const Handle space(H5Screate_simple(1, &none, &any), H5Sclose);
    const Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(list.get(), 1, &chunk);
    H5Pset_obj_track_times(list.get(), false);  // the same rows are the same bytes at any time
    constexpr unsigned kFast = 1;
    if (is_compressed) H5Pset_shuffle(list.get());
    if (is_compressed) H5Pset_deflate(list.get(), kFast);
    Handle set(H5Dcreate2(file_.get(), name.c_str(), type, space.get(), H5P_DEFAULT, list.get(), H5P_DEFAULT),
               H5Dclose);
    if (!set.is_open()) fail(name);
    if (const std::string_view unit = unit_of(name); !unit.empty()) write_unit(set.get(), unit);
    return set;
  }

  void write_unit(hid_t set, std::string_view unit) const {
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type.get(), unit.size());
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle units(H5Acreate2(set, "units", type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!units.is_open() || H5Awrite(units.get(), type.get(), unit.data()) < 0)
      throw FileError(name_, "the units of a column cannot be written; is the disk full?");
  }

  void write(const Slice& rows, StoredColumn& stored) {
    const std::string& name = rows.column.name;
    if (rows.is_text()) return write_texts(rows, stored);
    if (const auto reals = rows.of<double>(); !reals.empty())
      append(stored.set.get(), H5T_NATIVE_DOUBLE, n_written_, reals.size(), reals.data(), name);
    if (const auto integers = rows.of<std::int64_t>(); !integers.empty())
      append(stored.set.get(), H5T_NATIVE_INT64, n_written_, integers.size(), integers.data(), name);
  }

  void append(hid_t set, hid_t type, std::size_t first, std::size_t n, const void* values,
              const std::string& name) const {
    const hsize_t length = first + n;
    if (H5Dset_extent(set, &length) < 0 || !write_rows(set, type, first, n, values)) fail(name);
  }

  void write_texts(const Slice& rows, StoredColumn& stored) {
    const auto texts = rows.of<std::string>();
    const std::size_t longest = longest_of(texts);
    if (stored.width != kVariable && longest > stored.width) widen(rows.column.name, width_for(longest), stored);
    if (stored.width == kVariable) {
      std::vector<const char*> pointers;
      for (const std::string& text : texts) pointers.push_back(text.c_str());
      append(stored.set.get(), text_type(kVariable).get(), n_written_, texts.size(), pointers.data(), rows.column.name);
      return;
    }
    std::vector<char> cells(texts.size() * stored.width);
    for (std::size_t k = 0; k < texts.size(); ++k)
      std::copy(texts[k].begin(), texts[k].end(), cells.begin() + static_cast<std::ptrdiff_t>(k * stored.width));
    append(stored.set.get(), text_type(stored.width).get(), n_written_, texts.size(), cells.data(), rows.column.name);
  }

  /// Copies what was written to a new data set, which takes the place of the old one.
  void widen(const std::string& name, std::size_t width, StoredColumn& stored) {
    const std::string copy = name + " (wider)";
    StoredColumn wider{create(copy, text_type(width).get(), true), width};
    const std::size_t cell = stored.width + 1;  // with a zero at the end
    const Handle type = fixed_text_type(width == kVariable ? cell : width);
    for (std::size_t first = 0; first < n_written_; first += chunk_rows_) {
      const std::size_t n = std::min(chunk_rows_, n_written_ - first);
      std::vector<char> cells(n * H5Tget_size(type.get()));
      if (!read_rows(stored.set.get(), type.get(), first, n, cells.data())) fail(name);
      if (width != kVariable) {
        append(wider.set.get(), type.get(), first, n, cells.data(), name);
        continue;
      }
      std::vector<const char*> pointers;
      for (std::size_t k = 0; k < n; ++k) pointers.push_back(cells.data() + k * cell);
      append(wider.set.get(), text_type(kVariable).get(), first, n, pointers.data(), name);
    }
    stored = std::move(wider);
    if (H5Ldelete(file_.get(), name.c_str(), H5P_DEFAULT) < 0 ||
        H5Lmove(file_.get(), copy.c_str(), file_.get(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0)
      fail(name);
  }

  std::string name_;
  Handle file_;
  std::size_t chunk_rows_ = 0, n_written_ = 0;
  Table waiting_;  // for a whole chunk; its columns are those of the table
  std::vector<StoredColumn> stored_;
};

}  // namespace

std::unique_ptr<TableSink> hdf5_writer(const std::filesystem::path& path, const std::string& name) {
  H5dont_atexit();  // the library crashes at the end of a process in which a file could not be written
  silence_hdf5();
  return std::make_unique<Writer>(path, name);
}

}  // namespace bouncelab::cli
