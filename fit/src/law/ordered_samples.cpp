// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/ordered_samples.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "law/columns.hpp"

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

}  // namespace

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

}  // namespace bouncelab::fit
