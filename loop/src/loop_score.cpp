// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/loop_score.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/loop/closed_loop.hpp"

namespace bouncelab::loop {
namespace {

bool same_speed(double a_mps, double b_mps) { return std::abs(a_mps - b_mps) < 1e-9; }

std::optional<double> constant_of(const RestitutionLaw& law, std::size_t i) {
  const auto* series = std::get_if<SeriesLaw>(&law);
  if (series == nullptr || i >= series->a.size()) return std::nullopt;
  return series->a[i];
}

std::optional<fit::Estimate> eps_of(const std::vector<fit::NodeEstimate>& nodes, double v_mps) {
  for (const fit::NodeEstimate& node : nodes)
    if (same_speed(node.v_mps, v_mps)) return node.eps;
  return std::nullopt;
}

std::optional<fit::Estimate> eps_with_memory(const fit::FitResult& fit, double v_mps) {
  return fit.memory ? eps_of(fit.memory->nodes, v_mps) : std::nullopt;
}

}  // namespace

std::optional<fit::Estimate> eps_at(const fit::FitResult& fit, double v_mps) { return eps_of(fit.law.nodes, v_mps); }

const fit::HistogramFit* window_at(const fit::FitResult& fit, double v_mps) {
  for (const fit::HistogramFit& h : fit.histograms)
    if (same_speed(h.v_mps, v_mps)) return &h;
  return nullptr;
}

std::optional<fit::Estimate> slope_at(const fit::FitResult& fit, double v_mps,
                                      std::optional<fit::Estimate> fit::HistogramFit::*side) {
  const fit::HistogramFit* window = window_at(fit, v_mps);
  return window != nullptr ? window->*side : std::nullopt;
}

std::optional<fit::Estimate> parameter_named(const fit::FitResult& fit, std::string_view name) {
  for (const fit::NamedEstimate& p : fit.law.parameters)
    if (p.name == name) return p.estimate;
  return std::nullopt;
}

LoopScore score_loop(std::size_t n_drops, const DetectorScore& onsets, const RestitutionLaw& truth,
                     const fit::FitResult& true_times, const fit::FitResult& sound) {
  LoopScore score;
  score.n_drops = n_drops;
  score.n_samples = sound.n_used;
  score.onsets = onsets;
  for (const fit::NodeEstimate& node : sound.law.nodes)
    score.nodes.push_back({node.v_mps,
                           restitution(truth, node.v_mps),
                           {eps_at(true_times, node.v_mps), eps_at(sound, node.v_mps)},
                           {eps_with_memory(true_times, node.v_mps), eps_with_memory(sound, node.v_mps)}});
  for (const std::size_t i : {2, 4, 5}) {
    const std::string name = "A" + std::to_string(i);
    score.constants.push_back(
        {name, constant_of(truth, i), {parameter_named(true_times, name), parameter_named(sound, name)}});
  }
  using Window = fit::HistogramFit;
  for (const double v : {0.3, 0.6, 1.0})
    score.slopes.push_back(
        {v,
         {slope_at(true_times, v, &Window::slope_rising), slope_at(sound, v, &Window::slope_rising)},
         {slope_at(true_times, v, &Window::slope_falling), slope_at(sound, v, &Window::slope_falling)}});
  if (sound.curve)
    for (const fit::CurvePoint& point : sound.curve->points)
      score.truth_curve.push_back({point.x, restitution(truth, point.x)});
  return score;
}

std::vector<SlopeWindow> slopes_of(const LoopResult& loop) {
  std::vector<SlopeWindow> slopes;
  const std::size_t n = std::min(loop.sound.histograms.size(), loop.direct.histograms.size());
  for (std::size_t k = 0; k < n; ++k) {
    const fit::HistogramFit &direct = loop.direct.histograms[k], &sound = loop.sound.histograms[k];
    if (!direct.slope_rising || !sound.slope_rising || !direct.slope_falling || !sound.slope_falling) continue;
    slopes.push_back({sound.v_mps,
                      direct.n,
                      sound.n,
                      {*direct.slope_rising, *sound.slope_rising},
                      {*direct.slope_falling, *sound.slope_falling}});
  }
  return slopes;
}

}  // namespace bouncelab::loop
