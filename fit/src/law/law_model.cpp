// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_model.hpp"

#include <ceres/jet.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

/// Rows C_i v^(i/10): eps = 1 + rows A.
Eigen::MatrixXd series_terms(const std::vector<int>& orders, std::span<const double> v_mps) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(v_mps.size()), static_cast<Eigen::Index>(orders.size()));
  for (Eigen::Index i = 0; i < rows.cols(); ++i) {
    const int order = orders[static_cast<std::size_t>(i)];
    const std::vector<double> powers = powers_of(v_mps, 0.1 * order);
    rows.col(i) =
        kViscoelasticC[static_cast<std::size_t>(order)] * Eigen::Map<const Eigen::VectorXd>(powers.data(), rows.rows());
  }
  return rows;
}

void check_orders(const std::vector<int>& orders) {
  std::set<int> seen;
  for (const int order : orders)
    if (order < 2 || order == 3 || order > 10 || !seen.insert(order).second)
      throw InvalidArgument("order " + std::to_string(order) +
                            " of the series: orders are distinct, among 2, 4, 5, 6, 7, 8, 9, 10");
  if (orders.empty()) throw InvalidArgument("orders of the series: at least one is needed, e.g. 2, 4, 5");
}

}  // namespace

double log_gamma_through(double v_mps, double eps) {
  double lo = -40.0, hi = 10.0;  // eps falls with gamma
  for (int i = 0; i < 80; ++i) {
    const double log_gamma = 0.5 * (lo + hi);
    const bool too_bouncy = viscoelastic_restitution(exp(0.5 * log_gamma) * pow(v_mps, 0.1)) > eps;
    (too_bouncy ? lo : hi) = log_gamma;
  }
  return lo;
}

std::pair<double, double> viscoelastic_and_slope(double x) {
  ceres::Jet<double, 1> jet(x);
  jet.v[0] = 0.5 * x;
  const auto eps = viscoelastic_restitution(jet);
  return {eps.a, eps.v[0]};
}

Eigen::Index LawModel::n_parameters() const {
  return kind == LawKind::series ? static_cast<Eigen::Index>(orders.size()) : 1;
}

std::vector<std::string> LawModel::names() const {
  if (kind == LawKind::viscoelastic) return {"gamma"};
  if (kind == LawKind::constant) return {"eps"};
  std::vector<std::string> result;
  for (const int order : orders) result.push_back("A" + std::to_string(order));
  return result;
}

Eigen::MatrixXd LawModel::jacobian(std::span<const double> v_mps, const Eigen::VectorXd& q) const {
  const auto n = static_cast<Eigen::Index>(v_mps.size());
  if (kind == LawKind::constant) return Eigen::MatrixXd::Ones(n, 1);
  if (kind == LawKind::series) return product(series_terms(orders, v_mps), a_of_q);
  Eigen::MatrixXd rows(n, 1);
  for (Eigen::Index k = 0; k < n; ++k)
    rows(k, 0) = viscoelastic_and_slope(exp(0.5 * q[0]) * pow(v_mps[static_cast<std::size_t>(k)], 0.1)).second;
  return rows;
}

Eigen::VectorXd LawModel::eps(std::span<const double> v_mps, const Eigen::VectorXd& q) const {
  const auto n = static_cast<Eigen::Index>(v_mps.size());
  if (kind == LawKind::constant) return Eigen::VectorXd::Constant(n, q[0]);
  if (kind == LawKind::series) return product(series_terms(orders, v_mps), reported(q)).array() + 1.0;
  const double root = exp(0.5 * q[0]);
  const std::vector<double> tenth_powers = powers_of(v_mps, 0.1);
  return Eigen::Map<const Eigen::VectorXd>(tenth_powers.data(), n).unaryExpr([&](double x) {
    return viscoelastic_restitution(root * x);
  });
}

Eigen::VectorXd LawModel::reported(const Eigen::VectorXd& q) const {
  if (kind == LawKind::series) return product(a_of_q, (q.array() - 1.0).matrix());
  if (kind == LawKind::viscoelastic) return Eigen::VectorXd::Constant(1, exp(q[0]));
  return q;
}

