// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "memory/chains.hpp"
#include "memory/emission.hpp"
#include "memory/first_reservoir.hpp"

namespace bouncelab::fit {

/// For each component the number of the one it is carried on in, or kDropped. Parts of one are neighbours.
using Targets = std::vector<std::uint8_t>;
inline constexpr std::uint8_t kDropped = 255;

/// Neighbours that are nearly one are carried on as one; those without weight no more. Nearly one: compared with how
/// far they are from the least book that later impacts allow.
template <class T>
Targets targets_of(const std::vector<Component<T>>& components, double least_book) {
  constexpr double kNarrow = 0.005;
  constexpr double kWithoutWeight = 1e-6;
  Targets target(components.size(), kDropped);
  int last = -1;
  double weight = 0.0, mean = 0.0, spread = 0.0;
  for (std::size_t k = 0; k < components.size(); ++k) {
    const Component<T>& c = components[k];
    const double w = number_of(c.weight);
    if (!(w > kWithoutWeight)) continue;
    const double book = number_of(c.book), own = number_of(c.variance);
    const double both = weight + w, joint = (weight * mean + w * book) / both;
    const double joint_spread = (weight * (spread + square(mean - joint)) + w * (own + square(book - joint))) / both;
    const double room = joint - least_book;
    const bool together = last >= 0 && room > 0.0 && joint_spread < kNarrow * square(room);
    if (together) {
      weight = both;
      mean = joint;
      spread = joint_spread;
    } else {
      ++last;
      weight = w;
      mean = book;
      spread = own;
    }
    target[k] = static_cast<std::uint8_t>(last);
  }
  return target;
}

/// One normal distribution of the same weight, mean and variance as these together.
template <class T>
Component<T> joint_component(const std::vector<const Component<T>*>& parts) {
  if (parts.size() == 1) return *parts.front();
  const T origin = parts.front()->book;
  T weight(0.0), mean(0.0), spread(0.0);
  for (const Component<T>* c : parts) {
    const T book = c->book - origin, weighed = c->weight * book;
    weight += c->weight;
    mean += weighed;
    spread += c->weight * c->variance + weighed * book;
  }
  if (!(number_of(weight) > 0.0)) return *parts.front();
  const T inverse = 1.0 / weight;
  mean *= inverse;
  return {weight, origin + mean, spread * inverse - mean * mean};
}

/// Joins what has the same target.
/// @param joined, parts  storage, used again from impact to impact
template <class T>
void join(std::vector<Component<T>>& components, const Targets& target, std::vector<Component<T>>& joined,
          std::vector<const Component<T>*>& parts) {
  joined.clear();
  parts.clear();
  std::uint8_t current = kDropped;
  for (std::size_t k = 0; k < components.size(); ++k) {
    if (target[k] == kDropped) continue;
    if (target[k] != current && !parts.empty()) {
      joined.push_back(joint_component(parts));
      parts.clear();
    }
    current = target[k];
    parts.push_back(&components[k]);
  }
  if (!parts.empty()) joined.push_back(joint_component(parts));
  std::swap(components, joined);
}

/// Normal errors of what a chain measures, along the chain: d of the speed before an impact, of the height H of its
/// contact and of its time D, and of height H' and time D' of the next; all in m/s. Impacts share them, for an interval
/// has two ends:
///
///   d = H_before + D_before - H - D,   and after a bounce   d' = H/e + D - H' - D'.
template <class T>
class MeasurementErrors {
 public:
  /// Before the first impact of a chain. @param height_variance  of the heights of contacts [m^2]
  void begin(const ChainImpact& first, const T& height_variance) {
    const T height = square_of(T(first.height_mps)) * height_variance;
    mean_.setZero();
    covariance_.setZero();
    covariance_(0, 0) = 2.0 * height + first.timing_before + first.timing;
    covariance_(1, 1) = height;
    covariance_(2, 2) = T(first.timing);
    covariance_(0, 1) = covariance_(1, 0) = -height;
    covariance_(0, 2) = covariance_(2, 0) = T(-first.timing);
  }

