// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/sim/vector3.hpp"

namespace bouncelab::sim {

// Laws of the asperities' radii, relative to the ball's radius R. The paper gives N ~ 1e6 and R_j ~ 1e-3 R but no law,
// and the law sets the width of p(eps): it is a parameter of every study.
struct ConstantRadii {
  double radius = 1e-3;  ///< > 0
};
struct UniformRadii {
  double lo = 0.5e-3, hi = 1.5e-3;  ///< 0 < lo < hi
};
/// Normal, truncated at 0 (values <= 0 are drawn again).
struct NormalRadii {
  double mean = 1e-3, sd = 1e-4;  ///< both > 0
};
struct LognormalRadii {
  double median = 1e-3, sigma = 0.1;  ///< sigma = sd of the logarithm; both > 0
};
struct ExponentialRadii {
  double mean = 1e-3;  ///< > 0
};
using RadiusLaw = std::variant<UniformRadii, ConstantRadii, NormalRadii, LognormalRadii, ExponentialRadii>;

/// @throws InvalidArgument where a parameter is out of its range
void validate(const RadiusLaw& law);
/// Reads "constant:1e-3", "uniform:0.5e-3,1.5e-3", "normal:1e-3,1e-4", "lognormal:1e-3,0.1", "exponential:1e-3"; the
/// parameters may be left out (then the defaults above hold). @throws InvalidArgument naming the text and what may
/// stand
RadiusLaw radius_law_from_text(std::string_view text);
/// The text that radius_law_from_text reads back to the same law.
std::string to_text(const RadiusLaw& law);

/// A small sphere on the ball; its centre lies on the ball's sphere of radius R, seen from the ball's centre along
/// `direction` (unit vector of the body frame).
struct Asperity {
  Vector3 direction;
  double radius_m = 0.0;  ///< > 0, < R
};

/// The ball's roughness; may be empty (a smooth ball). Order is identity: impacts name asperities by index.
struct Surface {
  std::vector<Asperity> asperities;
};

/// Asperities with directions uniform on the sphere and radii by `law`. Asperity j depends on (seed, j) alone: a
/// surface of fewer asperities is the beginning of a larger one.
/// @param n_asperities  0 ... 4e9
/// @param progress  called with asperities done; may throw to stop
/// @throws InvalidArgument where the law's parameters are out of range, or a radius drawn reaches R
Surface make_surface(const Ball& ball, std::int64_t n_asperities, const RadiusLaw& law, std::uint64_t seed,
                     const ProgressCallback& progress = {});

/// The `surface` table: ux, uy, uz, radius_m.
Table to_table(const Surface& surface);
std::vector<ColumnSpec> surface_columns();
/// Normalises the directions.
/// @param name  of the file, for messages
/// @throws FileError naming the first line whose numbers are not finite, whose direction has no length or whose radius
/// is not in (0, R)
Surface surface_from_table(const Table& table, const std::string& name, const Ball& ball);

/// The circle in which a plane through the ball's centre cuts an asperity. Its centre is on the ball's circle but for
/// radius^2 / (2 R).
struct SectionCircle {
  double angle_rad = 0.0;  ///< of its centre along the ball's circle
  double radius_m = 0.0;   ///< sqrt(R_j^2 - d^2), d the distance of the asperity's centre from the plane
};
Description members_of(const SectionCircle*);

/// A piece of the ball as it looks when cut through its centre, for a picture of its surface.
struct BallSection {
  double ball_radius_m = 0.0;
  std::size_t n_asperities = 0;         ///< of the whole ball
  double mean_asperity_radius_m = 0.0;  ///< likewise
  double half_angle_rad = 0.0;          ///< the piece reaches from minus to plus this; at most a quarter of the circle
  std::vector<SectionCircle> circles;   ///< by angle
};
Description members_of(const BallSection*);

/// The piece around the z axis of the body frame in the plane y = 0, so long that some 10 asperities are cut by it (of
/// directions uniform on the sphere the plane cuts R_j / (2 pi R) of them in each radian).
BallSection section_of(const Ball& ball, const Surface& surface);

}  // namespace bouncelab::sim
