// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/columns.hpp"

#include <algorithm>
#include <variant>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {
namespace {

/// 1 + sum_i C_i A_i x^i of each x = v^(1/10), in its place.
void evaluate(const SeriesLaw& law, std::span<double> tenth_powers) {
  std::vector<double> terms(std::min(law.a.size(), kViscoelasticC.size()), 0.0);
  for (std::size_t i = 1; i < terms.size(); ++i) terms[i] = kViscoelasticC[i] * law.a[i];
  for (double& x : tenth_powers) {
    double sum = 0.0;
    for (std::size_t i = terms.size(); i-- > 1;) sum = (sum + terms[i]) * x;
    x = 1.0 + sum;
  }
}

std::vector<double> scales_of(const std::vector<double>& c, const std::vector<double>& x) {
  std::vector<double> scales(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    double sum = 0.0;
    for (std::size_t j = c.size(); j-- > 0;) sum = sum * x[k] + c[j];
    scales[k] = sum;
  }
  exp_each(scales);
  return scales;
}

}  // namespace

std::vector<double> powers_of(std::span<const double> v_mps, double exponent) {
  std::vector<double> x(v_mps.begin(), v_mps.end());
  log_each(x);
  for (double& one : x) one *= exponent;
  exp_each(x);
  return x;
}

std::vector<double> restitutions(const RestitutionLaw& law, std::span<const double> v_mps) {
  std::vector<double> eps;
  if (const auto* series = std::get_if<SeriesLaw>(&law)) {
    eps = powers_of(v_mps, 0.1);
    evaluate(*series, eps);
    return eps;
  }
  eps.reserve(v_mps.size());
  for (const double v : v_mps) eps.push_back(restitution(law, v));
  return eps;
}

std::vector<double> residuals_from(const RestitutionLaw& law, const RestitutionSamples& samples) {
  std::vector<double> v_mps;
  v_mps.reserve(samples.size());
  for (const RestitutionSample& s : samples) v_mps.push_back(s.v_mps);
  std::vector<double> residuals = restitutions(law, v_mps);
  for (std::size_t k = 0; k < samples.size(); ++k) residuals[k] = samples[k].eps - residuals[k];
  return residuals;
}

ScaleColumns scales_at(const ScatterModel& scatter, std::span<const double> v_mps) {
  std::vector<double> x;
  x.reserve(v_mps.size());
  for (const double v : v_mps) x.push_back(v / scatter.v_ref_mps);
  log_each(x);
  ScaleColumns scales{scales_of(scatter.log_below, x), {}};
  scales.above = scatter.log_above == scatter.log_below ? scales.below : scales_of(scatter.log_above, x);
  return scales;
}

std::size_t DropNumbers::of(const RestitutionSample& sample) {
  if (last_ == nullptr || last_->drop != sample.drop || last_->recording != sample.recording)
    number_of_last_ = numbers_.try_emplace({sample.recording, sample.drop}, numbers_.size()).first->second;
  last_ = &sample;
  return number_of_last_;
}

}  // namespace bouncelab::fit
