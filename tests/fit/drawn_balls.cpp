// SPDX-License-Identifier: GPL-3.0-or-later
#include "drawn_balls.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "bouncelab/core/random.hpp"

namespace bouncelab::testing {
namespace {

constexpr double kAirDensity_kgpm3 = 1.2, kAirViscosity_pas = 1.82e-5;
constexpr double kPiHere = 3.141592653589793;

/// Müller & Pöschel, Phys. Rev. E 84, 021302 (2011). @param q  root of the dissipation parameter
double viscoelastic(double v, const std::vector<double>& q) {
  const double x = q[0] * std::pow(v, 0.1);
  return (1 + 0.501086 * x) / (1 + x * (0.501086 + x * (1.15345 + x * (0.577977 + x * 0.532178))));
}

// of steel: Hertz's contact on glass
constexpr double kSteelRadius_m = 0.005;
const double kSteelMass_kg = 4.0 / 3.0 * kPiHere * std::pow(kSteelRadius_m, 3.0) * 7900.0;
const double kSteelOnGlass_pa = 1.0 / ((1.0 - 0.3 * 0.3) / 200e9 + (1.0 - 0.23 * 0.23) / 70e9);
const double kSteelTau_s =
    2.943 * std::pow(15.0 * kSteelMass_kg / (16.0 * kSteelOnGlass_pa * std::sqrt(kSteelRadius_m)), 0.4);

const std::vector<DrawnBall> kDrawnBalls{
    {"steel:10mm", kSteelRadius_m, kSteelMass_kg, kSteelTau_s, -0.2, 0.1},
    {"table-tennis", 0.020, 2.7e-3, 0.8e-3, 0.0, 0.2},
    {"superball:27mm", 0.0135, 1100.0 * 4.0 / 3.0 * kPiHere* std::pow(0.0135, 3.0), 2.9e-3, -0.1, 0.25},
    {"golf", 0.021335, 45.93e-3, 0.48e-3, -0.2, 0.2}};

// of the table of flights: a ratio of 1.04 between speeds, and cubics between them, are right to 1e-7
constexpr int kSpeeds = 120, kFactors = 8;
constexpr double kSlowest_mps = 0.05, kFastestLaunch_mps = 6.0, kLeastFactor = 0.5, kLargestFactor = 1.6;
const double kSpeedStep = std::log(kFastestLaunch_mps / kSlowest_mps) / (kSpeeds - 1);  // of ln u
constexpr double kFactorStep = (kLargestFactor - kLeastFactor) / (kFactors - 1);

/// Four neighbours on a grid, and the weights of the cubic through them.
struct Cubic {
  int first;
  std::array<double, 4> weights;
  Cubic(double place, int n) : first(std::clamp(static_cast<int>(std::floor(place)) - 1, 0, n - 4)) {
    for (int i = 0; i < 4; ++i) {
      weights[i] = 1.0;
      for (int j = 0; j < 4; ++j)
        if (j != i) weights[i] *= (place - first - j) / (i - j);
    }
  }
};

/// Mean 0 and standard deviation 1.
double unit_scatter(Random& random, double skew) {
  if (skew == 1.0) return random.normal();
  const double b = 1.0 / std::sqrt(1.0 + skew * skew);
  const bool below = random.uniform() < skew / (1.0 + skew);
  const double e = random.exponential();
  return (below ? -e * skew * b : e * b) - (1.0 - skew) * b;
}

/// A cell's own seed: FNV-1a of its name.
std::uint64_t seed_of(const std::string& name) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return hash;
}

/// The fluctuations of one drop's impacts, in standard deviations of the scatter.
std::vector<double> fluctuations(const Cell& cell, Random& random, DrawnTable& table) {
  std::vector<double> z(static_cast<std::size_t>(cell.most_bounces));
  std::vector<bool> is_outlier(z.size());
  const double offset = cell.along == AlongDrop::offset ? cell.along_size * random.normal() : 0.0;
  double before = 0.0;
  for (std::size_t k = 0; k < z.size(); ++k) {
    double one = unit_scatter(random, cell.skew);
    if (cell.along == AlongDrop::ar && k > 0)
      one = cell.along_size * before + std::sqrt(1.0 - cell.along_size * cell.along_size) * one;
    before = one;
    is_outlier[k] = random.uniform() < cell.outliers;
    const double off = random.uniform() < 0.5 ? -kOutlierDistance : kOutlierDistance;
    z[k] = one + offset + (is_outlier[k] ? off : 0.0);
  }
  table.offsets.push_back(offset);
  table.is_outlier.push_back(std::move(is_outlier));
  return z;
}

}  // namespace

