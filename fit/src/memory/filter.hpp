// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "memory/chains.hpp"
#include "memory/emission.hpp"

namespace bouncelab::fit {

/// The law at one impact.
template <class T>
struct LawAt {
  T eps;
  T slope;  ///< d eps / d v [s/m]
};

/// What all impacts have in common.
template <class T>
struct MemoryParameters {
  T q;        ///< variance of the contacts' offset, per component (docs/physics.md)
  T keep;     ///< share of the reservoir that outlasts a bounce
  T release;  ///< mean reservoir at the release [m^2/s^2]
  T ratio;    ///< 1; of the mean of |t|^2 to 2 q, to test whether both effects of the offset agree
};

/// What a search keeps fixed, so that the likelihood is a smooth function of the parameters: where the first reservoirs
/// of a chain are, and which are carried on together.
struct FilterPlan {
  static constexpr std::uint8_t kDropped = 255;
  std::size_t tightest = 0;                       ///< the impact that allows the least first reservoir
  double scale = 0.0;                             ///< mean of the first reservoir [m^2/s^2]
  std::vector<double> above_least;                ///< first reservoirs less the least one allowed
  std::vector<std::vector<std::uint8_t>> target;  ///< after each impact: where each component goes
};

/// Likelihood of a chain, the reservoir and the errors of the measurement filtered along it.
///
/// The state before an impact is the book of energies
///
///   Omega = w + 2 v d + 2 g h,   d error of the measured speed v, h height of the contact,
///
/// which neither errors of times nor heights change, and d, h and the timing error that the next interval shares. Given
/// the first reservoir, Omega is known to within the small error of what each bounce dissipates; so its distribution is
/// carried as a sum of narrow normal components, one for each of some values of the first reservoir, their weights the
/// posterior. Errors are normal and common to all components; both are updated by the derivatives of the emission's
/// density (Masreliez, IEEE Trans. Autom. Control 20, 107 (1975), doi:10.1109/TAC.1975.1100882). Normal sums: Alspach
/// & Sorenson, ibid. 17, 439 (1972), doi:10.1109/TAC.1972.1100034.
template <class T>
class ChainFilter {
 public:
  ChainFilter(const Chain& chain, double ball_radius_m, const MemoryParameters<T>& parameters)
      : chain_(chain), p_(parameters), height_variance_(square_of(ball_radius_m * (1.0 + kSolidBallInertia) * p_.q)) {}

  /// Where asked for, of each impact given those before it.
  struct Record {
    std::vector<T>* log_densities = nullptr;
    std::vector<double>* transforms = nullptr;  ///< probabilities
    std::vector<double>* reservoirs = nullptr;  ///< mean after the impact, given all up to it [m^2/s^2]
  };

  /// @param law  at each impact
  T loglik(const std::vector<LawAt<T>>& law, const FilterPlan& plan, const Record& record = {}) {
    begin(law, plan);
    T sum(0.0);
    for (std::size_t i = 0; i < chain_.impacts.size(); ++i) {
      const T log_density = impact(i, law[i], record.transforms);
      sum += log_density;
      if (record.log_densities) record.log_densities->push_back(log_density);
      if (record.reservoirs) record.reservoirs->push_back(reservoir_mean());
      if (i + 1 < chain_.impacts.size()) carry_on(plan.target[i]);
    }
    return sum;
  }

  /// As loglik(), and makes the plan on the way.
  T plan(const std::vector<LawAt<T>>& law, FilterPlan& plan) {
    make_start(law, plan);
    begin(law, plan);
    plan.target.clear();
    const std::vector<Ahead> ahead = look_ahead(law);
    T sum(0.0);
    for (std::size_t i = 0; i < chain_.impacts.size(); ++i) {
      sum += impact(i, law[i], nullptr);
      if (i + 1 == chain_.impacts.size()) break;
      plan.target.push_back(targets(ahead[i + 1]));
      carry_on(plan.target[i]);
    }
    return sum;
  }

 private:
  struct Component {
    T log_weight, book, variance;
  };
  /// Errors before an impact: of the speed before it, its height, its time; in m/s. After the update with height and
  /// time of the next impact too.
  using State3 = Eigen::Matrix<T, 3, 1>;
  using Matrix3 = Eigen::Matrix<T, 3, 3>;

