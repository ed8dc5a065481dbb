// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_data.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kResolution = 1e-8;  // of eps: far below any timing; samples without any scatter are fitted too

std::vector<std::size_t> by_speed(const RestitutionSamples& samples) {
  std::vector<std::pair<double, std::size_t>> places;
  places.reserve(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) places.emplace_back(samples[k].v_mps, k);
  std::sort(places.begin(), places.end());
  std::vector<std::size_t> order;
  order.reserve(samples.size());
  for (const auto& place : places) order.push_back(place.second);
  return order;
}

void check(const RestitutionSamples& samples) {
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const RestitutionSample& s = samples[k];
    if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps) || !(s.v_mps > 0.0))
      throw InvalidArgument("sample " + std::to_string(k) + ": speed " + std::to_string(s.v_mps) + " m/s, eps " +
                            std::to_string(s.eps) + ": must be finite, the speed positive; leave it out");
  }
}

bool is_of(const std::shared_ptr<const LawBasis>& basis, const LawModel& model) {
  return basis && basis->kind == model.kind && basis->orders == model.orders && basis->node_v_mps == model.node_v_mps;
}

}  // namespace

std::shared_ptr<const LawBasis> make_law_basis(const LawModel& model, std::span<const double> v_mps) {
  if (model.is_linear())
    return std::make_shared<LawBasis>(LawBasis{model.kind, model.orders, model.node_v_mps,
                                               model.jacobian(v_mps, Eigen::VectorXd::Ones(model.n_parameters()))});
  const std::vector<double> tenth_powers = powers_of(v_mps, 0.1);
  return std::make_shared<LawBasis>(
      LawBasis{model.kind,
               model.orders,
               {},
               Eigen::Map<const Eigen::VectorXd>(tenth_powers.data(), static_cast<Eigen::Index>(tenth_powers.size()))});
}

LawData thinned(const LawData& all, std::size_t stride) {
  LawData data;
  for (std::size_t k = stride / 2; k < all.size(); k += stride) {
    data.v_mps.push_back(all.v_mps[k]);
    data.eps.push_back(all.eps[k]);
    data.tau.push_back(all.tau[k]);
    data.drop.push_back(all.drop[k]);
  }
  return data;
}

std::shared_ptr<const LawBasis> basis_of(const LawData& data, const LawModel& model) {
  return is_of(data.basis, model) ? data.basis : make_law_basis(model, data.v_mps);
}

LawData law_data(const RestitutionSamples& samples, const std::vector<std::size_t>& order) {
  std::vector<std::size_t> drop_of(samples.size(), samples.size());
  for (const std::size_t k : order) drop_of[k] = 0;
  DropNumbers drops;
  for (std::size_t k = 0; k < samples.size(); ++k)
    if (drop_of[k] == 0) drop_of[k] = drops.of(samples[k]);
  LawData data;
  for (std::vector<double>* column : {&data.v_mps, &data.eps, &data.tau}) column->reserve(order.size());
  data.drop.reserve(order.size());
  for (const std::size_t k : order) {
    const RestitutionSample& s = samples[k];
    data.v_mps.push_back(s.v_mps);
    data.eps.push_back(s.eps);
    data.tau.push_back(hypot(s.sigma_eps.value_or(0.0), kResolution));
    data.drop.push_back(drop_of[k]);
  }
  return data;
}

OrderedSamples ordered_by_speed(const RestitutionSamples& samples) {
  check(samples);
  OrderedSamples ordered{by_speed(samples), {}};
  ordered.data = law_data(samples, ordered.rows);
  return ordered;
}

void widen(LawData& data, const ScatterModel& scatter, double width) {
  const ScaleColumns b = scales_at(scatter, data.v_mps);
  for (std::size_t k = 0; k < data.size(); ++k)
    data.tau[k] = hypot(data.tau[k], width * (0.5 * (b.below[k] + b.above[k])));
}

std::size_t DropNumbers::of(const RestitutionSample& sample) {
  if (last_ == nullptr || last_->drop != sample.drop || last_->recording != sample.recording)
    number_of_last_ = numbers_.try_emplace({sample.recording, sample.drop}, numbers_.size()).first->second;
  last_ = &sample;
  return number_of_last_;
}

}  // namespace bouncelab::fit
