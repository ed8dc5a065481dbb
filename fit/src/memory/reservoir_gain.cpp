// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/memory_fit.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {
namespace {

/// The v_c with (1 + eps(v_c)) v_c = impulse_mps, by Newton's method.
double contact_speed(const RestitutionLaw& law, double impulse_mps) {
  double v = 0.5 * impulse_mps;  // within 1 - eps of it, and eps is smooth: four steps are exact to rounding
  for (int k = 0; k < 4; ++k) {
    const double eps = restitution(law, v);
    v -= ((1.0 + eps) * v - impulse_mps) / (1.0 + eps + v * restitution_slope(law, v));
  }
  return v;
}

/// d eps/d parameter at v.
double law_derivative(const RestitutionLaw& law, const std::string& name, double v_mps) {
  if (std::holds_alternative<SeriesLaw>(law)) {
    const auto order = static_cast<std::size_t>(std::stoi(name.substr(1)));
    return kViscoelasticC[order] * pow(v_mps, 0.1 * static_cast<double>(order));
  }
  const auto* viscoelastic = std::get_if<ViscoelasticLaw>(&law);
  if (viscoelastic == nullptr) return 1.0;
  const double step = 1e-4 * viscoelastic->gamma;  // smooth in gamma: relative error 1e-8
  return (restitution(ViscoelasticLaw{viscoelastic->gamma + step}, v_mps) -
          restitution(ViscoelasticLaw{viscoelastic->gamma - step}, v_mps)) /
         (2.0 * step);
}

double root_of_form(const std::vector<double>& x, const Matrix& matrix) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = 0; j < x.size(); ++j) sum += x[i] * matrix[i][j] * x[j];
  return std::sqrt(std::max(0.0, sum));
}

ReservoirGain gain_of(const ImpactChain& chain, const LawWithErrors& fitted, double q, double gravity_mps2) {
  ReservoirGain result;
  double offset_variance = 0.0;
  std::vector<double> by_time(chain.sigma_t_s.size(), 0.0), by_parameter(fitted.parameters.size(), 0.0);
  for (std::size_t k = 0; k < chain.v_mps.size(); ++k) {
    const double v = chain.v_mps[k], after = chain.v_after_mps[k], impulse = v + after;
    const double v_c = contact_speed(fitted.law, impulse * (1.0 + 2.0 * q));
    const double eps = restitution(fitted.law, v_c), lost = 1.0 - eps;
    result.gain_m2ps2 += v * v - after * after - lost * v_c * impulse;
    result.path_m2ps2 += impulse * impulse;
    // t^2 is exponential where w = 0: standard deviation = mean; about the offset that w singles out it scatters less
    offset_variance += square(2.0 * q * lost * (1.0 + eps) * v * v);
    for (std::size_t i = 0; i < by_parameter.size(); ++i)
      by_parameter[i] += 2.0 * v_c * v_c * law_derivative(fitted.law, fitted.parameters[i].name, v_c);
    if (by_time.empty()) continue;
    // of the gain by the speeds before and after the impact, eps taken as constant
    const double by_v = 2.0 * v - 2.0 * lost * v_c, by_v_after = -2.0 * after - 2.0 * lost * v_c;
    by_time[k] -= 0.5 * gravity_mps2 * by_v;
    by_time[k + 1] += 0.5 * gravity_mps2 * (by_v - by_v_after);
    by_time[k + 2] += 0.5 * gravity_mps2 * by_v_after;
  }
  double timing_variance = 0.0;
  for (std::size_t k = 0; k < by_time.size(); ++k) timing_variance += square(by_time[k] * chain.sigma_t_s[k]);
  result.timing_se_m2ps2 = std::sqrt(timing_variance);
  result.offset_se_m2ps2 = std::sqrt(offset_variance);
  if (!fitted.covariance.empty()) result.law_se_m2ps2 = root_of_form(by_parameter, fitted.covariance);
  return result;
}

}  // namespace

std::vector<ReservoirGain> reservoir_gains(const std::vector<ImpactChain>& chains, const LawWithErrors& law,
                                           double gravity_mps2) {
  std::vector<ReservoirGain> gains;
  const auto all = [&](double q) {
    gains.clear();
    double gain = 0.0, path = 0.0;
    for (const ImpactChain& chain : chains) {
      gains.push_back(gain_of(chain, law, q, gravity_mps2));
      gain += gains.back().gain_m2ps2;
      path += gains.back().path_m2ps2;
    }
    return path > 0.0 ? std::max(0.0, gain / (2.0 * path)) : 0.0;
  };
  all(all(0.0));  // q changes the gains by 1 %: once is enough
  return gains;
}

}  // namespace bouncelab::fit
