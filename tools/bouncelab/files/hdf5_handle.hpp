// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <utility>

namespace bouncelab::cli {

/// An HDF5 identifier and how to close it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
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
inline void silence_hdf5() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

/// Texts of variable length.
inline Handle variable_text_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return {type, H5Tclose};
}

/// Rows of a data set, and the memory that they are read to or written from.
struct Hdf5Rows {
  Handle in_file, in_memory;

  Hdf5Rows(hid_t set, std::size_t first, std::size_t n)
      : in_file(H5Dget_space(set), H5Sclose), in_memory(simple(n), H5Sclose) {
    const hsize_t begin = first, count = n;
    H5Sselect_hyperslab(in_file.get(), H5S_SELECT_SET, &begin, nullptr, &count, nullptr);
  }

 private:
  static hid_t simple(hsize_t n) { return H5Screate_simple(1, &n, nullptr); }
};

inline bool read_rows(hid_t set, hid_t type, std::size_t first, std::size_t n, void* values,
                      hid_t transfer = H5P_DEFAULT) {
  const Hdf5Rows rows(set, first, n);
  return n == 0 || H5Dread(set, type, rows.in_memory.get(), rows.in_file.get(), transfer, values) >= 0;
}

inline bool write_rows(hid_t set, hid_t type, std::size_t first, std::size_t n, const void* values) {
  const Hdf5Rows rows(set, first, n);
  return n == 0 || H5Dwrite(set, type, rows.in_memory.get(), rows.in_file.get(), H5P_DEFAULT, values) >= 0;
}

}  // namespace bouncelab::cli
