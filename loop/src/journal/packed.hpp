// SPDX-License-Identifier: GPL-3.0-or-later
/// Values as JSON by position, and back: bit by bit the same. For records that the version which wrote them reads.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"

namespace bouncelab::loop {

using PackedJson = nlohmann::json;

// A struct is packed member by member: members(value, use) calls use(value.a, value.b, ...), found by its argument.

PackedJson packed(double x);
PackedJson packed(const Flags& flags);
template <class T>
PackedJson packed(const std::vector<T>& values);
template <class T, std::size_t N>
PackedJson packed(const std::array<T, N>& values);
template <class T>
PackedJson packed(const std::optional<T>& value);
template <class T>
PackedJson packed(const T& value);

void unpack(const PackedJson& json, double& x);
void unpack(const PackedJson& json, Flags& flags);
template <class T>
void unpack(const PackedJson& json, std::vector<T>& values);
template <class T, std::size_t N>
void unpack(const PackedJson& json, std::array<T, N>& values);
template <class T>
void unpack(const PackedJson& json, std::optional<T>& value);
template <class T>
void unpack(const PackedJson& json, T& value);

/// JSON has no infinity and no NaN.
inline PackedJson packed(double x) {
  if (std::isfinite(x)) return x;
  return std::isnan(x) ? "nan" : x > 0.0 ? "inf" : "-inf";
}
inline void unpack(const PackedJson& json, double& x) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!json.is_string())
    x = json.get<double>();
  else if (json == "nan")
    x = std::numeric_limits<double>::quiet_NaN();
  else
    x = json == "inf" ? kInfinity : -kInfinity;
}

inline PackedJson packed(const Flags& flags) { return flags.text(); }
inline void unpack(const PackedJson& json, Flags& flags) { flags = Flags::from_text(json.get<std::string>()); }

template <class T>
PackedJson packed(const std::vector<T>& values) {
  PackedJson json = PackedJson::array();
  for (const T& value : values) json.push_back(packed(value));
  return json;
}
template <class T>
void unpack(const PackedJson& json, std::vector<T>& values) {
  values.resize(json.size());
  for (std::size_t k = 0; k < values.size(); ++k) unpack(json.at(k), values[k]);
}

template <class T, std::size_t N>
PackedJson packed(const std::array<T, N>& values) {
  return packed(std::vector<T>(values.begin(), values.end()));
}
template <class T, std::size_t N>
void unpack(const PackedJson& json, std::array<T, N>& values) {
  for (std::size_t k = 0; k < N; ++k) unpack(json.at(k), values[k]);
}

/// [] or [value]
template <class T>
PackedJson packed(const std::optional<T>& value) {
  PackedJson json = PackedJson::array();
  if (value) json.push_back(packed(*value));
  return json;
}
template <class T>
void unpack(const PackedJson& json, std::optional<T>& value) {
  value.reset();
  if (!json.empty()) unpack(json.at(0), value.emplace());
}

template <class T>
PackedJson packed(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return static_cast<int>(value);
  } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
    return value;
  } else {
    PackedJson json = PackedJson::array();
    members(value, [&](const auto&... member) { (json.push_back(packed(member)), ...); });
    return json;
  }
}
template <class T>
void unpack(const PackedJson& json, T& value) {
  if constexpr (std::is_enum_v<T>) {
    value = static_cast<T>(json.get<int>());
  } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
    value = json.get<T>();
  } else {
    std::size_t k = 0;
    members(value, [&](auto&... member) { (unpack(json.at(k++), member), ...); });
  }
}

/// As a record of a journal: one line.
template <class T>
std::string to_packed_record(const T& value) {
  return packed(value).dump(-1, ' ', false, PackedJson::error_handler_t::replace);
}
/// @throws InvalidArgument where the text is no such record
template <class T>
T from_packed_record(std::string_view record) {
  try {
    T value;
    unpack(PackedJson::parse(record), value);
    return value;
  } catch (const PackedJson::exception& error) {
    throw InvalidArgument(std::string("a record is not of the form expected: ") + error.what());
  }
}

}  // namespace bouncelab::loop