  /// The next height and time join, and with them the speed after the impact is measured.
  void measure(const ChainImpact& m, const LawAt<T>& law, const T& height_variance) {
    inverse_e_ = 1.0 / law.eps;
    by_d_ = law.eps + m.v_mps * law.slope;
    covariance_(3, 3) = square_of(T(m.height_mps)) * height_variance * square_of(inverse_e_);
    covariance_(4, 4) = T(m.timing_after);
    with_y_ = covariance_.col(0) * by_d_ + covariance_.col(1) * inverse_e_ - covariance_.col(2) - covariance_.col(3) +
              covariance_.col(4);
    with_speed_ = covariance_.col(0) + covariance_.col(1) + covariance_.col(1);
  }

  /// Error of y = v' - e v: (e + v e') d + H/e - D - H' + D' [m/s].
  T y_mean() const { return in_y(mean_); }
  T y_variance() const { return in_y(with_y_); }
  /// d + 2 H: 2 v times it is what errors add to the book of energies [m/s].
  T speed_mean() const { return in_speed(mean_); }
  T speed_variance() const { return in_speed(with_speed_); }
  T covariance() const { return in_speed(with_y_); }

  /// What y says of the errors: derivatives of the log of its density by the means of both errors, and the second one
  /// by that of y.
  void update(const T& by_y, const T& by_speed, const T& curvature_by_y) {
    mean_ += by_y * with_y_ + by_speed * with_speed_;
    const Vector bent = with_y_ * curvature_by_y;
    covariance_ += bent * with_y_.transpose();
  }

  /// To before the next impact.
  void carry_on() {
    const T d_mean = mean_(1) * inverse_e_ + mean_(2) - mean_(3) - mean_(4);
    const Vector with_d =
        covariance_.col(1) * inverse_e_ + covariance_.col(2) - covariance_.col(3) - covariance_.col(4);
    const T d_variance = with_d(1) * inverse_e_ + with_d(2) - with_d(3) - with_d(4);
    const T height = covariance_(3, 3), both = covariance_(3, 4), time = covariance_(4, 4);
    const T height_mean = mean_(3), time_mean = mean_(4);
    mean_ << d_mean, height_mean, time_mean, T(0.0), T(0.0);
    covariance_.setZero();
    covariance_(0, 0) = d_variance;
    covariance_(0, 1) = covariance_(1, 0) = with_d(3);
    covariance_(0, 2) = covariance_(2, 0) = with_d(4);
    covariance_(1, 1) = height;
    covariance_(1, 2) = covariance_(2, 1) = both;
    covariance_(2, 2) = time;
  }

 private:
  using Vector = Eigen::Matrix<T, 5, 1>;

  T in_y(const Vector& x) const { return by_d_ * x(0) + inverse_e_ * x(1) - x(2) - x(3) + x(4); }
  static T in_speed(const Vector& x) { return x(0) + 2.0 * x(1); }

