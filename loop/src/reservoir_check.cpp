// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/theory.hpp"

#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace bouncelab::loop {
namespace {

constexpr std::size_t kFewestDrops = 3;  // for a correlation

std::optional<fit::LawWithErrors> law_of(const fit::FitResult& fitted, bool& with_memory) {
  with_memory = fitted.memory && fitted.memory->law;
  if (with_memory) return fit::LawWithErrors{*fitted.memory->law, fitted.memory->parameters, fitted.memory->covariance};
  if (!fitted.law.law) return std::nullopt;
  return fit::LawWithErrors{*fitted.law.law, fitted.law.parameters, fitted.law.covariance};
}

/// For each onset its sample; null where it has none, or one that the fit leaves out.
std::vector<const RestitutionSample*> samples_by_onset(const Onsets& onsets, const RestitutionSamples& samples) {
  const auto key = [](const auto& row) { return std::tie(row.recording, row.drop, row.impact); };
  std::vector<const RestitutionSample*> of(onsets.size(), nullptr);
  std::size_t k = 0;
  for (std::size_t i = 0; i < onsets.size() && k < samples.size(); ++i) {  // samples are ordered as the onsets
    if (key(onsets[i]) != key(samples[k])) continue;
    const RestitutionSample& s = samples[k++];
    if (s.flags.empty() && std::isfinite(s.v_mps) && s.v_mps > 0.0 && std::isfinite(s.eps) && s.eps > -1.0) of[i] = &s;
  }
  return of;
}

/// True impacts begin ... end - 1, of each of which there is a sample.
struct Stretch {
  std::size_t begin = 0, end = 0;
  std::size_t size() const { return end - begin; }
};

/// The longest stretch of each drop over which neither truth nor onsets skip one.
std::vector<Stretch> longest_stretches(const Onsets& truth, const std::vector<std::optional<std::size_t>>& match,
                                       const std::vector<const RestitutionSample*>& sample_of) {
  std::vector<Stretch> longest;
  const auto same_drop = [&](std::size_t a, std::size_t b) {
    return truth[a].recording == truth[b].recording && truth[a].drop == truth[b].drop;
  };
  const auto has_sample = [&](std::size_t k) { return match[k] && sample_of[*match[k]] != nullptr; };
  const auto follows = [&](std::size_t k) {
    return same_drop(k - 1, k) && truth[k].impact == truth[k - 1].impact + 1 && has_sample(k - 1) &&
           *match[k] == *match[k - 1] + 1;
  };
  Stretch now;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const bool new_drop = k == 0 || !same_drop(k - 1, k);
    if (new_drop) longest.emplace_back();
    if (!has_sample(k)) {
      now = {k, k};
      continue;
    }
    if (new_drop || now.size() == 0 || !follows(k)) now = {k, k};
    now.end = k + 1;
    if (now.size() > longest.back().size()) longest.back() = now;
  }
  std::erase_if(longest, [](const Stretch& s) { return s.size() < 2; });
  return longest;
}

fit::ImpactChain chain_of(const Stretch& stretch, const Onsets& onsets,
                          const std::vector<std::optional<std::size_t>>& match,
                          const std::vector<const RestitutionSample*>& sample_of) {
  fit::ImpactChain chain;
  const std::size_t first = *match[stretch.begin];
  for (std::size_t i = first; i < first + stretch.size(); ++i) {
    chain.v_mps.push_back(sample_of[i]->v_mps);
    chain.v_after_mps.push_back(sample_of[i]->eps * sample_of[i]->v_mps);
  }
  // a sample is of three onsets that follow each other
  for (std::size_t i = first - 1; i < first + stretch.size() + 1; ++i)
    chain.sigma_t_s.push_back(onsets[i].sigma_t_s.value_or(0.0));
  return chain;
}

