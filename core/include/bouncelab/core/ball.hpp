// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/elementary.hpp"

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
/// With the text that plate_text has for it.
Description members_of(const Material*);

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

/// How long a ball touches the plate: tau = at_1_mps_s v^exponent.
struct ContactDuration {
  double at_1_mps_s = 0.0;  ///< >= 0; 0: instantaneous
  double exponent = -0.2;   ///< -1/5 by Hertz; 0 of what acts as a spring
  double spread = 0.1;      ///< standard deviation of ln tau: what is not known of it

  double at(double v_mps) const { return at_1_mps_s * pow(v_mps, exponent); }

  friend bool operator==(const ContactDuration&, const ContactDuration&) = default;
};

/// A ball, solid or hollow. Defaults: the paper's stainless-steel bearing ball.
struct Ball {
  double radius_m = 3.0e-3;                   ///< > 0 [m]
  Material material = kSteel;                 ///< its density is the mean one: mass over volume of the sphere
  double inertia_factor = kSolidBallInertia;  ///< J/(m R^2), in (0, 1]
  std::optional<double> contact_time_s =
      std::nullopt;  ///< measured, taken for all speeds and plates, > 0 [s]; absent: by Hertz
  std::optional<ContactDuration> usual_contact =
      std::nullopt;  ///< the catalogue's, of a ball that was named; one by numbers alone has none

  friend bool operator==(const Ball&, const Ball&) = default;
};
/// With the text that to_text has for it, and its material's numbers.
Description members_of(const Ball*);

/// 4/3 pi rho R^3 [kg], rho the mean density.
double mass_kg(const Ball& ball);
/// inertia_factor m R^2 [kg m^2]; the asperities' mass is neglected (mass ratio 1e-9).
double moment_of_inertia_kgm2(const Ball& ball);
/// J/(m R^2) of a homogeneous spherical shell, (2/5) (1 - a^5) / (1 - a^3), a its inner over its outer radius:
/// a^3 = 1 - mean density / density of the shell.
/// @param mean_density_kgpm3  of the whole ball, > 0 and not above that of the shell [kg/m^3]
double shell_inertia_factor(double mean_density_kgpm3, double shell_density_kgpm3);
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

/// What is known of it: as measured where the ball says so, by Hertz where his theory holds for both (within 10 %),
/// else as the catalogue has it for the ball that was named; absent where none of them does.
std::optional<ContactDuration> contact_duration(const Ball& ball, const std::optional<Material>& plate);

/// What a ball of a sport has to rebound when it is dropped: heights of its lowest point over a hard floor.
struct ReboundRule {
  std::string by;  ///< who asks for it
  double height_m = 0.0;
  double least_m = 0.0, most_m = 0.0;
  std::string floor;
  std::string source;  ///< with its edition
};
Description members_of(const ReboundRule*);

/// A ball, or a material that balls are made of, by its name.
struct BallKind {
  std::string name;  ///< on the command line
  std::string what;  ///< in words
  /// Of a material, of which balls of any diameter are made; its density that of the ball.
  Material material;
  /// Diameter by the rules of the sport [m]; absent: a material.
  std::optional<double> diameter_m;
  double inertia_factor = kSolidBallInertia;  ///< J/(m R^2)
  std::string source;
  std::optional<ContactDuration> contact = std::nullopt;  ///< of balls for which Hertz's theory does not hold
  std::string contact_source{};
  std::optional<ReboundRule> rebound = std::nullopt;
};
Description members_of(const BallKind*);

/// What the ball falls on, by its name.
struct PlateKind {
  std::string name;
  std::string what;
  Material material;
  double loss_factor = 0.0;  ///< of the bending vibrations that make the sound
  std::string source;
};
Description members_of(const PlateKind*);

/// Balls of sports, then materials. Masses and diameters are the middle of what the rules allow, or their limit.
const std::vector<BallKind>& ball_kinds();
const std::vector<PlateKind>& plate_kinds();
/// That of the sport whose ball has this size and, within a tenth, this mass; nullptr where there is none.
const ReboundRule* rebound_rule(const Ball& ball);

/// A ball from its description:
///
///   table-tennis                       a ball of ball_kinds() that has its size by the rules
///   steel:6mm = steel:d=6mm            a material and the DIAMETER, as balls are sold; steel:r=3mm: the radius
///   steel:6mm,density=7800             with other numbers than the catalogue's
///   radius=20mm,mass=2.7g,inertia=0.65 by its numbers
///
/// Numbers: radius or diameter and mass with their units (m, cm, mm, um; kg, g, mg), density [kg/m^3], inertia =
/// J/(m R^2) (default that of the name, else of a solid sphere), E with its unit (Pa, kPa, MPa, GPa) and nu together:
/// the contact is Hertz's; contact-time with its unit (s, ms, us): measured, instead of Hertz's.
/// @throws InvalidArgument naming what is not understood and what is; of an unknown name the nearest one
Ball ball_from_text(const std::string& text);
/// The shortest description that ball_from_text makes the same ball of, bit for bit.
std::string to_text(const Ball& ball);
/// "steel:6mm (diameter 6 mm, radius 3 mm, mass 0.8935 g, J = 0.4 m R^2)": what was understood, for people.
std::string describe(const Ball& ball);

