// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

namespace bouncelab {

/// Linear elastic material, of a ball or of the plate it falls on.
struct Material {
  double youngs_modulus_pa = 0.0;  ///< > 0 [Pa]; not used where not hertzian
  double poisson_ratio = 0.0;      ///< in [0, 0.5); likewise
  double density_kgpm3 = 0.0;      ///< > 0 [kg/m^3]
  /// Whether E and nu describe a contact by Hertz's theory: massive, isotropic and stiff. Not a shell (it bends), not
  /// rubber (contact as large as the ball, modulus by rate), not wood (modulus by direction), not layers.
  bool hertzian = true;

  friend bool operator==(const Material&, const Material&) = default;
};

/// Bearing steel of Montaine et al., Phys. Rev. E 84, 041306 (2011), doi:10.1103/PhysRevE.84.041306.
inline constexpr Material kSteel{200e9, 0.30, 7900.0};
/// Hard (soda-lime) glass, the paper's ground plate.
inline constexpr Material kGlass{70e9, 0.22, 2500.0};
/// Sintered silicon carbide, one of the paper's two disks.
inline constexpr Material kSiliconCarbide{410e9, 0.14, 3100.0};
/// Vitreloy (Zr-based bulk metallic glass), the other disk.
inline constexpr Material kVitreloy{96e9, 0.36, 6100.0};

/// J/(m R^2) of a homogeneous sphere; 2/3 of a thin shell.
inline constexpr double kSolidBallInertia = 0.4;

/// A ball, solid or hollow. Defaults: the paper's stainless-steel bearing ball.
struct Ball {
  double radius_m = 3.0e-3;                   ///< > 0 [m]
  Material material = kSteel;                 ///< its density is the mean one: mass over volume of the sphere
  double inertia_factor = kSolidBallInertia;  ///< J/(m R^2), in (0, 1]
  std::optional<double> contact_time_s =
      std::nullopt;  ///< measured, taken for all speeds and plates, > 0 [s]; absent: by Hertz

  friend bool operator==(const Ball&, const Ball&) = default;
};

/// 4/3 pi rho R^3 [kg], rho the mean density.
double mass_kg(const Ball& ball);
/// inertia_factor m R^2 [kg m^2]; the asperities' mass is neglected (mass ratio 1e-9).
double moment_of_inertia_kgm2(const Ball& ball);
/// J/(m R^2) of a homogeneous spherical shell, (2/5) (1 - a^5) / (1 - a^3), a its inner over its outer radius:
/// a^3 = 1 - mean density / density of the shell.
/// @param mean_density_kgpm3  of the whole ball, > 0 and not above that of the shell [kg/m^3]
double shell_inertia_factor(double mean_density_kgpm3, double shell_density_kgpm3);
/// c = 1/(1 + J/(m R^2)), what a contact that does not slip takes of a tangential speed: 5/7 solid, 3/5 a thin shell
/// (docs/physics.md, 7).
double no_slip_factor(double inertia_factor);

/// How long the ball touches the plate [s]: as measured where that is known, by Hertz where his theory holds for both,
/// else absent.
/// @param v_mps  normal impact speed, > 0 [m/s]
std::optional<double> contact_time_s(const Ball& ball, const Material& plate, double v_mps);

/// Duration of a Hertzian contact of the ball with a half-space [s]:
///
///   tau = 2.943 (15 m / (16 E* sqrt R))^(2/5) v^(-1/5),   1/E* = (1-nu1^2)/E1 + (1-nu2^2)/E2
///
/// @param v_mps  normal impact speed, > 0 [m/s]
/// Elastic: neglects dissipation (relative error of order 1 - eps). Source: Johnson, Contact Mechanics (1985), 11.4,
/// doi:10.1017/CBO9781139171731.
double hertz_contact_time_s(const Ball& ball, const Material& plate, double v_mps);

/// Radius of the area of contact at greatest compression, of the smooth elastic ball on a half-space [m]:
///
///   a = sqrt(R delta),   delta = (15 m v^2 / (16 E* sqrt R))^(2/5): m v^2 / 2 = (8/15) E* sqrt(R) delta^(5/2)
///
/// @param v_mps  normal impact speed, >= 0 [m/s]
/// Source: Johnson, Contact Mechanics (1985), 4.2 and 11.4, doi:10.1017/CBO9781139171731.
double hertz_patch_radius_m(const Ball& ball, const Material& plate, double v_mps);

}  // namespace bouncelab
