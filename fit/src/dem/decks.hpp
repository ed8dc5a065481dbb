// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/dem_export.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// Where a function that falls has a value, by halving the interval n times.
template <class Function>
double place_of(double value, double least, double most, int n, Function falling) {
  for (int k = 0; k < n; ++k) {
    const double middle = 0.5 * (least + most);
    (falling(middle) > value ? least : most) = middle;
  }
  return 0.5 * (least + most);
}

/// A contact of the ball with the plate as discrete-element codes have it,
///
///   F = k_n sqrt(R) xi^(3/2) + damping,   k_n = (4/3) E*
///
/// with one material for ball and plate, E* = E/(2 (1 - nu^2)), so that each code makes the same E* of it.
struct DemContact {
  std::string ball;  ///< the ball and the plate in words
  double radius_m = 0.0;
  double density_kgpm3 = 0.0;
  double youngs_modulus_pa = 0.0;
  double poisson_ratio = 0.0;
  double k_n_pa = 0.0;  ///< (4/3) E*
  double k_t_pa = 0.0;  ///< 8 G* = 3 (1 - nu)/(2 - nu) k_n (Mindlin)
  double mass_kg = 0.0;
  double duration_s = 0.0;                ///< of an elastic contact at 1 m/s; as v^(-1/5)
  double overlap_m = 0.0;                 ///< the deepest, at v
  bool is_softened = false;               ///< E was stated
  std::optional<double> times_as_long{};  ///< a contact, where E was stated and the ball's own is known
};

/// As stiff as Hertz's law makes contacts that last as long as those of the ball do at v. What is not named is as the
/// paper's, a steel ball of 6 mm on glass; a ball whose stiffness is not known is as stiff as steel, a plate for which
/// Hertz's theory does not hold as its modulus says: the words say so.
/// @param youngs_modulus_pa  of the material of ball and plate, in place of that stiffness: of a simulation whose balls
///                           are softer than the measured one
DemContact dem_contact(const std::optional<Ball>& ball, const std::optional<Material>& plate, double v_mps,
                       std::optional<double> youngs_modulus_pa = {});

/// alpha of a contact with a constant eps, m d2xi/dt2 = -k xi^(3/2) - alpha sqrt(m k) xi^(1/4) dxi/dt, that ends where
/// the surfaces part, xi = 0:  alpha = -sqrt(5) ln eps/sqrt(ln^2 eps + pi^2).
/// Source: Antypov & Elliott, EPL 94, 50004 (2011), doi:10.1209/0295-5075/94/50004.
double damping_to_parting(double eps);
/// The same of a contact that ends where the force does, which nothing attracts (Schwager & Poeschel, Phys. Rev. E 78,
/// 051304 (2008), doi:10.1103/PhysRevE.78.051304). From the equation of motion; error of eps 1e-6.
double damping_to_last_force(double eps);

/// Contacts of the theory, of LIGGGHTS and of Yade end where the force does, those of LAMMPS where the surfaces part.
enum class ContactEnd { force, surfaces };
/// eps of the viscoelastic sphere by the equation of motion, x'' = -x^(3/2) - gamma v^(1/5) sqrt(x) x' in units of the
/// deepest elastic contact; error 1e-5, 3e-5 to where surfaces part. ViscoelasticLaw is 0.002 high at 0.6.
double viscoelastic_by_motion(double gamma, double v_mps, ContactEnd end);

/// Constant eps that a code cannot go below: LIGGGHTS refuses less, LAMMPS's `damping tsuji` has no larger damping (its
/// polynomial ends at 1.2728).
constexpr double kLeastOfLiggghts = 0.05, kLeastOfLammps = 0.114;

/// What the inputs of all codes have in common.
struct Decks {
  DemContact contact;
  /// Where the numbers are from; one line or more, without marks of a comment. @overlap@: how deep the ball goes, by
  /// code.
  std::string about;
  double v_mps = 0.0;  ///< of the impact that the input makes where nothing else is asked for
};

/// One ball, which meets a plate at v and prints eps, in LIGGGHTS, LAMMPS, Yade and MercuryDPM, with a constant eps.
/// @param eps  in (0, 1]; none for a code that cannot bounce it
std::vector<Snippet> constant_decks(const Decks& decks, double eps);
/// The same with viscoelastic contacts, in the codes that have them and end them so.
/// @param gamma  > 0 [(m/s)^(-1/5)]
std::vector<Snippet> viscoelastic_decks(const Decks& decks, double gamma, ContactEnd end);

/// Speeds with what the samples scatter like there.
struct ScatterRow {
  double v_mps, mean, below, above, normal;
};
/// Independent draws of eps in C++, Python and formulas: mean + above (e1 - 1) - below (e2 - 1) + normal z, e1 and e2
/// standard exponential random numbers, z a standard normal one, the rest by interpolation in ln v, clamped.
std::vector<Snippet> independent_samplers(const std::vector<ScatterRow>& rows, const std::string& about);
/// Draws that remember, in C++.
Snippet sampler_with_memory(const RestitutionLaw& law, double q, double slowest_mps, double fastest_mps,
                            const std::string& about);

/// Inputs of discrete-element codes, files of fit/data, with @name@ where a number or a part of another file stands.
extern const char *const kLiggghts, *const kLiggghtsConstant, *const kLiggghtsViscoelastic;
extern const char* const kLammps;
extern const char *const kYade, *const kYadeViscoelastic;
extern const char* const kMercury;
/// Functions that draw eps; the first is the file core/restitution_with_memory.hpp.
extern const char *const kSamplerText, *const kSamplerWithMemory;
extern const char *const kSamplerInCpp, *const kSamplerInPython, *const kSamplerInFormulas;

}  // namespace bouncelab::fit
