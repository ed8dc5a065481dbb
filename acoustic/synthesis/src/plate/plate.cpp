// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/synthesis/plate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "plate/modes.hpp"

namespace bouncelab::synthesis {
namespace {

void require(bool holds, const std::string& quantity, double value, const std::string& remedy) {
  if (!holds) throw InvalidArgument(quantity + " is " + std::to_string(value) + "; it must be " + remedy);
}

void validate_material(const Material& m, const std::string& of) {
  require(m.youngs_modulus_pa > 0.0, of + " youngs_modulus_pa", m.youngs_modulus_pa, "positive");
  require(m.poisson_ratio >= 0.0 && m.poisson_ratio < 0.5, of + " poisson_ratio", m.poisson_ratio, "in [0, 0.5)");
  require(m.density_kgpm3 > 0.0, of + " density_kgpm3", m.density_kgpm3, "positive");
}

void validate_damping(const Damping& d, const std::string& of) {
  require(d.loss_factor >= 0.0 && d.loss_factor < 1.0, of + " loss_factor", d.loss_factor, "in [0, 1)");
  require(d.support_per_s > 0.0, of + " support_per_s", d.support_per_s, "positive (a sound must end)");
}

void validate_ground(const Ground& g) {
  require(g.carrier.length_x_m > 0.0, "plate length_x_m", g.carrier.length_x_m, "positive");
  require(g.carrier.length_y_m > 0.0, "plate length_y_m", g.carrier.length_y_m, "positive");
  require(g.carrier.thickness_m > 0.0, "plate thickness_m", g.carrier.thickness_m, "positive");
  validate_material(g.carrier.material, "plate");
  validate_damping(g.carrier_damping, "plate");
  if (!g.disk) return;
  const double room_m = 0.5 * std::min(g.carrier.length_x_m, g.carrier.length_y_m);
  require(g.disk->radius_m > 0.0 && g.disk->radius_m <= room_m, "disk radius_m", g.disk->radius_m,
          "positive and on the plate");
  require(g.disk->thickness_m > 0.0, "disk thickness_m", g.disk->thickness_m, "positive");
  validate_material(g.disk->material, "disk");
  validate_damping(g.disk_damping, "disk");
}

PlateMode plate_mode(double wavenumber_per_m, double thickness_m, double area_m2, const Material& material,
                     const Damping& damping, bool of_disk) {
  const double natural_radps = 2.0 * std::numbers::pi * mindlin_frequency_hz(wavenumber_per_m, thickness_m, material);
  const double decay_per_s = 0.5 * damping.loss_factor * natural_radps + damping.support_per_s;
  const double damped_radps = std::sqrt(std::max(0.0, natural_radps * natural_radps - decay_per_s * decay_per_s));
  return {damped_radps / (2.0 * std::numbers::pi), decay_per_s, material.density_kgpm3 * thickness_m * area_m2,
          of_disk};
}

/// The wavenumber at which Mindlin's frequency is reached; it grows with k.
double wavenumber_at(double frequency_hz, double thickness_m, const Material& material) {
  const auto excess_hz = [&](double k_per_m) {
    return mindlin_frequency_hz(k_per_m, thickness_m, material) - frequency_hz;
  };
  double hi = 1.0;
  while (excess_hz(hi) < 0.0) hi *= 2.0;
  return root_between(excess_hz, 0.0, hi);
}

}  // namespace

Ground ground_preset(GroundPreset preset) {
  Ground result;
  if (preset == GroundPreset::sic) {
    result.disk = CircularDisk{};
    result.disk_damping = {1e-3, 150.0};
  } else if (preset == GroundPreset::vitreloy) {
    result.disk = CircularDisk{0.05, 0.006, kVitreloy};
    result.disk_damping = {2e-3, 150.0};
  }
  return result;
}

Ground ground_of(const Material& plate) {
  if (plate == kSiliconCarbide) return ground_preset(GroundPreset::sic);
  if (plate == kVitreloy) return ground_preset(GroundPreset::vitreloy);
  Ground result;
  result.carrier.material = plate;
  result.carrier_damping.loss_factor = plate_loss_factor(plate).value_or(result.carrier_damping.loss_factor);
  return result;
}

const Material& contact_material(const Ground& ground) {
  return ground.disk ? ground.disk->material : ground.carrier.material;
}

bool contains(const Ground& ground, double x_m, double y_m) {
  if (ground.disk) return hypot(x_m, y_m) <= ground.disk->radius_m;
  return std::abs(x_m) <= 0.5 * ground.carrier.length_x_m && std::abs(y_m) <= 0.5 * ground.carrier.length_y_m;
}

double mindlin_frequency_hz(double k_per_m, double thickness_m, const Material& m) {
  const double shear_pa = m.youngs_modulus_pa / (2.0 * (1.0 + m.poisson_ratio));
  const double rigidity_nm =
      m.youngs_modulus_pa * power(thickness_m, 3) / (12.0 * (1.0 - m.poisson_ratio * m.poisson_ratio));
  // (k^2 - a W)(k^2 - b W) = c W with W = omega^2; its lower root, in the form that does not cancel
  const double a = m.density_kgpm3 / (std::numbers::pi * std::numbers::pi / 12.0 * shear_pa);
  const double b = m.density_kgpm3 * power(thickness_m, 3) / (12.0 * rigidity_nm);
  const double c = m.density_kgpm3 * thickness_m / rigidity_nm;
  const double k2 = k_per_m * k_per_m;
  const double half = k2 * (a + b) + c;
  const double square_radps2 = 2.0 * k2 * k2 / (half + std::sqrt(half * half - 4.0 * a * b * k2 * k2));
  return std::sqrt(square_radps2) / (2.0 * std::numbers::pi);
}

double rayleigh_speed_mps(const Material& m) {
  const double shear_speed_mps = std::sqrt(m.youngs_modulus_pa / (2.0 * (1.0 + m.poisson_ratio)) / m.density_kgpm3);
  return shear_speed_mps * (0.862 + 1.14 * m.poisson_ratio) / (1.0 + m.poisson_ratio);
}

struct PlateModes::Shapes {
  RectangularModes carrier;
  std::vector<DiskMode> disk;
};

PlateModes::PlateModes(const Ground& ground, double max_frequency_hz)
    : ground_(ground), shapes_(std::make_unique<Shapes>()) {
  validate_ground(ground);
  require(max_frequency_hz > 0.0, "max_frequency_hz", max_frequency_hz, "positive");
  const RectangularPlate& plate = ground.carrier;
  shapes_->carrier = free_rectangle_modes(plate.length_x_m, plate.length_y_m, plate.material.poisson_ratio,
                                          wavenumber_at(max_frequency_hz, plate.thickness_m, plate.material));
  for (const RectangularMode& mode : shapes_->carrier.modes)
    modes_.push_back(plate_mode(mode.wavenumber_per_m, plate.thickness_m, plate.length_x_m * plate.length_y_m,
                                plate.material, ground.carrier_damping, false));
  if (!ground.disk) return;
  const CircularDisk& disk = *ground.disk;
  shapes_->disk = free_disk_modes(disk.radius_m, disk.material.poisson_ratio,
                                  wavenumber_at(max_frequency_hz, disk.thickness_m, disk.material));
  for (const DiskMode& mode : shapes_->disk)
    modes_.push_back(plate_mode(mode.wavenumber_per_m, disk.thickness_m,
                                std::numbers::pi * disk.radius_m * disk.radius_m, disk.material, ground.disk_damping,
                                true));
}

PlateModes::~PlateModes() = default;
PlateModes::PlateModes(PlateModes&&) noexcept = default;
PlateModes& PlateModes::operator=(PlateModes&&) noexcept = default;

void PlateModes::shapes_under_ball(double x_m, double y_m, std::span<double> shapes) const {
  const std::size_t n_carrier = shapes_->carrier.modes.size();
  shapes_->carrier.shapes_at(x_m, y_m, shapes.first(n_carrier));
  disk_shapes_at(shapes_->disk, x_m, y_m, shapes.subspan(n_carrier));
}

void PlateModes::shapes_under_sensor(double x_m, double y_m, std::span<double> shapes) const {
  const std::size_t n_carrier = shapes_->carrier.modes.size();
  shapes_->carrier.shapes_at(x_m, y_m, shapes.first(n_carrier));
  for (double& shape : shapes.subspan(n_carrier)) shape = ground_.disk_coupling;
}

}  // namespace bouncelab::synthesis