/// "glass", or "E=70GPa,nu=0.22,density=2500". @throws InvalidArgument likewise
Material plate_from_text(const std::string& text);
/// Likewise.
std::string plate_text(const Material& plate);
/// That of the catalogue; absent where it has no such material.
std::optional<double> plate_loss_factor(const Material& plate);

/// Force of an elastic Hertz contact over its duration: s in [0, 1] is time over contact time, the integral is 1.
///
///   F(s) ~ x^(3/2),   x'' = -(5/4) x^(3/2)  in the time unit (largest indentation)/v
///
/// The shape is universal: material, radius and speed only scale it (Johnson, Contact Mechanics (1985), 11.4). It
/// starts like s^(3/2), softer than the half-sine often used, which matters for a picker that looks at the first
/// samples.
double hertz_force(double s);

/// Point impulses that stand for a force pulse: at node_q of its duration, with weight_q; total weight 1.
struct PointImpulses {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// The pulse of a contact as point impulses whose spectrum is the pulse's own, within 1e-9, up to half the sample rate.
///
/// The nodes are equally spaced in theta, s = (1 - cos theta)/2: there the force times ds/dtheta, continued evenly and
/// periodically, is smooth to the ninth derivative, so that the trapezoidal rule converges like n^-10 once n exceeds
/// the phase that passes during the contact.
/// @param duration_samples  of the contact, in (0, kMaxContact_samples]
PointImpulses hertz_impulses(double duration_samples);
inline constexpr double kMaxContact_samples = 1600.0;

/// Still air: the simulator flies through it, the fit takes account of it.
struct Air {
  double density_kgpm3 = 1.2;       ///< 20 C, 1010 hPa
  double viscosity_pas = 1.813e-5;  ///< dynamic, 20 C
};

/// Drag of a smooth sphere by the standard drag curve, as a deceleration over speed squared [1/m]:
///
///   kappa = (3/8) C_d rho_air / (rho R),   C_d = 24/Re (1 + 0.15 Re^0.681) + 0.407/(1 + 8710/Re),   Re = 2 R v
///   rho_air/mu
///
/// rho and R of the ball. C_d fits the measurements within 4 % (rms 2.6 %) for Re < 2e5. Source: Brown & Lawler, J.
/// Environ. Eng. 129, 222 (2003), doi:10.1061/(ASCE)0733-9372(2003)129:3(222).
/// @param v_mps  > 0 [m/s]
double drag_per_m(const Ball& ball, const Air& air, double v_mps);
/// kappa v [1/s]: a = -drag_rate_per_s v. @param v_mps  >= 0; at 0 that of Stokes
double drag_rate_per_s(const Ball& ball, const Air& air, double v_mps);

/// Speeds at the two ends of a vertical flight from the plate and back.
struct Flight {
  double launch_mps = 0.0;
  double landing_mps = 0.0;
};

/// The flight that lasts duration_s under drag kappa v^2, kappa the same at all speeds of it. With v_t = sqrt(g/kappa),
///
///   duration = (v_t/g) (atan x + asinh x),   launch = v_t x,   landing = launch / sqrt(1 + x^2)
///
/// to rounding; without drag both speeds are g duration/2. (docs/physics.md, 9)
/// @param duration_s, gravity_mps2  > 0. @param kappa_per_m  >= 0
Flight flight_with_drag(double duration_s, double gravity_mps2, double kappa_per_m);

/// Landing speed after release at rest from a height [m/s]: sqrt(g/kappa (1 - exp(-2 kappa h))).
double fall_with_drag_mps(double height_m, double gravity_mps2, double kappa_per_m);
/// The height of that release [m]: -ln(1 - kappa v^2/g) / (2 kappa); infinite from the limit speed sqrt(g/kappa) on.
double fall_height_m(double landing_mps, double gravity_mps2, double kappa_per_m);
/// How high a launch rises [m]: ln(1 + kappa v^2/g) / (2 kappa).
double rise_height_m(double launch_mps, double gravity_mps2, double kappa_per_m);

/// Gravity used throughout unless stated otherwise [m/s^2].
inline constexpr double kDefaultGravity_mps2 = 9.81;

}  // namespace bouncelab