double standard_drag_coefficient(double reynolds) {
  static const std::vector<std::pair<double, double>> curve{{1.0, 27.2},   {3.0, 10.5},    {10.0, 4.26}, {30.0, 2.12},
                                                            {100.0, 1.09}, {300.0, 0.665}, {1e3, 0.471}, {3e3, 0.396},
                                                            {1e4, 0.405},  {3e4, 0.46},    {1e5, 0.50},  {3e5, 0.40}};
  const double x = std::log(std::clamp(reynolds, 1.0, 3e5));
  for (std::size_t k = 1; k < curve.size(); ++k) {
    const double a = std::log(curve[k - 1].first), b = std::log(curve[k].first);
    if (x > b) continue;
    const double share = (x - a) / (b - a);
    return std::exp((1.0 - share) * std::log(curve[k - 1].second) + share * std::log(curve[k].second));
  }
  return curve.back().second;
}

IntegratedFlight flight_in_air(double radius_m, double mass_kg, double drag_factor, double launch_mps, int n_steps) {
  const double area_m2 = kPiHere * radius_m * radius_m;
  return integrated_flight(launch_mps, kDrawnGravity_mps2, n_steps, [&](double speed_mps) {
    const double reynolds = 2.0 * radius_m * speed_mps * kAirDensity_kgpm3 / kAirViscosity_pas;
    return reynolds > 0.0 ? 0.5 * kAirDensity_kgpm3 * drag_factor * standard_drag_coefficient(reynolds) * area_m2 *
                                speed_mps * speed_mps / mass_kg
                          : 0.0;
  });
}

double eps_by_thornton(double v_mps, double yield_mps) {
  const double y = std::min(1.0, yield_mps / v_mps);
  return std::sqrt(1.2 * std::sqrt(3.0) * (1.0 - y * y / 6.0)) *
         std::pow(y / (y + 2.0 * std::sqrt(1.2 - 0.2 * y * y)), 0.25);
}

const std::vector<DrawnLaw>& drawn_laws() {
  using Constants = std::vector<double>;
  static const auto constant = [](double, const Constants& q) { return q[0]; };
  static const std::vector<DrawnLaw> laws{
      {"const75", constant, {0.75}, "golf"},
      {"const90", constant, {0.90}, "superball:27mm"},
      {"visco", viscoelastic, {0.4105}, "golf"},  // .80 at 1 m/s
      {"linear", [](double v, const Constants& q) { return q[0] + q[1] * std::log(v); }, {0.85, -0.03}, "table-tennis"},
      {"johnson", [](double v, const Constants& q) { return q[0] * std::pow(v, -0.25); }, {0.60}, "steel:10mm"},
      {"thornton",
       [](double v, const Constants& q) { return q[1] * eps_by_thornton(v, q[0]); },
       {0.30, 0.97},
       "steel:10mm"},
      {"thornton1", [](double v, const Constants& q) { return eps_by_thornton(v, q[0]); }, {0.10}, "steel:10mm"},
      {"kink",
       [](double v, const Constants& q) { return q[0] * std::min(1.0, std::pow(v / q[1], -0.25)); },
       {0.85, 0.80},
       "steel:10mm"},
      {"bump",
       [](double v, const Constants& q) {
         const double z = std::log(v / 1.3) / 0.15;
         return q[0] + q[1] * std::exp(-0.5 * z * z);
       },
       {0.90, -0.01},
       "steel:10mm"},
      {"step", [](double v, const Constants& q) { return v > 0.66 ? q[0] : q[1]; }, {0.92, 0.86}, "table-tennis"}};
  return laws;
}

std::string Cell::name() const {
  return law + "_d" + std::to_string(n_drops) + "b" + std::to_string(most_bounces) +
         (variant.empty() ? "" : "_" + variant);
}

const DrawnLaw& Cell::its_law() const {
  for (const DrawnLaw& one : drawn_laws())
    if (one.name == law) return one;
  throw std::invalid_argument("no law " + law);
}

const DrawnBall& Cell::its_ball() const {
  for (const DrawnBall& ball : kDrawnBalls)
    if (ball.name == its_law().ball) return ball;
  throw std::invalid_argument("no ball " + its_law().ball);
}

double Cell::scatter_at(double v_mps) const { return scatter * std::pow(v_mps, -power); }