  static T square_of(const T& x) { return x * x; }

  /// Mean of |t|^2 given v r and w: t lies on a circle about the point f sqrt(w)/(2 v), by von Mises' density.
  static T mean_offset_square(const T& w, const T& reach, const T& y_by_v, const T& q) {
    const T centre = root(reach * w);
    const T radius = root(rounded_positive<T>(reach * w - y_by_v, square_of(1e-2 * q)));
    const T kappa = centre * radius / q;
    const T r = root(kappa * kappa + 2.25);
    // 1 - I1/I0, to 3 %: Amos, Math. Comp. 28, 239 (1974), doi:10.1090/S0025-5718-1974-0333287-7
    const T rest = (0.5 + 2.25 / (r + kappa)) / (0.5 + r);
    return square_of(centre - radius) + 2.0 * centre * radius * rest;
  }

  /// What the chain says of the least first reservoir, and its softness (standard deviation).
  struct Bound {
    T least;
    double softness = 0.0;
    T slope, offset;  ///< the reservoir before the impact by the first one
  };
  /// The bound by impact i, or over all the highest of them.
  template <class Look>
  void books(const std::vector<LawAt<T>>& law, std::size_t end, Look&& look) const {
    T slope(1.0), offset(0.0);
    for (std::size_t i = 0; i < end; ++i) {
      const ChainImpact& m = chain_.impacts[i];
      const T& e = law[i].eps;
      const T y = m.v_after_mps - e * m.v_mps;
      const double g_timing = m.timing_before + m.timing, height = square(m.height_mps) * value_of(height_variance_);
      const double d_variance = g_timing + 2.0 * height;
      const double y_variance = 4.0 * d_variance;
      // 4 v y / (1 + e), where that is positive
      const double soft_y = y_variance + square(0.1 * value_of(p_.q) * m.v_mps);
      const T need = 4.0 * m.v_mps / (1.0 + e) * rounded_positive<T>(y, T(soft_y));
      const double softness =
          std::sqrt(square(2.0 * m.v_mps) * (d_variance + 4.0 * height) + square(2.0 * m.v_mps) * y_variance);
      look(i, Bound{(need - offset) / slope, softness, slope, offset});
      const T loss = (1.0 - e) / (1.0 + e) * square(m.v_mps + m.v_after_mps) * (1.0 + 2.0 * p_.q);
      offset = p_.keep * (offset + square(m.v_mps) - square(m.v_after_mps) - loss);
      slope *= p_.keep;
    }
  }

  /// The reservoir before an impact by the first one, and the least first one that this impact and later ones allow.
  struct Ahead {
    double slope, offset, least;
  };
  std::vector<Ahead> look_ahead(const std::vector<LawAt<T>>& law) const {
    std::vector<Ahead> ahead;
    books(law, chain_.impacts.size(), [&](std::size_t, const Bound& bound) {
      ahead.push_back({value_of(bound.slope), value_of(bound.offset), value_of(bound.least)});
    });
    for (std::size_t i = ahead.size() - 1; i-- > 0;) ahead[i].least = std::max(ahead[i].least, ahead[i + 1].least);
    return ahead;
  }

  T first_mean() const { return 2.0 * p_.q * chain_.s_before + p_.release; }

  void make_start(const std::vector<LawAt<T>>& law, FilterPlan& plan) const {
    constexpr double kFirst = 1e-3, kLast = 25.0;  // of the mean: what lies outside weighs 1e-3 times a mean density
    constexpr std::size_t kNodes = 27;
    plan.scale = value_of(first_mean());
    plan.above_least.clear();
    double highest = -HUGE_VAL, softness = 0.0;
    books(law, chain_.impacts.size(), [&](std::size_t i, const Bound& bound) {
      const double least = value_of(bound.least) - 4.0 * bound.softness;
      if (least <= highest) return;
      highest = least;
      plan.tightest = i;
      softness = bound.softness;
    });
    const double first = std::max(kFirst * plan.scale, 0.2 * softness);
    const double last = kLast * plan.scale + 10.0 * softness;
    for (std::size_t k = 0; k < kNodes; ++k)
      plan.above_least.push_back(first * pow(last / first, static_cast<double>(k) / (kNodes - 1)));
  }

