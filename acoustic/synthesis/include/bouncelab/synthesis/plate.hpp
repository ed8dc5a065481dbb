// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bouncelab/core/ball.hpp"

namespace bouncelab::synthesis {

/// Rectangular plate with free edges, centred at the origin, sides along x and y. Defaults: the paper's glass plate.
struct RectangularPlate {
  double length_x_m = 0.30;
  double length_y_m = 0.20;
  double thickness_m = 0.019;
  Material material = kGlass;
};

/// Circular disk with a free edge, lying on the middle of the rectangular plate.
struct CircularDisk {
  double radius_m = 0.05;
  double thickness_m = 0.006;
  Material material = kSiliconCarbide;
};

/// Decay rate of the amplitude of a mode: eta omega / 2 + support, in 1/s.
struct Damping {
  double loss_factor = 2e-3;    ///< eta of the material with its surroundings, >= 0
  double support_per_s = 80.0;  ///< loss through feet and sensor, the same for all modes, >= 0
};

/// The ground the ball bounces on.
struct Ground {
  RectangularPlate carrier;
  Damping carrier_damping;
  std::optional<CircularDisk> disk;  ///< absent: the ball falls on the carrier itself
  Damping disk_damping;              ///< of the disk with the layer it lies on
  double disk_coupling = 0.2;        ///< share of the disk's own motion that reaches the sensors on the carrier
};

/// The ground for a plate by its material. Glass, silicon carbide and Vitreloy are the paper's three, the latter two as
/// disks on the glass plate; the paper gives neither the disks' size nor any damping: radius 5 cm, thickness 6 mm and
/// the loss factors (glass 2e-3, SiC 1e-3, Vitreloy 2e-3 with their layer) are our assumptions. Of any other material
/// the plate has the size of the paper's, and the catalogue's loss factor, or that of glass where it has none.
Ground ground_of(const Material& plate);

/// The material the ball touches.
const Material& contact_material(const Ground& ground);
/// Does (x, y) lie on the surface the ball falls on?
bool contains(const Ground& ground, double x_m, double y_m);

/// A damped flexural mode. Its displacement under a point force F at x_i, seen at x_s, is
/// phi(x_i) phi(x_s) / mass * (F convolved with exp(-decay t) sin(omega t) / omega).
struct PlateMode {
  double frequency_hz = 0.0;  ///< of the damped oscillation
  double decay_per_s = 0.0;
  double mass_kg = 0.0;  ///< of shapes scaled to mean square 1: the body's mass
  bool of_disk = false;
};

/// Flexural modes of a ground from thin-plate theory with free edges.
///
/// Rectangle: Rayleigh-Ritz with products of Legendre polynomials (the method of Leissa, J. Sound Vib. 31, 257 (1973),
/// doi:10.1016/S0022-460X(73)80371-2, carried to convergence: frequencies within 1e-4). Disk: exact Bessel solutions
/// (Itao & Crandall, J. Appl. Mech. 46, 448 (1979), doi:10.1115/1.3424569); every mode with nodal diameters twice.
/// Both frequencies are then lowered from Kirchhoff's to Mindlin's dispersion at the same wavenumber (J. Appl. Mech.
/// 18, 31 (1951), shear factor pi^2/12), because at 40 kHz the bending wave is only three thicknesses long. Assumes the
/// disk moves freely on the carrier and adds neither mass nor stiffness to it; rigid-body motion is left out.
class PlateModes {
 public:
  /// @param max_frequency_hz  modes above are left out, > 0
  PlateModes(const Ground& ground, double max_frequency_hz);
  ~PlateModes();
  PlateModes(PlateModes&&) noexcept;
  PlateModes& operator=(PlateModes&&) noexcept;

  /// By rising frequency, carrier before disk.
  const std::vector<PlateMode>& modes() const { return modes_; }
  /// Values of all mode shapes where the ball touches (x, y): on the disk where there is one, on the carrier otherwise;
  /// carrier modes are taken under the disk. @param shapes  modes().size() values
  void shapes_under_ball(double x_m, double y_m, std::span<double> shapes) const;
  /// The same as seen by a sensor on the carrier: disk modes count with disk_coupling.
  void shapes_under_sensor(double x_m, double y_m, std::span<double> shapes) const;

 private:
  struct Shapes;
  Ground ground_;
  std::vector<PlateMode> modes_;
  std::unique_ptr<Shapes> shapes_;
};

/// Frequency [Hz] of a flexural wave of wavenumber k in a plate of Mindlin's theory; Kirchhoff's for k h -> 0.
double mindlin_frequency_hz(double k_per_m, double thickness_m, const Material& material);
/// Speed of Rayleigh's surface wave, by which the start of contact travels: c_s (0.862 + 1.14 nu) / (1 + nu), within
/// 0.5% (Viktorov 1967).
double rayleigh_speed_mps(const Material& material);

}  // namespace bouncelab::synthesis