Eigen::MatrixXd LawModel::reported_jacobian(const Eigen::VectorXd& q) const {
  if (kind == LawKind::series) return a_of_q;
  if (kind == LawKind::viscoelastic) return Eigen::MatrixXd::Constant(1, 1, exp(q[0]));
  return Eigen::MatrixXd::Identity(q.size(), q.size());
}

RestitutionLaw LawModel::law(const Eigen::VectorXd& q) const {
  if (kind == LawKind::viscoelastic) return ViscoelasticLaw{exp(q[0])};
  if (kind == LawKind::constant) return ConstantLaw{q[0]};
  SeriesLaw series;
  series.a.assign(static_cast<std::size_t>(*std::max_element(orders.begin(), orders.end())) + 1, 0.0);
  const Eigen::VectorXd a = reported(q);
  for (std::size_t i = 0; i < orders.size(); ++i)
    series.a[static_cast<std::size_t>(orders[i])] = a[static_cast<Eigen::Index>(i)];
  return series;
}

Eigen::VectorXd LawModel::values_of(const RestitutionLaw& law) const {
  Eigen::VectorXd q(n_parameters());
  for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = restitution(law, node_v_mps[static_cast<std::size_t>(j)]);
  return kind == LawKind::viscoelastic ? Eigen::VectorXd::Constant(1, log_gamma_through(node_v_mps[0], q[0])) : q;
}

std::vector<double> spread_speeds(std::span<const double> v_mps, std::size_t n) {
  std::vector<double> sorted(v_mps.begin(), v_mps.end());
  std::sort(sorted.begin(), sorted.end());
  // the outermost twentieths may hold stray speeds
  const double lo = sorted[sorted.size() / 20], hi = sorted[sorted.size() - 1 - sorted.size() / 20];
  if (n == 3 && lo <= 0.25 && hi >= 1.2) return {0.25, 0.6, 1.2};
  std::vector<double> speeds;
  for (std::size_t j = 0; j < n; ++j)
    speeds.push_back(n == 1 ? std::sqrt(lo * hi)
                            : lo * pow(hi / lo, static_cast<double>(j) / static_cast<double>(n - 1)));
  return speeds;
}

std::vector<double> node_speeds(std::span<const double> v_mps) {
  std::vector<double> sorted(v_mps.begin(), v_mps.end());
  std::sort(sorted.begin(), sorted.end());
  const std::size_t n = sorted.size();
  const double lo = sorted[n / 10], middle = sorted[n / 2], hi = sorted[n - 1 - n / 10];
  for (const int digits : {2, 3}) {
    const auto rounded = [&](double v, double (*whole)(double)) {
      const int decimals = digits - 1 - static_cast<int>(std::floor(log10(v)));
      // by a positive power of ten: 48 / 100 is the double nearest to 0.48, 48 * 0.01 is not
      const double ten = power(10.0, std::abs(decimals));
      return decimals >= 0 ? whole(v * ten) / ten : whole(v / ten) * ten;
    };
    std::vector<double> nodes{rounded(lo, std::ceil), rounded(middle, std::round), rounded(hi, std::floor)};
    if (nodes[0] < nodes[1] && nodes[1] < nodes[2]) return nodes;
  }
  return {lo, middle, hi};
}

LawModel make_law_model(LawKind kind, const std::vector<int>& orders, std::span<const double> v_mps) {
  LawModel model;
  model.kind = kind;
  if (kind != LawKind::series) {
    model.node_v_mps = spread_speeds(v_mps, 1);
    return model;
  }
  check_orders(orders);
  model.orders = orders;
  model.node_v_mps = spread_speeds(v_mps, orders.size());
  model.a_of_q = inverse(series_terms(orders, model.node_v_mps));
  return model;
}

std::vector<double> speeds_of(const RestitutionSamples& samples) {
  std::vector<double> v_mps;
  v_mps.reserve(samples.size());
  for (const RestitutionSample& s : samples) v_mps.push_back(s.v_mps);
  return v_mps;
}

