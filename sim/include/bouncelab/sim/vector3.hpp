// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::sim {

/// A vector of three-dimensional space.
struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;
};

constexpr Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vector3 operator-(Vector3 a) { return {-a.x, -a.y, -a.z}; }
constexpr Vector3 operator*(double s, Vector3 a) { return {s * a.x, s * a.y, s * a.z}; }
constexpr double dot(Vector3 a, Vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vector3 cross(Vector3 a, Vector3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double norm2(Vector3 a) { return dot(a, a); }
inline double norm(Vector3 a) { return std::sqrt(norm2(a)); }
/// @param a  not zero
inline Vector3 normalized(Vector3 a) { return (1.0 / norm(a)) * a; }

/// Unit quaternion; here always the orientation body -> lab.
struct Quaternion {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;
};

constexpr Quaternion operator*(Quaternion p, Quaternion q) {
  return {p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z, p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
          p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x, p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w};
}
constexpr Quaternion conjugate(Quaternion q) { return {q.w, -q.x, -q.y, -q.z}; }
inline Quaternion normalized(Quaternion q) {
  const double s = 1.0 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}
/// q a q*: the vector `a` of the body seen from the lab. @param q  of unit length
constexpr Vector3 rotate(Quaternion q, Vector3 a) {
  const Vector3 v{q.x, q.y, q.z};
  const Vector3 t = 2.0 * cross(v, a);
  return a + q.w * t + cross(v, t);
}
/// Rotation by the vector of rotation (axis times angle, in rad); the identity for the zero vector.
inline Quaternion rotation_by(Vector3 rotation_rad) {
  const double angle = norm(rotation_rad);
  if (angle == 0.0) return {};
  const SinCos half = sin_cos(0.5 * angle);
  const double s = half.sin / angle;
  return {half.cos, s * rotation_rad.x, s * rotation_rad.y, s * rotation_rad.z};
}

}  // namespace bouncelab::sim