  Vector mean_;
  Eigen::Matrix<T, 5, 5> covariance_;
  T by_d_, inverse_e_;
  Vector with_y_, with_speed_;  ///< covariances of all errors with these two
};

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
    return follow(
        law, FirstReservoir<T>(chain_, law, p_, height_variance_), plan.first, nullptr,
        [&](std::size_t i) -> const Targets& { return plan.targets[i]; }, log_densities);
  }

  /// As loglik(), and makes the plan on the way.
  /// @param transforms  probability of less at every impact, given those before it, where asked for
  T plan(const std::vector<LawAt<T>>& law, FilterPlan& plan, std::vector<double>* transforms = nullptr) {
    const FirstReservoir<T> first(chain_, law, p_, height_variance_);
    plan = {first.nodes(transforms != nullptr), {}};
    const std::vector<double> least_books = first.least_books();
    return follow(
        law, first, plan.first, transforms,
        [&](std::size_t i) -> const Targets& {
          return plan.targets.emplace_back(targets_of(components_, least_books[i + 1]));
        },
        nullptr);
  }

 private:
  /// @param targets  (impact) which components are one after it
  template <class TargetsAfter>
  T follow(const std::vector<LawAt<T>>& law, const FirstReservoir<T>& first, const FirstNodes& nodes,
           std::vector<double>* transforms, TargetsAfter targets, std::vector<T>* log_densities) {
    T sum(0.0), log_start = begin(first, nodes);
    for (std::size_t i = 0; i < chain_.impacts.size(); ++i) {
      T log_density = impact(chain_.impacts[i], law[i], transforms);
      if (i == 0) log_density += log_start;
      sum += log_density;
      if (log_densities) log_densities->push_back(log_density);
      if (i + 1 < chain_.impacts.size()) join(components_, targets(i), joined_, parts_);
    }
    return sum;
  }

  /// @return log of what the first weights are to be multiplied by
  T begin(const FirstReservoir<T>& first, const FirstNodes& nodes) {
    T log_start = first.components(nodes, components_);
    T sum(0.0);
    for (const Component<T>& c : components_) sum += c.weight;
    for (Component<T>& c : components_) c.weight *= 1.0 / sum;
    log_start += log(sum);
    errors_.begin(chain_.impacts.front(), height_variance_);
    return log_start;
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
      if (transforms) tail += number_of(c.weight) * probability_below(in, em);
      // book of energies: what came, what went, what the bounce dissipated
      const T offset = mean_offset_square(in.reservoir, reach, y / (v * one_e), q);
      const T gain = em.by_reservoir, bend = c.variance * em.curvature_by_reservoir;
      c.book += c.variance * gain + square(v) - square(after) - loss * (1.0 + offset);
      c.variance = (number_of(bend) < 0.0 ? c.variance / (1.0 - bend) : c.variance * (1.0 + bend)) + loss_variance;
    }
    const Together all = together();
    if (transforms) {
      // the weight of contacts shifts the distribution by f K'' / (v (1 + e))
      const double shift = all.variance * exp(number_of(all.log_density)) / (v * number_of(one_e));
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
    return all.log_density + log(flux);
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
      const double weight = number_of(components_[k].weight);
      if (weight > 0.0) highest = std::max(highest, number_of(emissions_[k].exponent) + kLogTwo * std::ilogb(weight));
    }
    T sum(0.0), gain(0.0), gain2(0.0), by_reservoir(0.0);
    double variance = 0.0;
    for (std::size_t k = 0; k < components_.size(); ++k) {
      const Emission<T>& em = emissions_[k];
      const T& before = components_[k].weight;
      const T weight = number_of(before) > 0.0 ? T(before * em.factor * exp(em.exponent - highest)) : T(0.0);
      components_[k].weight = weight;
      sum += weight;
      gain += weight * em.by_noise;
      gain2 += weight * (square_of(em.by_noise) + em.curvature_by_noise);
      by_reservoir += weight * em.by_reservoir;
      variance += number_of(weight) * number_of(em.variance);
    }
    const T inverse_sum = 1.0 / sum;
    for (Component<T>& c : components_) {
      c.weight *= inverse_sum;
      if (!(number_of(c.weight) > kNoWeight)) c.weight = T(0.0);
    }
    gain *= inverse_sum;
    return {highest + log(sum), gain, gain2 * inverse_sum - gain * gain, by_reservoir * inverse_sum,
            variance / number_of(sum)};
  }

  /// Less is none: what is divided by it, and by its square, stays finite.
  static constexpr double kNoWeight = 1e-100;
  /// Error of y, in units of the mean of (1 + e) v |t|^2, that exact times are taken to have: v r has a greatest value.
  static constexpr double kResolution = 2e-3;

  const Chain& chain_;
  MemoryParameters<T> p_;
  T height_variance_;  ///< of the height of contacts [m^2]
  std::vector<Component<T>> components_, joined_;
  std::vector<const Component<T>*> parts_;
  std::vector<Emission<T>> emissions_;
  MeasurementErrors<T> errors_;
};

}  // namespace bouncelab::fit
