// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_module.hpp"

/// kHdf5Entry
extern "C" __attribute__((visibility("default")))
const bouncelab::cli::Hdf5Functions bouncelab_hdf5_functions{bouncelab::cli::hdf5_reader, bouncelab::cli::hdf5_writer};
