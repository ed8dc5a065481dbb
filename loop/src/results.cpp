// SPDX-License-Identifier: GPL-3.0-or-later
#include "results.hpp"

#include <cmath>

namespace bouncelab::loop {
namespace {

bool same_speed(double a_mps, double b_mps) { return std::abs(a_mps - b_mps) < 1e-9; }

}  // namespace

const fit::NodeEstimate* node_at(const fit::FitResult& fit, double v_mps) {
  for (const fit::NodeEstimate& node : fit.law.nodes)
    if (same_speed(node.v_mps, v_mps)) return &node;
  return nullptr;
}

const fit::HistogramFit* window_at(const fit::FitResult& fit, double v_mps) {
  for (const fit::HistogramFit& h : fit.histograms)
    if (same_speed(h.v_mps, v_mps)) return &h;
  return nullptr;
}

const fit::HistogramFit* window_with_slopes(const fit::FitResult& fit, double v_mps) {
  for (const fit::HistogramFit& h : fit.histograms)
    if (same_speed(h.v_mps, v_mps) && h.slope_rising && h.slope_falling) return &h;
  return nullptr;
}

const fit::Estimate* parameter_named(const fit::FitResult& fit, std::string_view name) {
  for (const fit::NamedEstimate& p : fit.law.parameters)
    if (p.name == name) return &p.estimate;
  return nullptr;
}

}  // namespace bouncelab::loop
