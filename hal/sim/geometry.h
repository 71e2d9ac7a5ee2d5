// Vectors, rotations and poses of the simulated world, in metres; axes x right, y down, z forward. Single
// precision is enough for rays (1e-5 px over 40 m); times stay double. Value types, reentrant.
#pragma once

#include <algorithm>
#include <cmath>

namespace hdrcam {

struct Vec3 {
  float x = 0, y = 0, z = 0;

  friend Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
  friend Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
};
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalized(Vec3 a) { return a * (1 / std::max(1e-12f, length(a))); }
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Linear radiance, relative; also albedo.
using Colour = Vec3;
inline float luminance(Colour c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }  // Rec. 709
// Of log2 radiance, in stops.
inline Colour exp2(Colour stops) { return {std::exp2(stops.x), std::exp2(stops.y), std::exp2(stops.z)}; }
inline Colour grey(float stops) { return {stops, stops, stops}; }

// By columns.
struct Mat3 {
  Vec3 c0{1, 0, 0}, c1{0, 1, 0}, c2{0, 0, 1};

  friend Vec3 operator*(const Mat3& m, Vec3 v) { return m.c0 * v.x + m.c1 * v.y + m.c2 * v.z; }
  friend Mat3 operator*(const Mat3& a, const Mat3& b) { return {a * b.c0, a * b.c1, a * b.c2}; }
};
inline Vec3 transposed_times(const Mat3& m, Vec3 v) { return {dot(m.c0, v), dot(m.c1, v), dot(m.c2, v)}; }
inline Mat3 transposed_times(const Mat3& a, const Mat3& b) {
  return {transposed_times(a, b.c0), transposed_times(a, b.c1), transposed_times(a, b.c2)};
}

// About `axis`, right-handed (Rodrigues).
inline Mat3 rotation(Vec3 axis, double angle_rad) {
  const Vec3 k = normalized(axis);
  const float c = static_cast<float>(std::cos(angle_rad)), s = static_cast<float>(std::sin(angle_rad));
  const auto turned = [&](Vec3 v) { return v * c + cross(k, v) * s + k * (dot(k, v) * (1 - c)); };
  return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})};
}

// T_world_body.
struct Pose {
  Mat3 rotation;
  Vec3 position;
};

struct Vec2 {
  float x = 0, y = 0;
};

}  // namespace hdrcam
