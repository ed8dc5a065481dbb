// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "memory/chains.hpp"
#include "memory/component_sum.hpp"
#include "memory/emission.hpp"
#include "memory/first_reservoir.hpp"
#include "memory/measurement_errors.hpp"
#include "memory/memory_parameters.hpp"

namespace bouncelab::fit {

/// What a search keeps fixed, so that the likelihood is a smooth function of the parameters: where the first reservoirs
/// of a chain are, and which are carried on together.
struct FilterPlan {
  FirstNodes first;
  std::vector<Targets> targets;  ///< after each impact but the last
};

/// Likelihood of a chain, the reservoir and the errors of the measurement filtered along it.
///
/// The state before an impact is the book of energies
///
///   Omega = w + 2 v d + 4 v H,   d error of the measured speed v, H height of the contact in speed, g h / (2 v),
///
/// which neither errors of times nor heights change, and the errors d, H and the timing error that the next interval
/// shares. Given the first reservoir, Omega is known to within the small error of what each bounce dissipates; so its
/// distribution is carried as a sum of narrow normal components, one for each of some values of the first reservoir,
/// their weights the posterior. Errors are normal and common to all components; both are updated by the derivatives of
/// the emission's density (Masreliez, IEEE Trans. Autom. Control 20, 107 (1975), doi:10.1109/TAC.1975.1100882). Normal
/// sums: Alspach & Sorenson, ibid. 17, 439 (1972), doi:10.1109/TAC.1972.1100034.
template <class T>
class ChainFilter {
 public:
  /// @param chain        outlives the filter
  /// @param height_sd_m  standard deviation of the heights of contacts, Chains::height_sd_m
  ChainFilter(const Chain& chain, const T& height_sd_m, const MemoryParameters<T>& parameters)
      : chain_(chain), p_(parameters), height_variance_(square_of(height_sd_m)) {}

  /// @param law            at each impact
  /// @param log_densities  of each impact given those before it, where asked for
  T loglik(const std::vector<LawAt<T>>& law, const FilterPlan& plan, std::vector<T>* log_densities = nullptr) {
    begin(first_reservoir(law), plan.first);
    T sum(0.0);
    for (std::size_t i = 0; i < chain_.impacts.size(); ++i) {
      T log_density = impact(chain_.impacts[i], law[i], nullptr);
      if (i == 0) log_density += log_start_;
      sum += log_density;
      if (log_densities) log_densities->push_back(log_density);
      if (i + 1 < chain_.impacts.size()) join(components_, plan.targets[i], joined_, parts_);
    }
    return sum;
  }

  /// As loglik(), and makes the plan on the way.
  T plan(const std::vector<LawAt<T>>& law, FilterPlan& plan) { return follow(law, plan, nullptr); }

  /// Probability of less at every impact, given those before it.
  std::vector<double> transforms(const std::vector<LawAt<T>>& law) {
    FilterPlan ignored;
    std::vector<double> transforms;
    follow(law, ignored, &transforms);
    return transforms;
  }

 private:
  FirstReservoir<T> first_reservoir(const std::vector<LawAt<T>>& law) const {
    return {chain_, law, p_, height_variance_};
  }

  T follow(const std::vector<LawAt<T>>& law, FilterPlan& plan, std::vector<double>* transforms) {
    const FirstReservoir<T> first = first_reservoir(law);
    plan = {first.nodes(transforms != nullptr), {}};
    begin(first, plan.first);
    const std::vector<double> least_books = first.least_books();
    T sum = log_start_;
    for (std::size_t i = 0; i < chain_.impacts.size(); ++i) {
      sum += impact(chain_.impacts[i], law[i], transforms);
      if (i + 1 == chain_.impacts.size()) break;
      plan.targets.push_back(targets_of(components_, least_books[i + 1]));
      join(components_, plan.targets[i], joined_, parts_);
    }
    return sum;
  }

  void begin(const FirstReservoir<T>& first, const FirstNodes& nodes) {
    log_start_ = first.components(nodes, components_);
    T sum(0.0);
    for (const Component<T>& c : components_) sum += c.weight;
    for (Component<T>& c : components_) c.weight *= 1.0 / sum;
    log_start_ += logarithm(sum);
    errors_.begin(chain_.impacts.front(), height_variance_);
  }