  void begin(const std::vector<LawAt<T>>& law, const FilterPlan& plan) {
    T least(0.0);
    books(law, plan.tightest + 1, [&](std::size_t i, const Bound& bound) {
      if (i == plan.tightest)
        least = rounded_positive<T>(bound.least - 4.0 * bound.softness, T(square(1e-3 * plan.scale)));
    });
    const T mean = first_mean(), log_mean = logarithm(mean);  // not finite where the mean is negative: outside
    const std::size_t n = plan.above_least.size();
    const double step = log(plan.above_least.back() / plan.above_least.front()) / static_cast<double>(n - 1);
    components_.clear();
    const ChainImpact& first = chain_.impacts.front();
    for (std::size_t k = 0; k < n; ++k) {
      // trapezoids in the logarithm, and what lies below the first node
      const double t = plan.above_least[k];
      const double width = t * (k == 0 ? 1.0 + 0.5 * step : k + 1 == n ? 0.5 * step : step);
      const T w = least + t;
      components_.push_back({log(width) - w / mean - log_mean, w, T(0.0)});
    }
    errors_.setZero();
    covariance_.setZero();
    // d = -H - D + H_before + D_before, of the first interval
    const T height = square(first.height_mps) * height_variance_;
    covariance_(0, 0) = 2.0 * height + first.timing_before + first.timing;
    covariance_(1, 1) = height;
    covariance_(2, 2) = T(first.timing);
    covariance_(0, 1) = covariance_(1, 0) = -height;
    covariance_(0, 2) = covariance_(2, 0) = T(-first.timing);
  }

