// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "memory/jets.hpp"

namespace bouncelab::fit {

/// One normal distribution of a sum: of the book of energies, given one first reservoir.
template <class T>
struct Component {
  T weight;
  T book;      ///< mean [m^2/s^2]
  T variance;  ///< [m^4/s^4]
};

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
    const double w = value_of(c.weight);
    if (!(w > kWithoutWeight)) continue;
    const double book = value_of(c.book), own = value_of(c.variance);
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
  if (!(value_of(weight) > 0.0)) return *parts.front();
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

}  // namespace bouncelab::fit