  /// Log density of what was measured at one impact; brings the state to before the next.
  T impact(const ChainImpact& m, const LawAt<T>& law, std::vector<double>* transforms) {
    const double v = m.v_mps, after = m.v_after_mps;
    const T& e = law.eps;
    const T y = after - e * v, one_e = 1.0 + e, f = 1.0 + v * law.slope / one_e;
    const T q = p_.q * (1.0 + p_.power * log(v));
    errors_.measure(m, law, height_variance_);
    EmissionInput<T> in;
    in.y = y;
    in.noise_mean = errors_.y_mean();
    in.a = q * square_of(one_e * f);
    in.b = 2.0 * q * p_.ratio * one_e * v;
    in.noise_variance = errors_.y_variance() + square_of(kResolution * in.b);
    const T speed_mean = errors_.speed_mean(), speed_variance = errors_.speed_variance();
    in.covariance = -2.0 * v * errors_.covariance();

    // approached faster, more often: the weight of a contact (docs/physics.md)
    const T flux = 1.0 + y / (v * one_e) + 2.0 * q;
    const T reach = square_of(f) * T(0.25 / square(v));
    const T loss = (1.0 - e) / one_e * square(v + after);
    const T loss_variance = square_of((1.0 - e) * one_e * square(v)) * (2.0 * q * q) +
                            square_of(2.0 * (1.0 - e) / one_e * (v + after)) * in.noise_variance;
    double tail = 0.0;
    emissions_.clear();
    for (Component<T>& c : components_) {
      in.reservoir_variance = c.variance + 4.0 * square(v) * speed_variance;
      const T soft = in.reservoir_variance + square_of(0.2 * q * square(v));
      in.reservoir = rounded_positive<T>(c.book - 2.0 * v * speed_mean, soft);
      emissions_.push_back(emission(in));
      const Emission<T>& em = emissions_.back();
      if (transforms) tail += value_of(c.weight) * probability_below(in, em);
      // book of energies: what came, what went, what the bounce dissipated
      const T offset = mean_offset_square(in.reservoir, reach, y / (v * one_e), q);
      const T gain = em.by_reservoir, bend = c.variance * em.curvature_by_reservoir;
      c.book += c.variance * gain + square(v) - square(after) - loss * (1.0 + offset);
      c.variance = (value_of(bend) < 0.0 ? c.variance / (1.0 - bend) : c.variance * (1.0 + bend)) + loss_variance;
    }
    const Together all = together();
    if (transforms) {
      // the weight of contacts shifts the distribution by f K'' / (v (1 + e))
      const double shift = all.variance * exp(value_of(all.log_density)) / (v * value_of(one_e));
      transforms->push_back(std::clamp(tail - shift, 0.0, 1.0));
    }
    errors_.update(all.by_noise, -2.0 * v * all.by_reservoir, all.curvature_by_noise);
    errors_.carry_on();
    // the leak
    const T share = kept(p_, m), lost = 1.0 - share, error_after = 2.0 * after * errors_.speed_mean();
    for (Component<T>& c : components_) {
      c.book -= lost * (c.book - error_after);
      c.variance *= square_of(share);
    }
    return all.log_density + logarithm(flux);
  }

  /// Log density of all components, and its derivatives.
  struct Together {
    T log_density, by_noise, curvature_by_noise, by_reservoir;
    double variance;  ///< mean of Emission::variance
  };
  /// Gives the components' weights what the impact says of them.
  Together together() {
    // the exponent of the heaviest, to within a factor of two
    constexpr double kLogTwo = 0.6931471805599453;
    double highest = -HUGE_VAL;
    for (std::size_t k = 0; k < components_.size(); ++k) {
      const double weight = value_of(components_[k].weight);
      if (weight > 0.0) highest = std::max(highest, value_of(emissions_[k].exponent) + kLogTwo * std::ilogb(weight));
    }
    T sum(0.0), gain(0.0), gain2(0.0), by_reservoir(0.0);
    double variance = 0.0;
    for (std::size_t k = 0; k < components_.size(); ++k) {
      const Emission<T>& em = emissions_[k];
      const T& before = components_[k].weight;
      const T weight = value_of(before) > 0.0 ? T(before * em.factor * exponential(em.exponent - highest)) : T(0.0);
      components_[k].weight = weight;
      sum += weight;
      gain += weight * em.by_noise;
      gain2 += weight * (square_of(em.by_noise) + em.curvature_by_noise);
      by_reservoir += weight * em.by_reservoir;
      variance += value_of(weight) * value_of(em.variance);
    }
    const T inverse_sum = 1.0 / sum;
    for (Component<T>& c : components_) {
      c.weight *= inverse_sum;
      if (!(value_of(c.weight) > kNoWeight)) c.weight = T(0.0);
    }
    gain *= inverse_sum;
    return {highest + logarithm(sum), gain, gain2 * inverse_sum - gain * gain, by_reservoir * inverse_sum,
            variance / value_of(sum)};
  }

  /// Less is none: what is divided by it, and by its square, stays finite.
  static constexpr double kNoWeight = 1e-100;
  /// Error of y, in units of the mean of (1 + e) v |t|^2, that exact times are taken to have: v r has a greatest value.
  static constexpr double kResolution = 2e-3;

  const Chain& chain_;
  MemoryParameters<T> p_;
  T height_variance_;  ///< of the height of contacts [m^2]
  T log_start_;        ///< log of what the first weights are to be multiplied by
  std::vector<Component<T>> components_, joined_;
  std::vector<const Component<T>*> parts_;
  std::vector<Emission<T>> emissions_;
  MeasurementErrors<T> errors_;
};

}  // namespace bouncelab::fit