  /// Log density of what was measured at one impact; brings the state to before the next.
  T impact(std::size_t i, const LawAt<T>& law, std::vector<double>* transforms) {
    const ChainImpact& m = chain_.impacts[i];
    const double v = m.v_mps, after = m.v_after_mps;
    const T& e = law.eps;
    const T y = after - e * v, one_e = 1.0 + e, f = 1.0 + v * law.slope / one_e, inverse_e = 1.0 / e;
    // errors: d, H, D, and of the next impact H' and D'
    const T height_next = square(m.height_mps) * height_variance_ * square_of(inverse_e);
    Eigen::Matrix<T, 5, 5> s = Eigen::Matrix<T, 5, 5>::Zero();
    s.template topLeftCorner<3, 3>() = covariance_;
    s(3, 3) = height_next;
    s(4, 4) = T(m.timing_after);
    Eigen::Matrix<T, 5, 1> mean = Eigen::Matrix<T, 5, 1>::Zero();
    mean.template head<3>() = errors_;
    // y has (e + v e') d + H/e - D - H' + D', the book of energies d + 2 H
    const T by_d = e + v * law.slope;
    const auto in_y = [&](const auto& x) -> T { return by_d * x(0) + inverse_e * x(1) - x(2) - x(3) + x(4); };
    const auto in_speed = [](const auto& x) -> T { return x(0) + 2.0 * x(1); };
    const Eigen::Matrix<T, 5, 1> by_y = s.col(0) * by_d + s.col(1) * inverse_e - s.col(2) - s.col(3) + s.col(4);
    const Eigen::Matrix<T, 5, 1> by_speed = s.col(0) + s.col(1) + s.col(1);
    EmissionInput<T> in;
    in.y = y;
    in.noise_mean = in_y(mean);
    in.a = p_.q * square_of(one_e * f);
    in.b = 2.0 * p_.q * p_.ratio * one_e * v;
    in.noise_variance = in_y(by_y) + square_of(kResolution * in.b);
    const T speed_mean = in_speed(mean), speed_variance = in_speed(by_speed);
    in.covariance = -2.0 * v * in_speed(by_y);

    // approached faster, more often: the weight of a contact (docs/physics.md)
    const T flux = 1.0 + y / (v * one_e) + 2.0 * p_.q;
    const T reach = square_of(f) * T(0.25 / square(v));
    const T loss = (1.0 - e) / one_e * square(v + after);
    const T loss_variance = square_of((1.0 - e) * one_e * square(v)) * (2.0 * p_.q * p_.q) +
                            square_of(2.0 * (1.0 - e) / one_e * (v + after)) * in.noise_variance;
    double tail = 0.0;
    emissions_.clear();
    T highest(-HUGE_VAL);
    for (Component& c : components_) {
      in.reservoir_variance = c.variance + 4.0 * square(v) * speed_variance;
      const T soft = in.reservoir_variance + square_of(0.2 * p_.q * square(v));
      in.reservoir = rounded_positive<T>(c.book - 2.0 * v * speed_mean, soft);
      emissions_.push_back(emission(in));
      const Emission<T>& em = emissions_.back();
      if (transforms) tail += exp(value_of(c.log_weight)) * tail_of(in, em);
      c.log_weight += em.log_density;
      // book of energies: what came, what went, what the bounce dissipated
      const T offset = mean_offset_square(in.reservoir, reach, y / (v * one_e), p_.q);
      const T gain = em.by_reservoir, bend = c.variance * em.curvature_by_reservoir;
      c.book += c.variance * gain + square(v) - square(after) - loss * (1.0 + offset);
      c.variance = (value_of(bend) < 0.0 ? c.variance / (1.0 - bend) : c.variance * (1.0 + bend)) + loss_variance;
      if (value_of(c.log_weight) > value_of(highest)) highest = c.log_weight;
    }
    T sum(0.0), gain(0.0), gain2(0.0), by_reservoir(0.0);
    double spread = 0.0;
    for (std::size_t k = 0; k < components_.size(); ++k) {
      const Emission<T>& em = emissions_[k];
      const T weight = exponential(components_[k].log_weight - highest);
      sum += weight;
      gain += weight * em.by_noise;
      gain2 += weight * (square_of(em.by_noise) + em.curvature_by_noise);
      by_reservoir += weight * em.by_reservoir;
      spread += value_of(weight) * value_of(em.variance);
    }
    const T inverse_sum = 1.0 / sum, log_density = highest + logarithm(sum);
    gain *= inverse_sum;
    gain2 *= inverse_sum;
    by_reservoir *= inverse_sum;
    spread /= value_of(sum);
    for (Component& c : components_) c.log_weight -= log_density;
    if (transforms) {
      // the weight of contacts shifts the distribution by f K'' / (v (1 + e))
      transforms->push_back(std::clamp(tail - spread * exp(value_of(log_density)) / (v * value_of(one_e)), 0.0, 1.0));
    }
    mean += gain * by_y - 2.0 * v * by_reservoir * by_speed;
    const Eigen::Matrix<T, 5, 1> bent = by_y * T(gain2 - gain * gain);
    s += bent * by_y.transpose();
    // d' = -H' - D' + H/e + D
    errors_ << mean(1) * inverse_e + mean(2) - mean(3) - mean(4), mean(3), mean(4);
    const Eigen::Matrix<T, 5, 1> with_d = s.col(1) * inverse_e + s.col(2) - s.col(3) - s.col(4);
    covariance_(0, 0) = with_d(1) * inverse_e + with_d(2) - with_d(3) - with_d(4);
    covariance_(0, 1) = covariance_(1, 0) = with_d(3);
    covariance_(0, 2) = covariance_(2, 0) = with_d(4);
    covariance_(1, 1) = s(3, 3);
    covariance_(1, 2) = covariance_(2, 1) = s(3, 4);
    covariance_(2, 2) = s(4, 4);
    // the leak
    const T lost = 1.0 - p_.keep, error_after = 2.0 * after * (errors_(0) + 2.0 * errors_(1));
    for (Component& c : components_) {
      c.book -= lost * (c.book - error_after);
      c.variance *= square_of(p_.keep);
    }
    return log_density + logarithm(flux);
  }

  double reservoir_mean() const {
    double sum = 0.0;
    for (const Component& c : components_) sum += exp(value_of(c.log_weight)) * value_of(c.book);
    return sum;
  }

