// SPDX-License-Identifier: GPL-3.0-or-later
/// The functions of HDF5 that hdf5_reader.cpp and hdf5_writer.cpp call, each of which loads the library at the first
/// call: it depends on 30 libraries, and a program linked with them starts in four times the time
/// (tests/bench/start_up.py). Most commands read and write no HDF5.
#include <hdf5.h>

#include "on_demand.hpp"

namespace {

/// @param name  of a function or variable of HDF5
/// @throws bouncelab::FileError
void* of_hdf5(const char* name) {
  return bouncelab::cli::loaded(BOUNCELAB_HDF5, name, "HDF5", "install it, or use .csv or .jsonl");
}

/// To the variable of the same name here.
void copy_id(hid_t& here, const char* name) { here = *static_cast<const hid_t*>(of_hdf5(name)); }

}  // namespace

extern "C" {
// identifiers that the library gives when it is opened: its macros, as H5T_NATIVE_DOUBLE, open it and then read these
hid_t H5P_CLS_DATASET_ACCESS_ID_g = H5I_INVALID_HID;
hid_t H5P_CLS_DATASET_CREATE_ID_g = H5I_INVALID_HID;
hid_t H5P_CLS_DATASET_XFER_ID_g = H5I_INVALID_HID;
hid_t H5P_CLS_FILE_ACCESS_ID_g = H5I_INVALID_HID;
hid_t H5T_C_S1_g = H5I_INVALID_HID;
hid_t H5T_NATIVE_DOUBLE_g = H5I_INVALID_HID;
hid_t H5T_NATIVE_INT64_g = H5I_INVALID_HID;
hid_t H5T_NATIVE_UINT64_g = H5I_INVALID_HID;

herr_t H5open() {
  static const auto its = reinterpret_cast<herr_t (*)()>(of_hdf5("H5open"));
  const herr_t result = its();
  copy_id(H5P_CLS_DATASET_ACCESS_ID_g, BOUNCELAB_TEXT_OF(H5P_CLS_DATASET_ACCESS_ID_g));
  copy_id(H5P_CLS_DATASET_CREATE_ID_g, BOUNCELAB_TEXT_OF(H5P_CLS_DATASET_CREATE_ID_g));
  copy_id(H5P_CLS_DATASET_XFER_ID_g, BOUNCELAB_TEXT_OF(H5P_CLS_DATASET_XFER_ID_g));
  copy_id(H5P_CLS_FILE_ACCESS_ID_g, BOUNCELAB_TEXT_OF(H5P_CLS_FILE_ACCESS_ID_g));
  copy_id(H5T_C_S1_g, BOUNCELAB_TEXT_OF(H5T_C_S1_g));
  copy_id(H5T_NATIVE_DOUBLE_g, BOUNCELAB_TEXT_OF(H5T_NATIVE_DOUBLE_g));
  copy_id(H5T_NATIVE_INT64_g, BOUNCELAB_TEXT_OF(H5T_NATIVE_INT64_g));
  copy_id(H5T_NATIVE_UINT64_g, BOUNCELAB_TEXT_OF(H5T_NATIVE_UINT64_g));
  return result;
}

BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5check_version, (unsigned major, unsigned minor, unsigned release),
                    (major, minor, release))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5dont_atexit, (), ())
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Aclose, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Acreate2,
                    (hid_t at, const char* name, hid_t type, hid_t space, hid_t list, hid_t access),
                    (at, name, type, space, list, access))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Awrite, (hid_t id, hid_t type, const void* values), (id, type, values))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Dclose, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Dcreate2,
                    (hid_t at, const char* name, hid_t type, hid_t space, hid_t link, hid_t list, hid_t access),
                    (at, name, type, space, link, list, access))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Dget_create_plist, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Dget_space, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hsize_t, H5Dget_storage_size, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Dget_type, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Dopen2, (hid_t at, const char* name, hid_t access), (at, name, access))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Dread,
                    (hid_t id, hid_t type, hid_t space, hid_t in_file, hid_t transfer, void* values),
                    (id, type, space, in_file, transfer, values))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Dset_extent, (hid_t id, const hsize_t* size), (id, size))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Dwrite,
                    (hid_t id, hid_t type, hid_t space, hid_t in_file, hid_t transfer, const void* values),
                    (id, type, space, in_file, transfer, values))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Eset_auto2, (hid_t stack, H5E_auto2_t function, void* data),
                    (stack, function, data))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Fclose, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Fcreate, (const char* name, unsigned flags, hid_t list, hid_t access),
                    (name, flags, list, access))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Fflush, (hid_t id, H5F_scope_t scope), (id, scope))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Fopen, (const char* name, unsigned flags, hid_t access), (name, flags, access))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Ldelete, (hid_t at, const char* name, hid_t access), (at, name, access))
BOUNCELAB_ON_DEMAND(of_hdf5, htri_t, H5Lexists, (hid_t at, const char* name, hid_t access), (at, name, access))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Lget_info, (hid_t at, const char* name, H5L_info_t* info, hid_t access),
                    (at, name, info, access))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Lmove,
                    (hid_t from, const char* name, hid_t to, const char* new_name, hid_t list, hid_t access),
                    (from, name, to, new_name, list, access))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pclose, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Pcreate, (hid_t type), (type))
BOUNCELAB_ON_DEMAND(of_hdf5, int, H5Pget_chunk, (hid_t id, int most, hsize_t* size), (id, most, size))
BOUNCELAB_ON_DEMAND(of_hdf5, int, H5Pget_external_count, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, H5D_layout_t, H5Pget_layout, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, int, H5Pget_nfilters, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pset_chunk, (hid_t id, int n, const hsize_t* size), (id, n, size))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pset_chunk_cache, (hid_t id, size_t n_slots, size_t n_bytes, double preemption),
                    (id, n_slots, n_bytes, preemption))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pset_deflate, (hid_t id, unsigned level), (id, level))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pset_fapl_core, (hid_t id, size_t growth, hbool_t is_written),
                    (id, growth, is_written))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pset_file_image, (hid_t id, void* bytes, size_t n), (id, bytes, n))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pset_obj_track_times, (hid_t id, hbool_t on), (id, on))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pset_shuffle, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Pset_vlen_mem_manager,
                    (hid_t id, H5MM_allocate_t take, void* of_take, H5MM_free_t give_back, void* of_give_back),
                    (id, take, of_take, give_back, of_give_back))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Sclose, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Screate, (H5S_class_t type), (type))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Screate_simple, (int n, const hsize_t* size, const hsize_t* most),
                    (n, size, most))
BOUNCELAB_ON_DEMAND(of_hdf5, int, H5Sget_simple_extent_dims, (hid_t id, hsize_t* size, hsize_t* most), (id, size, most))
BOUNCELAB_ON_DEMAND(of_hdf5, int, H5Sget_simple_extent_ndims, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Sselect_hyperslab,
                    (hid_t id, H5S_seloper_t operation, const hsize_t* first, const hsize_t* stride, const hsize_t* n,
                     const hsize_t* block),
                    (id, operation, first, stride, n, block))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Tclose, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, hid_t, H5Tcopy, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, H5T_class_t, H5Tget_class, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, H5T_sign_t, H5Tget_sign, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, size_t, H5Tget_size, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, htri_t, H5Tis_variable_str, (hid_t id), (id))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Tset_cset, (hid_t id, H5T_cset_t set), (id, set))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Tset_size, (hid_t id, size_t size), (id, size))
BOUNCELAB_ON_DEMAND(of_hdf5, herr_t, H5Tset_strpad, (hid_t id, H5T_str_t padding), (id, padding))
}