std::vector<double> powers_of(std::span<const double> v_mps, double exponent) {
  std::vector<double> x(v_mps.begin(), v_mps.end());
  log_each(x);
  for (double& one : x) one *= exponent;
  exp_each(x);
  return x;
}

std::vector<double> residuals_from(const RestitutionLaw& law, const RestitutionSamples& samples) {
  std::vector<double> residuals;
  for (const RestitutionSample& s : samples) residuals.push_back(s.eps - restitution(law, s.v_mps));
  return residuals;
}

double polynomial(std::span<const double> c, double x) {
  double sum = 0.0;
  for (std::size_t k = c.size(); k-- > 0;) sum = sum * x + c[k];
  return sum;
}

std::vector<std::size_t> by_speed(const RestitutionSamples& samples) {
  std::vector<std::pair<double, std::size_t>> places;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const RestitutionSample& s = samples[k];
    if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps) || !(s.v_mps > 0.0))
      throw InvalidArgument("sample " + std::to_string(k) + ": speed " + std::to_string(s.v_mps) + " m/s, eps " +
                            std::to_string(s.eps) + ": must be finite, the speed positive; leave it out");
    places.emplace_back(s.v_mps, k);
  }
  std::sort(places.begin(), places.end());
  std::vector<std::size_t> order;
  for (const auto& place : places) order.push_back(place.second);
  return order;
}

namespace {

/// b = (1 + eps) q (sqrt(1 + S/v^2) +- 1), S the sum of (1 + eps)^2 v^2 over the n earlier impacts of the drop
/// (docs/physics.md, 7): of one eps S/v^2 = (1 + eps)/(1 - eps) (eps^(-2n) - 1).
void add_places(LawData& data, const RestitutionSamples& samples, const std::vector<std::size_t>& order) {
  if (order.empty()) return;
  // at a first impact b_above is 0, and a release that is not quite at rest contradicts it: kLeast leaves room for that
  constexpr double kLeast = 0.5, kMost = 1e6;
  const double eps = std::clamp(median(data.eps), 0.05, 0.9999);
  for (const std::size_t k : order) {
    const double share = std::clamp(
        (1.0 + eps) / (1.0 - eps) * expm1(-2.0 * log(eps) * static_cast<double>(samples[k].impact)), kLeast, kMost);
    const double root = std::sqrt(1.0 + share);
    data.log_below.push_back(log((1.0 + eps) * (root + 1.0)));
    data.log_above.push_back(log((1.0 + eps) * (root - 1.0)));
  }
}

}  // namespace

LawData law_data(const RestitutionSamples& samples, const std::vector<std::size_t>& order) {
  std::vector<std::size_t> drop_of(samples.size(), samples.size());
  for (const std::size_t k : order) drop_of[k] = 0;
  DropNumbers drops;
  for (std::size_t k = 0; k < samples.size(); ++k)
    if (drop_of[k] == 0) drop_of[k] = drops.of(samples[k]);
  LawData data;
  for (const std::size_t k : order) {
    const RestitutionSample& s = samples[k];
    data.v_mps.push_back(s.v_mps);
    data.eps.push_back(s.eps);
    data.tau.push_back(hypot(s.sigma_eps.value_or(0.0), kResolution));
    data.drop.push_back(drop_of[k]);
  }
  add_places(data, samples, order);
  return data;
}

void widen(LawData& data, const ScatterModel& scatter, double width) {
  for (std::size_t k = 0; k < data.size(); ++k) {
    const double v_mps = data.v_mps[k];
    data.tau[k] = hypot(data.tau[k], width * (0.5 * (scatter.below(v_mps) + scatter.above(v_mps))));
  }
}

std::size_t DropNumbers::of(const RestitutionSample& sample) {
  if (last_ == nullptr || last_->drop != sample.drop || last_->recording != sample.recording)
    number_of_last_ = numbers_.try_emplace({sample.recording, sample.drop}, numbers_.size()).first->second;
  last_ = &sample;
  return number_of_last_;
}

}  // namespace bouncelab::fit
