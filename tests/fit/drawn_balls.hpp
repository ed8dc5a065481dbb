// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "integrated_flight.hpp"

/// Impact times of balls whose law of restitution is known. Nothing here knows the program's drag curve, its catalogue
/// of balls or its laws.
namespace bouncelab::testing {

inline constexpr double kDrawnGravity_mps2 = 9.81;
/// Of an outlier from the others, in standard deviations of the scatter.
inline constexpr double kOutlierDistance = 8.0;

/// The standard drag curve of a sphere, read off at decades and their thirds (Clift, Grace & Weber, Bubbles, Drops and
/// Particles (1978), figure 5.12 and table 5.2), straight in the logarithms.
double standard_drag_coefficient(double reynolds);

/// A flight in air by brute force. @param drag_factor  of the standard curve: felt, seams
IntegratedFlight flight_in_air(double radius_m, double mass_kg, double drag_factor, double launch_mps, int n_steps);

/// eps of an elastic, perfectly plastic contact (Thornton, J. Appl. Mech. 64, 383 (1997), doi:10.1115/1.2787319).
double eps_by_thornton(double v_mps, double yield_mps);

struct DrawnBall {
  std::string name;  ///< to the program
  double radius_m, mass_kg;
  double tau_1_s, tau_exponent;  ///< contact time tau_1 v^exponent
  double tau_spread;             ///< standard deviation of ln tau
};

/// eps(v), of constants that somebody who knows its form has still to find.
struct DrawnLaw {
  std::string name;
  double (*eps)(double v_mps, const std::vector<double>& constants);
  std::vector<double> constants;
  std::string ball;  ///< by the name of DrawnBall
};
const std::vector<DrawnLaw>& drawn_laws();

/// How the fluctuations of a drop hang together.
enum class AlongDrop {
  nothing,
  offset,  ///< each drop has a loss of its own, of `along_size` standard deviations of the scatter, on top
  ar       ///< first-order autoregressive, `along_size` from bounce to bounce
};

/// One kind of experiment.
struct Cell {
  std::string law;
  int n_drops = 10;
  int most_bounces = 12;   ///< impacts heard of a drop
  std::string variant{};   ///< in words, for the name
  double scatter = 0.005;  ///< standard deviation of eps at 1 m/s
  double power = 0.5;      ///< it goes as v^-power
  double skew = 1.0;       ///< 1: normal; else two exponentials, their scale below the peak over that above
  AlongDrop along = AlongDrop::nothing;
  double along_size = 0.0;
  double outliers = 0.0;                     ///< their share, each off by kOutlierDistance
  double sigma_t_s = 30e-6;                  ///< of the times
  double threshold_mps = 0.15;               ///< slower impacts are not heard
  std::array<double, 2> height_m{0.3, 1.0};  ///< of the release, between these

  /// kink_d10b12: law, drops, most bounces, then the variant.
  std::string name() const;
  const DrawnLaw& its_law() const;
  const DrawnBall& its_ball() const;
  /// Standard deviation of the scatter at a speed, without what a drop has of its own.
  double scatter_at(double v_mps) const;
};

/// Of one experiment, and what is true of it.
struct DrawnTable {
  Onsets onsets;
  std::vector<double> exact_s;                  ///< the onsets' times without their errors
  double kappa_factor = 1.0, tau_factor = 1.0;  ///< against the standard curve, and the ball's tau
  std::vector<double> offsets;                  ///< of each drop, in standard deviations of the scatter
  std::vector<std::vector<bool>> is_outlier;    ///< by drop and impact
};

/// The same for the same cell and number, on every machine.
DrawnTable draw(const Cell& cell, std::uint64_t number);

/// The mean of eps at that speed: of a single drop with a loss of its own that of this drop.
double mean_eps(const Cell& cell, const DrawnTable& table, double v_mps);
/// The root mean square likewise, which is what energy goes by: drops differ as well where they do. Outliers are not
/// of the ball.
double rms_eps(const Cell& cell, const DrawnTable& table, double v_mps);

/// Flights of a ball at hand: integrated once, then interpolated, which takes a ten thousandth of the time.
class FlightTable {
 public:
  explicit FlightTable(const DrawnBall& ball);
  /// @param launch_mps  0.05 ... 6. @param drag_factor  0.5 ... 1.6
  IntegratedFlight at(double launch_mps, double drag_factor) const;
  /// The launch speed of a flight that lasts so long.
  double launch_mps(double duration_s, double drag_factor) const;

 private:
  /// Duration and landing speed over launch speed, by launch speed and drag factor.
  std::vector<IntegratedFlight> over_launch_;
};
/// Made where first asked for.
const FlightTable& flights_of(const DrawnBall& ball);

}  // namespace bouncelab::testing
