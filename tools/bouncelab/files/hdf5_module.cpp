// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_module.hpp"

#include "files/hdf5_table.hpp"

/// kHdf5Entry
extern "C" __attribute__((visibility("default")))
const bouncelab::cli::Hdf5Functions bouncelab_hdf5_functions{bouncelab::cli::read_hdf5, bouncelab::cli::write_hdf5};
