// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/restitution.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

constexpr const char* kBreakingFlags[] = {"doubtful", "inferred", "overlap_merged"};

const char* breaking_flag(const Onset& onset) {
  for (const char* flag : kBreakingFlags)
    if (has_flag(onset.flags, flag)) return flag;
  return nullptr;
}

/// Where an unbroken piece of a drop ends before onset k, and why; nullptr: it goes on.
const char* break_before(std::span<const Onset> drop, std::size_t k) {
  if (drop[k].impact != drop[k - 1].impact + 1) return "missing_impact";
  return nullptr;
}

std::optional<double> sigma_of_eps(const Onset& before, const Onset& here, const Onset& after, double eps, double t_s) {
  if (!before.sigma_t_s || !here.sigma_t_s || !after.sigma_t_s) return std::nullopt;
  return std::hypot(*after.sigma_t_s, (1.0 + eps) * *here.sigma_t_s, eps * *before.sigma_t_s) / t_s;
}

std::optional<double> sigma_of_v(const Onset& before, const Onset& here, double gravity_mps2) {
  if (!before.sigma_t_s || !here.sigma_t_s) return std::nullopt;
  return 0.5 * gravity_mps2 * std::hypot(*before.sigma_t_s, *here.sigma_t_s);
}

RestitutionSample sample_at(std::span<const Onset> piece, std::size_t k, double gravity_mps2) {
  const Onset &before = piece[k - 1], &here = piece[k], &after = piece[k + 1];
  const double interval_s = here.t_s - before.t_s;
  RestitutionSample sample;
  sample.recording = here.recording;
  sample.drop = here.drop;
  sample.impact = here.impact;
  sample.t_s = here.t_s;
  sample.v_mps = 0.5 * gravity_mps2 * interval_s;
  sample.eps = (after.t_s - here.t_s) / interval_s;
  sample.sigma_v_mps = sigma_of_v(before, here, gravity_mps2);
  sample.sigma_eps = sigma_of_eps(before, here, after, sample.eps, interval_s);
  return sample;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Samples at successive impacts: b follows a with nothing between.
bool adjacent(std::span<const RestitutionSample> drop, std::size_t a, std::size_t b) {
  return a < drop.size() && b < drop.size() && drop[b].impact - drop[a].impact == static_cast<std::int64_t>(b - a);
}

/// Flags ratios that only a missed or an invented impact explains. A missed impact makes one interval too long: the
/// ratio there too large, the next too small. An invented one splits an interval: the first ratio that stands out is
/// too small, and the split interval's halves touch up to two samples on either side.
void flag_wrong_intervals(std::span<RestitutionSample> drop, RestitutionCounts& counts) {
  constexpr std::size_t kEnoughForAMedian = 5;
  if (drop.size() < kEnoughForAMedian) return;
  std::vector<double> ratios;
  for (const auto& s : drop) ratios.push_back(s.eps);
  const double m = median(ratios);
  const double factor = std::sqrt(1.0 + m);
  for (std::size_t k = 0; k < drop.size(); ++k) {
    const double ratio = ratios[k] / m;
    if (ratio < factor && ratio > 1.0 / factor) continue;
    const bool missed = ratio > 1.0;
    const char* reason = missed ? "missing_impact" : "extra_impact";
    ++counts.breaks[reason];
    const std::size_t first = !missed && k > 0 && adjacent(drop, k - 1, k) ? k - 1 : k;
    const std::size_t last = k + (missed ? 1 : 2);
    for (std::size_t j = first; j <= last && adjacent(drop, first, j); ++j) {
      add_flag(drop[j].flags, reason);
      k = std::max(k, j);
    }
  }
}

/// Samples of one drop, in time order.
RestitutionSamples samples_of_drop(std::span<const Onset> drop, double gravity_mps2, RestitutionCounts& counts) {
  RestitutionSamples samples;
  std::size_t piece_begin = 0;
  const auto close_piece = [&](std::size_t end) {
    const auto piece = drop.subspan(piece_begin, end - piece_begin);
    for (std::size_t k = 1; k + 1 < piece.size(); ++k) samples.push_back(sample_at(piece, k, gravity_mps2));
  };
  for (std::size_t k = 0; k < drop.size(); ++k) {
    if (k > 0 && drop[k].t_s <= drop[k - 1].t_s)
      throw InvalidArgument("onset " + std::to_string(drop[k].impact) + " of drop " + std::to_string(drop[k].drop) +
                            ": times must increase within a drop; sort the onsets");
    if (const char* flag = breaking_flag(drop[k])) {
      ++counts.breaks[flag];
      close_piece(k);
      piece_begin = k + 1;
    } else if (k > piece_begin) {
      if (const char* reason = break_before(drop, k)) {
        ++counts.breaks[reason];
        close_piece(k);
        piece_begin = k;
      }
    }
  }
  close_piece(drop.size());
  flag_wrong_intervals(samples, counts);
  return samples;
}

/// Median of eps over the samples that nothing is said against.
std::optional<double> median_eps(const RestitutionSamples& samples) {
  std::vector<double> eps;
  for (const RestitutionSample& sample : samples)
    if (sample.flags.empty()) eps.push_back(sample.eps);
  if (eps.empty()) return std::nullopt;
  const auto middle = eps.begin() + static_cast<std::ptrdiff_t>(eps.size() / 2);
  std::nth_element(eps.begin(), middle, eps.end());
  return eps.size() % 2 == 1 ? *middle : 0.5 * (*middle + *std::max_element(eps.begin(), middle));
}

}  // namespace

Restitution restitution_samples(const Onsets& onsets, const RestitutionConfig& config) {
  if (!(config.gravity_mps2 > 0.0) || !std::isfinite(config.gravity_mps2))
    throw InvalidArgument("gravity " + std::to_string(config.gravity_mps2) + " m/s^2: must be positive");
  Restitution result;
  result.counts.n_onsets = onsets.size();
  for (std::size_t begin = 0; begin < onsets.size();) {
    std::size_t end = begin + 1;
    while (end < onsets.size() && onsets[end].recording == onsets[begin].recording &&
           onsets[end].drop == onsets[begin].drop)
      ++end;
    ++result.counts.n_drops;
    auto samples = samples_of_drop(std::span(onsets).subspan(begin, end - begin), config.gravity_mps2, result.counts);
    std::move(samples.begin(), samples.end(), std::back_inserter(result.samples));
    begin = end;
  }
  result.counts.n_samples = result.samples.size();
  result.counts.n_flagged = static_cast<std::size_t>(
      std::count_if(result.samples.begin(), result.samples.end(), [](const auto& s) { return !s.flags.empty(); }));
  result.counts.eps_median = median_eps(result.samples);
  return result;
}

}  // namespace bouncelab