double root_mean_square(const std::vector<ReservoirOfDrop>& drops, const auto& of) {
  double sum = 0.0;
  for (const ReservoirOfDrop& drop : drops) sum += of(drop) * of(drop);
  return std::sqrt(sum / static_cast<double>(drops.size()));
}

void compare(ReservoirCheck& check) {
  const auto n = static_cast<double>(check.drops.size());
  double mean_simulated = 0.0, mean_sound = 0.0;
  for (const ReservoirOfDrop& drop : check.drops) {
    mean_simulated += drop.simulated_m2ps2 / n;
    mean_sound += drop.sound.gain_m2ps2 / n;
  }
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (const ReservoirOfDrop& drop : check.drops) {
    const double x = drop.simulated_m2ps2 - mean_simulated, y = drop.sound.gain_m2ps2 - mean_sound;
    xx += x * x, yy += y * y, xy += x * y;
  }
  check.correlation = xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0;
  check.mean_difference_m2ps2 = mean_sound - mean_simulated;
  const auto rms = [&](const auto& of) { return root_mean_square(check.drops, of); };
  check.rms_simulated_m2ps2 = rms([](const auto& d) { return d.simulated_m2ps2; });
  check.rms_difference_m2ps2 = rms([](const auto& d) { return d.sound.gain_m2ps2 - d.simulated_m2ps2; });
  check.expected_timing_m2ps2 = rms([](const auto& d) { return d.sound.timing_se_m2ps2; });
  check.expected_offset_m2ps2 = rms([](const auto& d) { return d.sound.offset_se_m2ps2; });
  if (check.drops.front().sound.law_se_m2ps2)
    check.expected_law_m2ps2 = rms([](const auto& d) { return *d.sound.law_se_m2ps2; });
}

}  // namespace

std::optional<ReservoirCheck> reservoir_check(const Impacts& simulated, const std::vector<sim::Reservoir>& reservoirs,
                                              const Onsets& truth, const Onsets& onsets,
                                              const std::vector<std::optional<std::size_t>>& match,
                                              const RestitutionSamples& samples, const fit::FitResult& fitted,
                                              double gravity_mps2) {
  ReservoirCheck check;
  const std::optional<fit::LawWithErrors> law = law_of(fitted, check.with_memory);
  if (!law) return std::nullopt;
  std::map<std::pair<std::int64_t, std::int64_t>, const sim::Reservoir*> reservoir_after;  // drop and impact
  for (std::size_t k = 0; k < simulated.rows.size(); ++k)
    reservoir_after[{simulated.rows[k].drop, simulated.rows[k].impact}] = &reservoirs[k];
  const auto sample_of = samples_by_onset(onsets, samples);
  std::vector<fit::ImpactChain> chains;
  double spin = 0.0, total = 0.0;
  for (const Stretch& stretch : longest_stretches(truth, match, sample_of)) {
    // of the first impact of all there is no sample: an impact before the stretch exists
    const Onset &first = truth[stretch.begin], &last = truth[stretch.end - 1];
    const auto begin = reservoir_after.find({first.drop, first.impact - 1}),
               end = reservoir_after.find({last.drop, last.impact});
    if (begin == reservoir_after.end() || end == reservoir_after.end()) continue;
    const double total_m2ps2 = end->second->total_m2ps2();
    check.drops.push_back({first.drop, first.impact, last.impact, total_m2ps2 - begin->second->total_m2ps2(), {}});
    chains.push_back(chain_of(stretch, onsets, match, sample_of));
    spin += end->second->spin_m2ps2;
    total += total_m2ps2;
  }
  if (check.drops.size() < kFewestDrops || !(total > 0.0)) return std::nullopt;
  const std::vector<fit::ReservoirGain> gains = fit::reservoir_gains(chains, *law, gravity_mps2);
  for (std::size_t k = 0; k < gains.size(); ++k) check.drops[k].sound = gains[k];
  check.spin_share = spin / total;
  compare(check);
  return check;
}

}  // namespace bouncelab::loop
