// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/surface.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "surface/radius_law.hpp"

namespace bouncelab::sim {
namespace {

Vector3 random_direction(Random& random) {
  const double z = random.uniform(-1.0, 1.0);
  const SinCos azimuth = sin_cos(2.0 * std::numbers::pi * random.uniform());
  const double s = std::sqrt((1.0 - z) * (1.0 + z));
  return normalized(Vector3{s * azimuth.cos, s * azimuth.sin, z});
}

}  // namespace

Surface make_surface(const Ball& ball, std::int64_t n_asperities, const RadiusLaw& law, std::uint64_t seed,
                     const ProgressCallback& progress) {
  if (n_asperities < 0 || n_asperities > std::numeric_limits<std::uint32_t>::max() - 1)
    throw InvalidArgument("surface: " + std::to_string(n_asperities) + " asperities are outside [0, 4e9]");
  validate(law);
  Surface surface;
  surface.asperities.reserve(static_cast<std::size_t>(n_asperities));
  for (std::int64_t j = 0; j < n_asperities; ++j) {
    if (progress && j % 100'000 == 0) progress(static_cast<double>(j), static_cast<double>(n_asperities));
    Random random(seed, RandomStream::surface, static_cast<std::uint64_t>(j));
    const Vector3 direction = random_direction(random);
    const double radius = draw_radius(law, random);
    if (!(radius < 1.0))
      throw InvalidArgument("surface: asperity " + std::to_string(j) + " drew a radius of " + std::to_string(radius) +
                            " R by the law " + to_text(law) + "; radii must stay below R, choose smaller ones");
    surface.asperities.push_back({direction, radius * ball.radius_m});
  }
  return surface;
}

Table to_table(const Surface& surface) {
  std::vector<double> ux, uy, uz, radius_m;
  for (const Asperity& asperity : surface.asperities) {
    ux.push_back(asperity.direction.x);
    uy.push_back(asperity.direction.y);
    uz.push_back(asperity.direction.z);
    radius_m.push_back(asperity.radius_m);
  }
  return {{{"ux", std::move(ux)}, {"uy", std::move(uy)}, {"uz", std::move(uz)}, {"radius_m", std::move(radius_m)}}};
}

std::vector<ColumnSpec> surface_columns() {
  const Range finite = known({-1e100, 1e100});
  return {{"ux", ColumnType::real, true, finite},
          {"uy", ColumnType::real, true, finite},
          {"uz", ColumnType::real, true, finite},
          {"radius_m", ColumnType::real, true, known(positive_up_to(1e3))}};
}

Surface surface_from_table(const Table& table, const std::string& name, const Ball& ball) {
  check_columns(table, surface_columns(), name);
  const auto &ux = *table.reals("ux"), &uy = *table.reals("uy"), &uz = *table.reals("uz");
  const auto& radius_m = *table.reals("radius_m");
  Surface surface;
  surface.asperities.reserve(ux.size());
  for (std::size_t k = 0; k < ux.size(); ++k) {
    const Vector3 direction{ux[k], uy[k], uz[k]};
    const double length = norm(direction);
    if (!(length > 1e-100))
      throw FileError(name, table.place_of(k) +
                                ", columns ux, uy, uz: the direction cannot be normalised, its length is " +
                                short_number(length) + "; give three numbers, not all 0");
    if (!(radius_m[k] < ball.radius_m))
      throw FileError(name, table.place_of(k) + ", column radius_m: " + short_number(radius_m[k]) +
                                " is outside (0, R = " + short_number(ball.radius_m) + " m)");
    surface.asperities.push_back({(1.0 / length) * direction, radius_m[k]});
  }
  return surface;
}

}  // namespace bouncelab::sim
