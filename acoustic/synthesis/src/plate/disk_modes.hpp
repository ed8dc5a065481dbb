// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

namespace bouncelab::synthesis {

/// One mode of a thin free disk of radius a:  phi = scale [J_n(k r) + mix I_n(k r)] cos(n theta - phase), mean
/// square 1.
struct DiskMode {
  int n_diameters = 0;
  double wavenumber_per_m = 0.0;
  double mix = 0.0;
  double scale = 1.0;
  double phase_rad = 0.0;  ///< 0 and pi/2: the two members of a pair
};

/// Modes of a free thin disk up to a wavenumber, by rising wavenumber, rigid-body motion left out.
/// Frequency equation: A. W. Leissa, Vibration of Plates, NASA SP-160 (1969), eq. (2.12).
std::vector<DiskMode> free_disk_modes(double radius_m, double poisson_ratio, double max_wavenumber_per_m);

/// phi of every mode at (x, y), inside the disk. @param shapes  modes.size() values
void disk_shapes_at(const std::vector<DiskMode>& modes, double x_m, double y_m, std::span<double> shapes);

}  // namespace bouncelab::synthesis