FlightTable::FlightTable(const DrawnBall& ball) {
  for (int i = 0; i < kSpeeds; ++i)
    for (int j = 0; j < kFactors; ++j) {
      const double u_mps = kSlowest_mps * std::exp(i * kSpeedStep);
      IntegratedFlight one = flight_in_air(ball.radius_m, ball.mass_kg, kLeastFactor + j * kFactorStep, u_mps, 400);
      one.duration_s /= u_mps;
      one.landing_mps /= u_mps;
      over_launch_.push_back(one);
    }
}

IntegratedFlight FlightTable::at(double launch_mps, double drag_factor) const {
  const Cubic by_speed(std::log(launch_mps / kSlowest_mps) / kSpeedStep, kSpeeds);
  const Cubic by_factor((drag_factor - kLeastFactor) / kFactorStep, kFactors);
  IntegratedFlight flight{0.0, 0.0};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const double weight = launch_mps * by_speed.weights[i] * by_factor.weights[j];
      const auto& one = over_launch_[static_cast<std::size_t>((by_speed.first + i) * kFactors + by_factor.first + j)];
      flight.duration_s += weight * one.duration_s;
      flight.landing_mps += weight * one.landing_mps;
    }
  return flight;
}

double FlightTable::launch_mps(double duration_s, double drag_factor) const {
  double u_mps = 0.5 * kDrawnGravity_mps2 * duration_s;
  // duration over launch speed hardly changes: of the error a tenth at most is left
  for (double ratio = 2.0; std::abs(ratio - 1.0) > 1e-12;) {
    ratio = duration_s / at(u_mps, drag_factor).duration_s;
    u_mps *= ratio;
  }
  return u_mps;
}

const FlightTable& flights_of(const DrawnBall& ball) {
  static std::map<std::string, FlightTable> tables;
  const auto there = tables.find(ball.name);
  return there != tables.end() ? there->second : tables.emplace(ball.name, FlightTable(ball)).first->second;
}

DrawnTable draw(const Cell& cell, std::uint64_t number) {
  Random random(seed_of(cell.name()), RandomStream::test, number);
  const DrawnLaw& law = cell.its_law();
  const DrawnBall& ball = cell.its_ball();
  const FlightTable& flights = flights_of(ball);
  DrawnTable table;
  // the program allows drag 10 % of the standard curve's
  table.kappa_factor = std::clamp(std::exp(0.1 * random.normal()), 0.6, 1.5);
  table.tau_factor = std::exp(ball.tau_spread * random.normal());
  for (int drop = 0; drop < cell.n_drops; ++drop) {
    const double still_mps = std::sqrt(2.0 * kDrawnGravity_mps2 * random.uniform(cell.height_m[0], cell.height_m[1]));
    // a fall loses half of what a flight does
    double v_mps = std::sqrt(still_mps * flights.at(still_mps, table.kappa_factor).landing_mps);
    double t_s = random.uniform(0.2, 0.3);
    const std::vector<double> z = fluctuations(cell, random, table);
    for (int k = 0; k < cell.most_bounces && (k == 0 || v_mps > cell.threshold_mps); ++k) {
      Onset onset;
      onset.recording = "a";
      onset.drop = drop;
      onset.impact = k;
      onset.t_s = t_s + cell.sigma_t_s * random.normal();
      onset.sigma_t_s = cell.sigma_t_s;
      table.onsets.push_back(onset);
      table.exact_s.push_back(t_s);
      const double eps = law.eps(v_mps, law.constants) + cell.scatter_at(v_mps) * z[static_cast<std::size_t>(k)];
      const IntegratedFlight flight = flights.at(std::max(v_mps * eps, 0.06), table.kappa_factor);
      t_s += ball.tau_1_s * table.tau_factor * std::pow(v_mps, ball.tau_exponent) + flight.duration_s;
      v_mps = flight.landing_mps;
    }
  }
  return table;
}

double mean_eps(const Cell& cell, const DrawnTable& table, double v_mps) {
  const DrawnLaw& law = cell.its_law();
  const double own = cell.n_drops == 1 ? table.offsets[0] * cell.scatter_at(v_mps) : 0.0;
  return law.eps(v_mps, law.constants) + own;
}

double rms_eps(const Cell& cell, const DrawnTable& table, double v_mps) {
  const bool drops_differ = cell.n_drops > 1 && cell.along == AlongDrop::offset;
  const double of_drops = drops_differ ? cell.along_size : 0.0;
  return std::hypot(mean_eps(cell, table, v_mps), cell.scatter_at(v_mps), of_drops * cell.scatter_at(v_mps));
}

}  // namespace bouncelab::testing
