// Defines vectors of eight floats by the compiler's vector extension, which works with AVX, SSE or neither.
// Geometry is a template over F8 (ray caster) and double (exact depth, tests).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace ulf::acquisition {

inline constexpr int kLanes = 8;
using F8 = float __attribute__((vector_size(32)));
using I8 = std::int32_t __attribute__((vector_size(32)));
using F4 = float __attribute__((vector_size(16)));

template <typename T>
inline T Splat(double value) {
  return T{} + static_cast<float>(value);
}
template <>
inline double Splat<double>(double value) {
  return value;
}

inline F8 Select(I8 mask, F8 yes, F8 no) { return mask ? yes : no; }
inline I8 Select(I8 mask, I8 yes, I8 no) { return mask ? yes : no; }
inline double Select(bool mask, double yes, double no) { return mask ? yes : no; }

inline bool Any(I8 mask) {
  std::int32_t all = 0;
  for (int i = 0; i < kLanes; ++i) all |= mask[i];
  return all != 0;
}
inline bool Any(bool mask) { return mask; }

inline F8 Sqrt(F8 x) {
  F8 result{};
  for (int i = 0; i < kLanes; ++i) result[i] = std::sqrt(x[i]);
  return result;
}
inline double Sqrt(double x) { return std::sqrt(x); }

template <typename T>
inline T Min(T a, T b) {
  return Select(a < b, a, b);
}
template <typename T>
inline T Max(T a, T b) {
  return Select(a > b, a, b);
}
template <typename T>
inline T Abs(T a) {
  return Select(a < Splat<T>(0), -a, a);
}

template <typename T>
struct Vec3 {
  T x, y, z;
};
template <typename T>
inline Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <typename T>
inline Vec3<T> operator*(T s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <typename T>
inline T Dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace ulf::acquisition
