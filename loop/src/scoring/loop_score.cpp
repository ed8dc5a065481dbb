// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/loop_score.hpp"

#include "results.hpp"

namespace bouncelab::loop {
namespace {

std::optional<double> constant_of(const RestitutionLaw& law, std::size_t i) {
  const auto* series = std::get_if<SeriesLaw>(&law);
  if (series == nullptr || i >= series->a.size()) return std::nullopt;
  return series->a[i];
}

std::optional<fit::Estimate> eps_at(const fit::FitResult& fit, double v_mps) {
  const fit::NodeEstimate* node = node_at(fit, v_mps);
  return node != nullptr ? std::optional(node->eps) : std::nullopt;
}

std::optional<fit::Estimate> eps_with_memory(const fit::FitResult& fit, double v_mps) {
  if (!fit.memory) return std::nullopt;
  for (const fit::NodeEstimate& node : fit.memory->nodes)
    if (node.v_mps == v_mps) return node.eps;
  return std::nullopt;
}

std::optional<fit::Estimate> parameter(const fit::FitResult& fit, const std::string& name) {
  const fit::Estimate* found = parameter_named(fit, name);
  return found != nullptr ? std::optional(*found) : std::nullopt;
}

std::optional<fit::Estimate> slope_at(const fit::FitResult& fit, double v_mps,
                                      std::optional<fit::Estimate> fit::HistogramFit::*side) {
  const fit::HistogramFit* window = window_at(fit, v_mps);
  return window != nullptr ? window->*side : std::nullopt;
}

}  // namespace

LoopScore score_loop(std::size_t n_drops, const detection::OnsetScore& onsets, const RestitutionLaw& truth,
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
    score.constants.push_back({name, constant_of(truth, i), {parameter(true_times, name), parameter(sound, name)}});
  }
  using Window = fit::HistogramFit;
  for (const double v : {0.3, 0.6, 1.0})
    score.slopes.push_back(
        {v,
         {slope_at(true_times, v, &Window::slope_rising), slope_at(sound, v, &Window::slope_rising)},
         {slope_at(true_times, v, &Window::slope_falling), slope_at(sound, v, &Window::slope_falling)}});
  for (const fit::CurvePoint& point : sound.law.curve)
    score.truth_curve.push_back({point.x, restitution(truth, point.x)});
  return score;
}

}  // namespace bouncelab::loop
