#include "acquisition/simulator/scene/primitive.h"

namespace ulf::acquisition {
namespace {

constexpr float kPi = 3.14159265358979f;

template <typename T>
T Infinity() {
  return Splat<T>(0) + Splat<T>(std::numeric_limits<float>::infinity());
}

// Returns the distance to the point of the ray closest to the solid's origin. Intersections are computed from
// there, so that single precision works with numbers of the solid's size instead of the camera's distance.
template <typename T>
T Approach(const Vec3<T>& o, const Vec3<T>& d) {
  return -Dot(o, d);
}

template <typename T>
T NearestAhead(T a, T b) {
  const T zero = Splat<T>(0), infinity = Infinity<T>();
  const T near = Min(a, b), far = Max(a, b);
  return Select(near > zero, near, Select(far > zero, far, infinity));
}

template <typename T>
T IntersectSphere(float radius, const Vec3<T>& o, const Vec3<T>& d) {
  const T walk = Approach(o, d);
  const Vec3<T> closest = o + walk * d;
  const T inside2 = Splat<T>(radius) * Splat<T>(radius) - Dot(closest, closest);
  const auto hit = inside2 > Splat<T>(0);
  if (!Any(hit)) return Infinity<T>();
  const T half_chord = Sqrt(Max(inside2, Splat<T>(0)));
  return Select(hit, NearestAhead(walk - half_chord, walk + half_chord), Infinity<T>());
}

template <typename T>
T Guarded(T x) {  // never zero, for divisions
  const T tiny = Splat<T>(1e-12);
  return Select(Abs(x) < tiny, tiny, x);
}

template <typename T>
struct Slab {
  T enter, leave;
};

template <typename T>
Slab<T> CrossBox(const std::array<float, 3>& half, const Vec3<T>& o, const Vec3<T>& d) {
  const auto along = [](T origin, T direction, float size) {
    const T inverse = Splat<T>(1) / Guarded(direction);
    const T a = (Splat<T>(-size) - origin) * inverse, b = (Splat<T>(size) - origin) * inverse;
    return Slab<T>{Min(a, b), Max(a, b)};
  };
  const Slab<T> x = along(o.x, d.x, half[0]), y = along(o.y, d.y, half[1]), z = along(o.z, d.z, half[2]);
  return {Max(Max(x.enter, y.enter), z.enter), Min(Min(x.leave, y.leave), z.leave)};
}

template <typename T>
T IntersectBox(const std::array<float, 3>& half, const Vec3<T>& o, const Vec3<T>& d) {
  const Slab<T> slab = CrossBox(half, o, d);
  return Select(slab.enter <= slab.leave, NearestAhead(slab.enter, slab.leave), Infinity<T>());
}

template <typename T>
T IntersectRoom(const std::array<float, 3>& half, const Vec3<T>& o, const Vec3<T>& d) {
  const Slab<T> slab = CrossBox(half, o, d);
  return Select(slab.leave > Splat<T>(0), slab.leave, Infinity<T>());
}

// x^2 + y^2 = (bottom + slope z)^2 between z = 0 and z = height, and the two discs that close it.
template <typename T>
T IntersectFrustum(const std::array<float, 3>& size, const Vec3<T>& o, const Vec3<T>& d) {
  const T zero = Splat<T>(0), infinity = Infinity<T>(), height = Splat<T>(size[2]);
  const T slope = Splat<T>((static_cast<double>(size[1]) - size[0]) / size[2]), bottom = Splat<T>(size[0]);
  const T walk = Approach(o, d);
  const Vec3<T> p = o + walk * d;
  const T radius = bottom + slope * p.z, growth = slope * d.z;
  const T a = Guarded(d.x * d.x + d.y * d.y - growth * growth);
  const T b = p.x * d.x + p.y * d.y - radius * growth;
  const T c = p.x * p.x + p.y * p.y - radius * radius;
  const T discriminant = b * b - a * c;
  const T root = Sqrt(Max(discriminant, zero));
  T best = infinity;
  const auto offer = [&](T step, auto valid) {
    const T t = walk + step;
    best = Select(valid & (t > zero) & (t < best), t, best);
  };
  for (const T step : {(-b - root) / a, (-b + root) / a}) {
    const T z = p.z + step * d.z;
    offer(step, (discriminant > zero) & (z >= zero) & (z <= height));
  }
  const T inverse = Splat<T>(1) / Guarded(d.z);
  for (const auto& [level, disc] : {std::pair{height, size[1]}, std::pair{zero, size[0]}}) {
    const T step = (level - p.z) * inverse;
    const T x = p.x + step * d.x, y = p.y + step * d.y;
    offer(step, x * x + y * y <= Splat<T>(disc) * Splat<T>(disc));
  }
  return best;
}

// Sphere tracing, because the distance to a torus has a simple closed form and the intersection does not.
template <typename T>
T IntersectTorus(const std::array<float, 3>& size, const Vec3<T>& o, const Vec3<T>& d) {
  const T zero = Splat<T>(0), ring = Splat<T>(size[0]), tube = Splat<T>(size[1]);
  const T bound = ring + tube;
  const T walk = Approach(o, d);
  const Vec3<T> closest = o + walk * d;
  const T inside2 = bound * bound - Dot(closest, closest);
  const T half_chord = Sqrt(Max(inside2, zero));
  const T enter = Max(-half_chord, -walk);  // not behind the eye
  auto active = (inside2 > zero) & (half_chord > -walk);
  if (!Any(active)) return Infinity<T>();
  const T close = Splat<T>(sizeof(T) == sizeof(double) ? 1e-10 : 5e-7);
  T step = enter;
  auto found = step > Splat<T>(1e30);  // none yet
  T distance = zero;
  for (int i = 0; i < (sizeof(T) == sizeof(double) ? 500 : 96); ++i) {
    const Vec3<T> p = closest + step * d;
    const T across = Sqrt(p.x * p.x + p.y * p.y) - ring;
    distance = Sqrt(across * across + p.z * p.z) - tube;
    found = found | (active & (distance < close));
    active = active & (distance >= close) & (step < half_chord);
    if (!Any(active)) break;
    step = Select(active, step + distance, step);
  }
  // Rays along a silhouette converge slowly: those that are this close count as hits.
  found = found | (active & (distance < Splat<T>(1e-5)));
  return Select(found & (step <= half_chord), walk + step, Infinity<T>());
}

// The bust: ellipsoids that flow into each other (smooth minimum of Quilez 2013).
struct Ellipsoid {
  float center[3], radii[3];
};
constexpr Ellipsoid kBustParts[] = {
    {{0, -0.02f, 0.17f}, {0.108f, 0.13f, 0.15f}},   // head
    {{0, -0.146f, 0.15f}, {0.02f, 0.04f, 0.045f}},  // nose
    {{0, -0.09f, 0.06f}, {0.06f, 0.06f, 0.05f}},    // chin
    {{0, 0, -0.02f}, {0.072f, 0.076f, 0.16f}},      // neck
    {{0, 0.015f, -0.16f}, {0.21f, 0.12f, 0.13f}},   // shoulders
};
constexpr float kBustMelt = 0.08f;   // over which length the parts flow into each other, in heights
constexpr float kBustReach = 0.38f;  // of its surface from the origin, in heights
constexpr int kMostBustSteps = 500;  // along a ray that grazes it
constexpr float kBustStride = 0.6f;  // of the distance that is a bound only near an ellipsoid

// About the distance to the surface, negative inside; in heights, as is `p`.
template <typename T>
T ToBust(const Vec3<T>& p) {
  const T melt = Splat<T>(kBustMelt), zero = Splat<T>(0);
  T nearest = zero;
  bool first = true;
  for (const Ellipsoid& part : kBustParts) {
    const Vec3<T> q{p.x - Splat<T>(part.center[0]), p.y - Splat<T>(part.center[1]),
                    p.z - Splat<T>(part.center[2])};
    const Vec3<T> by{q.x / Splat<T>(part.radii[0]), q.y / Splat<T>(part.radii[1]),
                     q.z / Splat<T>(part.radii[2])};
    const Vec3<T> by2{by.x / Splat<T>(part.radii[0]), by.y / Splat<T>(part.radii[1]),
                      by.z / Splat<T>(part.radii[2])};
    const T share = Sqrt(Dot(by, by));
    const T distance = share * (share - Splat<T>(1)) / Max(Sqrt(Dot(by2, by2)), Splat<T>(1e-6));
    if (first) {
      nearest = distance;
      first = false;
      continue;
    }
    const T close = Max(melt - Abs(nearest - distance), zero);
    nearest = Min(nearest, distance) - close * close / (Splat<T>(4) * melt);
  }
  return nearest;
}

// Marches along the ray; then halves the last stride, because the distance is not exact.
template <typename T>
T IntersectBust(float height, const Vec3<T>& o, const Vec3<T>& d) {
  const T zero = Splat<T>(0), scale = Splat<T>(1) / Splat<T>(height);
  const T bound = Splat<T>(kBustReach);
  const Vec3<T> origin = scale * o;
  const T walk = Approach(origin, d);
  const Vec3<T> closest = origin + walk * d;
  const T inside2 = bound * bound - Dot(closest, closest);
  const T half_chord = Sqrt(Max(inside2, zero));
  auto active = (inside2 > zero) & (half_chord > -walk);
  if (!Any(active)) return Infinity<T>();
  T step = Max(-half_chord, -walk), before = step;
  const T shortest = Splat<T>(2e-4);
  auto found = step > Splat<T>(1e30);  // none yet
  for (int i = 0; i < kMostBustSteps; ++i) {
    const T distance = ToBust(closest + step * d);
    found = found | (active & (distance < zero));
    active = active & (distance >= zero) & (step < half_chord);
    if (!Any(active)) break;
    before = Select(active, step, before);
    step = Select(active, step + Max(Splat<T>(kBustStride) * distance, shortest), step);
  }
  for (int i = 0; i < (sizeof(T) == sizeof(double) ? 40 : 14); ++i) {
    const T middle = Splat<T>(0.5) * (before + step);
    const auto inside = ToBust(closest + middle * d) < zero;
    step = Select(inside, middle, step);
    before = Select(inside, before, middle);
  }
  return Select(found, Splat<T>(height) * (walk + step), Infinity<T>());
}

Eigen::Vector3f BustNormal(float height, const Eigen::Vector3f& local) {
  constexpr double kStep = 1e-4;
  const Eigen::Vector3d p = local.cast<double>() / height;
  const auto at = [&](int axis, double step) {
    Eigen::Vector3d q = p;
    q[axis] += step;
    return ToBust(Vec3<double>{q.x(), q.y(), q.z()});
  };
  Eigen::Vector3d slope;
  for (int axis = 0; axis < 3; ++axis) slope[axis] = at(axis, kStep) - at(axis, -kStep);
  return slope.normalized().cast<float>();
}

// Returns how far the surface is from the origin in a direction, unit.
float BustRadius(float height, const Eigen::Vector3f& direction) {
  const Eigen::Vector3d d = direction.cast<double>();
  double inside = 0, outside = kBustReach;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (inside + outside);
    (ToBust(Vec3<double>{middle * d.x(), middle * d.y(), middle * d.z()}) < 0 ? inside : outside) = middle;
  }
  return static_cast<float>(inside * height);
}

struct Face {
  int axis, u, v;
  float sign;
};
Face FaceOf(int chart) {
  const int axis = chart / 2;
  return {axis, (axis + 1) % 3, (axis + 2) % 3, chart % 2 == 0 ? 1.0f : -1.0f};
}

Vec3<float> ToVec3(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

SurfacePoint OnBox(const std::array<float, 3>& half, const Eigen::Vector3f& p, float outward) {
  int axis = 0;
  float most = -1;
  for (int i = 0; i < 3; ++i) {
    const float share = std::abs(p[i]) / half[static_cast<std::size_t>(i)];
    if (share > most) {
      most = share;
      axis = i;
    }
  }
  const Face face = FaceOf(2 * axis + (p[axis] < 0 ? 1 : 0));
  SurfacePoint surface;
  surface.chart = 2 * axis + (p[axis] < 0 ? 1 : 0);
  surface.u = 0.5f + 0.5f * p[face.u] / half[static_cast<std::size_t>(face.u)];
  surface.v = 0.5f + 0.5f * p[face.v] / half[static_cast<std::size_t>(face.v)];
  surface.normal = {0, 0, 0};
  (axis == 0 ? surface.normal.x : axis == 1 ? surface.normal.y : surface.normal.z) = face.sign * outward;
  return surface;
}

// On the face of a cube round the origin, in the direction of the point; the normal is a sphere's.
SurfacePoint OnSphere(const Eigen::Vector3f& p) {
  int axis = 0;
  p.cwiseAbs().maxCoeff(&axis);
  const int chart = 2 * axis + (p[axis] < 0 ? 1 : 0);
  const Face face = FaceOf(chart);
  const float inverse = 1 / std::max(1e-9f, std::abs(p[axis]));
  return {chart, 0.5f + 0.5f * p[face.u] * inverse, 0.5f + 0.5f * p[face.v] * inverse,
          ToVec3(p.normalized())};
}

float Turn(float y, float x) {  // the angle as a share of a full turn, 0 to 1
  const float turn = std::atan2(y, x) / (2 * kPi);
  return turn < 0 ? turn + 1 : turn;
}

}  // namespace

int Primitive::ChartCount() const { return shape == Shape::kTorus ? 1 : shape == Shape::kFrustum ? 3 : 6; }

Vec3<float> Primitive::BoundCenter() const {
  return shape == Shape::kFrustum ? Vec3<float>{0, 0, 0.5f * size[2]} : Vec3<float>{0, 0, 0};
}

float Primitive::BoundRadius() const {
  switch (shape) {
    case Shape::kSphere:
      return size[0];
    case Shape::kFrustum:
      return std::hypot(std::max(size[0], size[1]), 0.5f * size[2]);
    case Shape::kTorus:
      return size[0] + size[1];
    case Shape::kBust:
      return kBustReach * size[0];
    default:
      return std::hypot(size[0], size[1], size[2]);
  }
}

double Primitive::FarthestFrom(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d p = local_from_world * point_in_world;
  const double across = std::hypot(p.x(), p.y());
  switch (shape) {
    case Shape::kSphere:
      return p.norm() + size[0];
    case Shape::kFrustum:  // one of the two rims
      return std::max(std::hypot(across + size[0], p.z()), std::hypot(across + size[1], p.z() - size[2]));
    case Shape::kTorus:  // on the far side of the ring, in the direction of the tube's middle
      return std::hypot(across + size[0], p.z()) + size[1];
    case Shape::kBust:
      return p.norm() + BoundRadius();
    default:
      return std::hypot(std::abs(p.x()) + size[0], std::abs(p.y()) + size[1], std::abs(p.z()) + size[2]);
  }
}

SurfacePoint SurfaceAt(const Primitive& primitive, const Vec3<float>& local) {
  const auto& size = primitive.size;
  const Eigen::Vector3f p(local.x, local.y, local.z);
  switch (primitive.shape) {
    case Shape::kBox:
      return OnBox(size, p, 1);
    case Shape::kRoom:
      return OnBox(size, p, -1);
    case Shape::kSphere:
      return OnSphere(p);
    case Shape::kBust: {
      SurfacePoint surface = OnSphere(p);
      surface.normal = ToVec3(BustNormal(size[0], p));
      return surface;
    }
    case Shape::kFrustum: {
      const float across = std::hypot(p.x(), p.y());
      const float slope = (size[1] - size[0]) / size[2];
      const float off_side = std::abs(across - (size[0] + slope * p.z()));
      const float off_top = std::abs(p.z() - size[2]), off_bottom = std::abs(p.z());
      if (off_side <= std::min(off_top, off_bottom)) {
        const float scale = 1 / (std::max(across, 1e-9f) * std::sqrt(1 + slope * slope));
        return {0,
                Turn(p.y(), p.x()),
                p.z() / size[2],
                {p.x() * scale, p.y() * scale, -slope / std::sqrt(1 + slope * slope)}};
      }
      const bool top = off_top < off_bottom;
      const float radius = 2 * (top ? size[1] : size[0]);
      return {top ? 1 : 2, 0.5f + p.x() / radius, 0.5f + p.y() / radius, {0, 0, top ? 1.0f : -1.0f}};
    }
    default: {
      const float across = std::hypot(p.x(), p.y());
      const Eigen::Vector3f middle = size[0] / std::max(across, 1e-9f) * Eigen::Vector3f(p.x(), p.y(), 0);
      return {0, Turn(p.y(), p.x()), Turn(p.z(), across - size[0]), ToVec3((p - middle).normalized())};
    }
  }
}

ChartPoint PointOnChart(const Primitive& primitive, int chart, float u, float v) {
  const auto& size = primitive.size;
  const float s = 2 * u - 1, t = 2 * v - 1;
  Eigen::Vector3f local = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
  switch (primitive.shape) {
    case Shape::kBox:
    case Shape::kRoom: {
      const Face face = FaceOf(chart);
      local[face.axis] = face.sign * size[static_cast<std::size_t>(face.axis)];
      local[face.u] = s * size[static_cast<std::size_t>(face.u)];
      local[face.v] = t * size[static_cast<std::size_t>(face.v)];
      normal[face.axis] = primitive.shape == Shape::kBox ? face.sign : -face.sign;
      return {local, normal};
    }
    case Shape::kSphere:
    case Shape::kBust: {
      const Face face = FaceOf(chart);
      Eigen::Vector3f direction;
      direction[face.axis] = face.sign;
      direction[face.u] = s;
      direction[face.v] = t;
      direction.normalize();
      if (primitive.shape == Shape::kSphere) return {size[0] * direction, direction};
      local = BustRadius(size[0], direction) * direction;
      return {local, BustNormal(size[0], local)};
    }
    case Shape::kFrustum: {
      if (chart > 0) {
        const float radius = chart == 1 ? size[1] : size[0];
        return {{s * radius, t * radius, chart == 1 ? size[2] : 0}, {0, 0, chart == 1 ? 1.0f : -1.0f}};
      }
      const float slope = (size[1] - size[0]) / size[2], radius = size[0] + slope * v * size[2];
      const float angle = 2 * kPi * u;
      normal = Eigen::Vector3f(std::cos(angle), std::sin(angle), -slope).normalized();
      return {{radius * std::cos(angle), radius * std::sin(angle), v * size[2]}, normal};
    }
    default: {
      const float around = 2 * kPi * u, tube = 2 * kPi * v;
      const Eigen::Vector3f outward(std::cos(around), std::sin(around), 0);
      normal = std::cos(tube) * outward + std::sin(tube) * Eigen::Vector3f::UnitZ();
      return {size[0] * outward + size[1] * normal, normal};
    }
  }
}

ChartSize SizeOfChart(const Primitive& primitive, int chart) {
  const auto& size = primitive.size;
  switch (primitive.shape) {
    case Shape::kBox:
    case Shape::kRoom: {
      const Face face = FaceOf(chart);
      return {2 * size[static_cast<std::size_t>(face.u)], 2 * size[static_cast<std::size_t>(face.v)], false,
              false};
    }
    case Shape::kSphere:
      return {2 * size[0], 2 * size[0], false, false};  // the face of a cube, in scale at its middle
    case Shape::kBust:
      return {kBustReach * size[0], kBustReach * size[0], false, false};
    case Shape::kFrustum: {
      if (chart == 0) return {2 * kPi * std::max(size[0], size[1]), size[2], true, false};
      const float radius = chart == 1 ? size[1] : size[0];
      return {2 * radius, 2 * radius, false, false};
    }
    default:
      return {2 * kPi * (size[0] + size[1]), 2 * kPi * size[1], true, true};
  }
}

template <typename T>
T Intersect(const Primitive& primitive, const Vec3<T>& o, const Vec3<T>& d) {
  switch (primitive.shape) {
    case Shape::kSphere:
      return IntersectSphere<T>(primitive.size[0], o, d);
    case Shape::kBox:
      return IntersectBox<T>(primitive.size, o, d);
    case Shape::kRoom:
      return IntersectRoom<T>(primitive.size, o, d);
    case Shape::kFrustum:
      return IntersectFrustum<T>(primitive.size, o, d);
    case Shape::kBust:
      return IntersectBust<T>(primitive.size[0], o, d);
    default:
      return IntersectTorus<T>(primitive.size, o, d);
  }
}

template F8 Intersect<F8>(const Primitive&, const Vec3<F8>&, const Vec3<F8>&);
template double Intersect<double>(const Primitive&, const Vec3<double>&, const Vec3<double>&);

}  // namespace ulf::acquisition
