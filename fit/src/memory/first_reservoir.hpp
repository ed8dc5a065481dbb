// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "memory/chains.hpp"
#include "memory/emission.hpp"

namespace bouncelab::fit {

/// One normal distribution of a sum: of the book of energies, given one first reservoir.
template <class T>
struct Component {
  T weight;
  T book;      ///< mean [m^2/s^2]
  T variance;  ///< [m^4/s^4]
};

/// First reservoirs that a chain is followed from.
struct FirstNodes {
  std::size_t tightest = 0;         ///< the impact that allows the least first reservoir
  double scale = 0.0;               ///< mean of the first reservoir [m^2/s^2]
  std::vector<double> above_least;  ///< first reservoirs less the least one allowed, rising [m^2/s^2]
  /// The least one allowed less first reservoirs, rising: those that only later impacts exclude; empty where what comes
  /// later may be known [m^2/s^2]
  std::vector<double> below_least;
};

/// The reservoir before the first impact of a chain: exponential, and not less than the impacts allow. An impact with
/// y = v' - e v > 0 needs a reservoir of 4 v y / (1 + e) before it, which by the book of energies is the first one less
/// what was dissipated and given back until then.
template <class T>
class FirstReservoir {
 public:
  /// All but the parameters have to outlive it. @param height_variance  of the heights of contacts [m^2]
  FirstReservoir(const Chain& chain, const std::vector<LawAt<T>>& law, const MemoryParameters<T>& parameters,
                 const T& height_variance)
      : chain_(chain), law_(law), p_(parameters), height_variance_(height_variance) {}

  /// @param with_excluded  also reservoirs that later impacts exclude, as a prediction from earlier ones has to
  FirstNodes nodes(bool with_excluded) const {
    constexpr double kFirst = 1e-3, kLast = 25.0;  // of the mean: what lies outside weighs 1e-3 times a mean density
    constexpr std::size_t kNodes = 27;
    // in place of a mean that is not positive, as parameters drawn from few drops may have it: components() refuses it
    constexpr double kLeastScale_m2ps2 = 1e-30;
    FirstNodes nodes;
    const double all_mean = number_of(mean());
    nodes.scale = all_mean > kLeastScale_m2ps2 ? all_mean : kLeastScale_m2ps2;
    double highest = -HUGE_VAL, softness = 0.0;
    follow(chain_.impacts.size(), [&](std::size_t i, const Bound& bound) {
      const double least = number_of(bound.least) - 4.0 * bound.softness;
      if (least <= highest) return;
      highest = least;
      nodes.tightest = i;
      softness = bound.softness;
    });
    const double first = std::max(kFirst * nodes.scale, 0.2 * softness);
    const double last = kLast * nodes.scale + 10.0 * softness;
    for (std::size_t k = 0; k < kNodes; ++k)
      nodes.above_least.push_back(first * pow(last / first, static_cast<double>(k) / (kNodes - 1)));
    if (with_excluded && highest > 2.0 * first && std::isfinite(highest)) {
      const auto n = static_cast<std::size_t>(std::ceil((kNodes - 1) * log(highest / first) / log(last / first)));
      for (std::size_t k = 0; k <= n; ++k)
        nodes.below_least.push_back(first * pow(highest / first, static_cast<double>(k) / static_cast<double>(n)));
    }
    return nodes;
  }

  /// The density of the first reservoir, as a sum of those at the nodes.
  /// @returns log of what the weights are to be multiplied by, which may be less than a double holds; not a number
  /// where
  ///          the mean is not positive
  T components(const FirstNodes& nodes, std::vector<Component<T>>& components) const {
    T least(0.0);
    follow(nodes.tightest + 1, [&](std::size_t i, const Bound& bound) {
      if (i == nodes.tightest)
        least = rounded_positive<T>(bound.least - 4.0 * bound.softness, T(square(1e-3 * nodes.scale)));
    });
    const T all_mean = mean(), inverse_mean = 1.0 / all_mean;
    components.clear();
    const auto add = [&](double from_least, double width) {
      components.push_back({T(width) * inverse_mean * exp(-from_least * inverse_mean), least + from_least, T(0.0)});
    };
    const std::vector<double> below = widths(nodes.below_least), above = widths(nodes.above_least);
    for (std::size_t k = below.size(); k-- > 0;) add(-nodes.below_least[k], below[k]);
    for (std::size_t k = 0; k < above.size(); ++k) add(nodes.above_least[k], above[k]);
    return number_of(all_mean) > 0.0 ? T(-least * inverse_mean) : T(std::numeric_limits<double>::quiet_NaN());
  }

  /// Before each impact the least book of energies that it and later impacts allow [m^2/s^2].
  std::vector<double> least_books() const {
    std::vector<double> slope, offset, least;
    follow(chain_.impacts.size(), [&](std::size_t, const Bound& bound) {
      slope.push_back(number_of(bound.slope));
      offset.push_back(number_of(bound.offset));
      least.push_back(number_of(bound.least));
    });
    std::vector<double> books(least.size());
    double highest = -HUGE_VAL;
    for (std::size_t i = least.size(); i-- > 0;) {
      highest = std::max(highest, least[i]);
      books[i] = offset[i] + slope[i] * highest;
    }
    return books;
  }

 private:
  /// What one impact says of the first reservoir.
  struct Bound {
    T least;
    double softness = 0.0;  ///< standard deviation of `least`
    T slope, offset;        ///< the reservoir before the impact is offset + slope times the first one
  };

  /// Of trapezoids in the logarithm; the first has what lies below it too.
  static std::vector<double> widths(const std::vector<double>& nodes) {
    std::vector<double> widths = nodes;
    if (nodes.empty()) return widths;
    const double step = log(nodes.back() / nodes.front()) / static_cast<double>(nodes.size() - 1);
    for (double& w : widths) w *= step;
    widths.front() = nodes.front() * (1.0 + 0.5 * step);
    widths.back() *= 0.5;
    return widths;
  }

  T mean() const { return 2.0 * p_.q * chain_.s_before + p_.release; }

  /// Follows the book of energies over the first impacts; look(i, bound) at each.
  template <class Look>
  void follow(std::size_t n_impacts, Look&& look) const {
    T slope(1.0), offset(0.0);
    for (std::size_t i = 0; i < n_impacts; ++i) {
      const ChainImpact& m = chain_.impacts[i];
      const T& e = law_[i].eps;
      const T y = m.v_after_mps - e * m.v_mps;
      const double timing = m.timing_before + m.timing, height = square(m.height_mps) * number_of(height_variance_);
      const double d_variance = timing + 2.0 * height;
      const double y_variance = 4.0 * d_variance;
      // 4 v y / (1 + e), where that is positive
      const double soft_y = y_variance + square(0.1 * number_of(p_.q) * m.v_mps);
      const T need = 4.0 * m.v_mps / (1.0 + e) * rounded_positive<T>(y, T(soft_y));
      const double softness =
          std::sqrt(square(2.0 * m.v_mps) * (d_variance + 4.0 * height) + square(2.0 * m.v_mps) * y_variance);
      look(i, Bound{(need - offset) / slope, softness, slope, offset});
      const T loss = (1.0 - e) / (1.0 + e) * square(m.v_mps + m.v_after_mps) * (1.0 + 2.0 * p_.q);
      const T share = kept(p_, m);
      offset = share * (offset + square(m.v_mps) - square(m.v_after_mps) - loss);
      slope *= share;
    }
  }

  const Chain& chain_;
  const std::vector<LawAt<T>>& law_;
  MemoryParameters<T> p_;
  T height_variance_;
};

}  // namespace bouncelab::fit