  /// Probability of less than y: Lugannani & Rice, Adv. Appl. Prob. 12, 475 (1980), doi:10.2307/1426607.
  double tail_of(const EmissionInput<T>& in, const Emission<T>& em) const {
    const EmissionInput<double> x = values_of(in);
    const Cumulants<double> c(x, em.saddlepoint), zero(x, 0.0);
    const double s = em.saddlepoint, fall = 2.0 * (s * x.y - c.k);
    const double w = (s < 0.0 ? -1.0 : 1.0) * std::sqrt(std::max(0.0, fall)), u = s * std::sqrt(c.k2);
    const double below = 0.5 * erfc(-w * 0.70710678118654752);
    const double density = 0.3989422804014327 * exp(-0.5 * w * w);
    // 1/w - 1/u is a small difference near the mean: its limit there
    const double near = std::abs(u) < 1e-3 ? -zero.k3 / (6.0 * power(std::sqrt(zero.k2), 3)) : 1.0 / w - 1.0 / u;
    return std::clamp(below + density * near, 0.0, 1.0);
  }

  /// Neighbours that are nearly one are carried on as one; those without weight no more. Nearly one: compared with how
  /// far they are from what later impacts allow at least.
  std::vector<std::uint8_t> targets(const Ahead& ahead) const {
    constexpr double kNarrow = 0.005;
    constexpr double kWithoutWeight = -14.0;
    std::vector<std::uint8_t> target(components_.size(), FilterPlan::kDropped);
    int last = -1;
    double weight = 0.0, mean = 0.0, spread = 0.0;
    for (std::size_t k = 0; k < components_.size(); ++k) {
      const Component& c = components_[k];
      if (value_of(c.log_weight) < kWithoutWeight) continue;
      const double w = exp(value_of(c.log_weight)), book = value_of(c.book), own = value_of(c.variance);
      const double both = weight + w, joint = (weight * mean + w * book) / both;
      const double joint_spread = (weight * (spread + square(mean - joint)) + w * (own + square(book - joint))) / both;
      const double room = joint - ahead.offset - ahead.slope * ahead.least;
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

  void carry_on(const std::vector<std::uint8_t>& target) {
    joined_.clear();
    for (std::size_t k = 0; k < components_.size();) {
      if (target[k] == FilterPlan::kDropped) {
        ++k;
        continue;
      }
      std::size_t end = k + 1;
      bool single = true;
      for (; end < components_.size() && (target[end] == target[k] || target[end] == FilterPlan::kDropped); ++end)
        single = single && target[end] == FilterPlan::kDropped;
      if (single) {
        joined_.push_back(components_[k]);
        k = end;
        continue;
      }
      std::size_t heaviest = k;
      for (std::size_t j = k; j < end; ++j)
        if (target[j] != FilterPlan::kDropped &&
            value_of(components_[j].log_weight) > value_of(components_[heaviest].log_weight))
          heaviest = j;
      const T highest = components_[heaviest].log_weight;
      T weight(0.0), mean(0.0), spread(0.0);
      const T origin = components_[heaviest].book;
      for (std::size_t j = k; j < end; ++j) {
        if (target[j] == FilterPlan::kDropped) continue;
        const Component& c = components_[j];
        const T w = exponential(c.log_weight - highest), book = c.book - origin;
        weight += w;
        mean += w * book;
        spread += w * (c.variance + book * book);
      }
      const T inverse = 1.0 / weight;
      mean *= inverse;
      joined_.push_back({highest + logarithm(weight), origin + mean, spread * inverse - mean * mean});
      k = end;
    }
    std::swap(components_, joined_);
  }

  /// Error of y, in units of the mean of (1 + e) v |t|^2, that exact times are taken to have: v r has a greatest value.
  static constexpr double kResolution = 2e-3;

  const Chain& chain_;
  MemoryParameters<T> p_;
  T height_variance_;  ///< of the height of contacts [m^2]
  std::vector<Component> components_, joined_;
  std::vector<Emission<T>> emissions_;
  State3 errors_;
  Matrix3 covariance_;
};

}  // namespace bouncelab::fit
