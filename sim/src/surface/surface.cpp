// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::sim {
namespace {

double draw(const ConstantRadii& law, Random&) { return law.radius; }
double draw(const UniformRadii& law, Random& random) { return random.uniform(law.lo, law.hi); }
double draw(const NormalRadii& law, Random& random) {
  double radius = 0.0;
  do radius = law.mean + law.sd * random.normal();
  while (radius <= 0.0);
  return radius;
}
double draw(const LognormalRadii& law, Random& random) { return law.median * exp(law.sigma * random.normal()); }
double draw(const ExponentialRadii& law, Random& random) { return law.mean * random.exponential(); }

bool is_good(const ConstantRadii& law) { return law.radius > 0.0 && law.radius < 1.0; }
bool is_good(const UniformRadii& law) { return law.lo > 0.0 && law.lo < law.hi && law.hi < 1.0; }
bool is_good(const NormalRadii& law) { return law.mean > 0.0 && law.mean < 1.0 && law.sd > 0.0 && law.sd < 1.0; }
bool is_good(const LognormalRadii& law) {
  return law.median > 0.0 && law.median < 1.0 && law.sigma > 0.0 && law.sigma < 10.0;
}
bool is_good(const ExponentialRadii& law) { return law.mean > 0.0 && law.mean < 1.0; }

/// Name and the two parameters by address: one description for reading and writing.
struct SurfaceText {
  const char* name;
  std::vector<double*> parameters;
};
SurfaceText describe(ConstantRadii& law) { return {"constant", {&law.radius}}; }
SurfaceText describe(UniformRadii& law) { return {"uniform", {&law.lo, &law.hi}}; }
SurfaceText describe(NormalRadii& law) { return {"normal", {&law.mean, &law.sd}}; }
SurfaceText describe(LognormalRadii& law) { return {"lognormal", {&law.median, &law.sigma}}; }
SurfaceText describe(ExponentialRadii& law) { return {"exponential", {&law.mean}}; }

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto comma = text.find(',');
    parts.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

[[noreturn]] void refuse(std::string_view text) {
  throw InvalidArgument("radius law '" + std::string(text) +
                        "': may be constant:R, uniform:LO,HI, normal:MEAN,SD, lognormal:MEDIAN,SIGMA or "
                        "exponential:MEAN, radii in units of the ball's radius, between 0 and 1");
}

void read_parameters(const SurfaceText& law, std::string_view parameters, std::string_view text) {
  const auto parts = split(parameters);
  if (parts.size() != law.parameters.size()) refuse(text);
  for (std::size_t k = 0; k < parts.size(); ++k)
    if (parse_number(parts[k], *law.parameters[k]) != std::errc{}) refuse(text);
}

}  // namespace

void validate(const RadiusLaw& law) {
  if (!std::visit([](const auto& l) { return is_good(l); }, law)) refuse(to_text(law));
}

RadiusLaw radius_law_from_text(std::string_view text) {
  const auto colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  for (RadiusLaw law : {RadiusLaw{ConstantRadii{}}, RadiusLaw{UniformRadii{}}, RadiusLaw{NormalRadii{}},
                        RadiusLaw{LognormalRadii{}}, RadiusLaw{ExponentialRadii{}}}) {
    const SurfaceText description = std::visit([](auto& l) { return describe(l); }, law);
    if (name != description.name) continue;
    if (colon != std::string_view::npos) read_parameters(description, text.substr(colon + 1), text);
    if (!std::visit([](const auto& l) { return is_good(l); }, law)) refuse(text);
    return law;
  }
  refuse(text);
}

std::string to_text(const RadiusLaw& law) {
  RadiusLaw copy = law;
  const SurfaceText description = std::visit([](auto& l) { return describe(l); }, copy);
  std::string text = description.name;
  for (std::size_t k = 0; k < description.parameters.size(); ++k)
    text += (k == 0 ? ':' : ',') + number_text(*description.parameters[k]);
  return text;
}

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
    const double radius = std::visit([&](const auto& l) { return draw(l, random); }, law);
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

BallSection section_of(const Ball& ball, const Surface& surface) {
  constexpr double kCut = 10.0;  // told apart at the width of a page
  BallSection section{ball.radius_m, surface.asperities.size(), 0.0, kPi / 4, {}};
  if (surface.asperities.empty()) return section;
  double sum_m = 0.0;
  for (const Asperity& a : surface.asperities) sum_m += a.radius_m;
  section.mean_asperity_radius_m = sum_m / static_cast<double>(surface.asperities.size());
  section.half_angle_rad = std::min(kPi / 4, kPi * kCut * ball.radius_m / sum_m);
  for (const Asperity& a : surface.asperities) {
    const double square_m2 = square(a.radius_m) - square(a.direction.y * ball.radius_m);
    if (!(square_m2 > 0.0)) continue;  // nearly all
    const double angle_rad = std::atan2(a.direction.x, a.direction.z);
    if (std::abs(angle_rad) <= section.half_angle_rad) section.circles.push_back({angle_rad, std::sqrt(square_m2)});
  }
  std::sort(section.circles.begin(), section.circles.end(),
            [](const SectionCircle& a, const SectionCircle& b) { return a.angle_rad < b.angle_rad; });
  return section;
}

}  // namespace bouncelab::sim
