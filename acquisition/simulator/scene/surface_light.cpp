#include "acquisition/simulator/scene/surface_light.h"

#include <optional>

namespace ulf::acquisition {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kGlassIndex = 1.5;
constexpr double kGlassReflectance = 0.04;          // of that index, at right angles
constexpr double kAbsorption[3] = {1.6, 0.7, 1.9};  // B, G, R per metre: faintly green; guessed
constexpr int kMostInnerReflections = 4;
constexpr double kOffSurface = 1e-6;  // metres; where a ray that leaves a surface begins
constexpr double kGlassSpread = 4;    // of a pixel's angle behind glass; guessed

float Schlick(float at_right_angles, float facing) {
  const float grazing = 1 - facing, grazing2 = grazing * grazing;
  return at_right_angles + (1 - at_right_angles) * grazing2 * grazing2 * grazing;
}

struct LampSeen {
  float distance, radiance;
};

// Returns where a ray meets a lamp's front. Its radiance is the irradiance at one metre over the lamp's area,
// and fades towards the rim.
std::optional<LampSeen> SeeLamp(const AreaLight& lamp, const Vector3f& point, const Vector3f& direction) {
  const float towards = -direction.dot(lamp.normal);
  if (towards <= 0.01f) return std::nullopt;
  const float distance = (point - lamp.center).dot(lamp.normal) / towards;
  if (distance <= 0) return std::nullopt;
  const Vector3f at = point + distance * direction - lamp.center;
  const float u = std::abs(at.dot(lamp.half_u)) / lamp.half_u.squaredNorm();
  const float v = std::abs(at.dot(lamp.half_v)) / lamp.half_v.squaredNorm();
  const float area = 4 * lamp.half_u.norm() * lamp.half_v.norm();
  const float rim = std::clamp((1.05f - std::max(u, v)) / 0.1f, 0.0f, 1.0f);
  if (rim == 0) return std::nullopt;
  return LampSeen{distance, rim * (1 - 0.3f * std::max(u, v)) * lamp.power / area};
}

// Returns the lamps and a plain room, reflected at a mirror.
F4 GlazeLight(const Scene& scene, const SurfaceView& view, float at_right_angles) {
  const float facing = std::max(0.0f, -view.normal.dot(view.direction));
  const float fresnel = Schlick(at_right_angles, facing);
  const Vector3f mirrored = view.direction + 2 * facing * view.normal;
  // The room: bright above, the table below.
  const float up = std::clamp(0.5f + 2 * mirrored.z(), 0.0f, 1.0f);
  float light = 0.09f + up * (0.1f + 0.24f * std::max(0.0f, mirrored.z()));
  for (const AreaLight& lamp : scene.lights())
    if (const auto seen = SeeLamp(lamp, view.point, mirrored)) light += seen->radiance;
  const float radiance = fresnel * light;
  return F4{radiance, radiance, radiance, 0};
}

// A ray that was mirrored or refracted. A pixel of it is `width` wide where it begins and widens by `spread`.
struct SecondRay {
  Vector3d from, direction;
  double width = 0, spread = 0;
  double sway_angle = 0;
};

F4 SeenAlong(const Scene& scene, const SecondRay& ray) {
  const Hit hit = scene.FirstHit(ray.from + kOffSurface * ray.direction, ray.direction, ray.sway_angle, true);
  if (hit.part < 0) return F4{};
  const Vector3f from = ray.from.cast<float>(), along = ray.direction.cast<float>();
  for (const AreaLight& lamp : scene.lights())
    if (const auto seen = SeeLamp(lamp, from, along); seen && seen->distance < hit.distance)
      return F4{seen->radiance, seen->radiance, seen->radiance, 0};
  const Primitive& primitive = scene.primitives()[static_cast<std::size_t>(hit.part)];
  const Rigid3 local_from_world =
      primitive.moves ? primitive.local_from_world * scene.MovedFromRest(ray.sway_angle).Inverse()
                      : primitive.local_from_world;
  const Vector3f local = (local_from_world * (ray.from + hit.distance * ray.direction)).cast<float>();
  const SurfacePoint at = SurfaceAt(primitive, {local.x(), local.y(), local.z()});
  const Vector3f normal(at.normal.x, at.normal.y, at.normal.z);
  const double facing =
      std::max(0.04, std::abs(normal.cast<double>().dot(local_from_world.rotation * ray.direction)));
  const MipTexture& texture = scene.Chart(primitive.first_chart + at.chart);
  const double texels_per_m = texture.height() / SizeOfChart(primitive, at.chart).height_m;
  const double footprint = (ray.width + hit.distance * ray.spread) * texels_per_m / std::sqrt(facing);
  return primitive.glow * texture.Sample(at.u, at.v, static_cast<float>(footprint));
}

// Returns a radius of curvature that stands for the whole solid.
double RadiusOf(const Primitive& primitive) {
  return primitive.shape == Shape::kFrustum ? 0.5 * (primitive.size[0] + primitive.size[1])
                                            : primitive.BoundRadius();
}

F4 MirroredLight(const Scene& scene, const Primitive& primitive, const SurfaceView& view) {
  const float facing = std::max(0.04f, -view.normal.dot(view.direction));
  const double width = view.distance * view.pixel_angle / std::sqrt(facing);
  return SeenAlong(scene, {view.point.cast<double>(),
                           (view.direction + 2 * facing * view.normal).cast<double>().normalized(), width,
                           view.pixel_angle + 2 * width / RadiusOf(primitive), view.sway_angle});
}

// Returns the direction behind a surface whose normal is on the ray's side; none: total reflection.
std::optional<Vector3d> Refracted(const Vector3d& direction, const Vector3d& normal, double index_ratio) {
  const double cosine = -normal.dot(direction);
  const double sine2 = index_ratio * index_ratio * (1 - cosine * cosine);
  if (sine2 >= 1) return std::nullopt;
  return (index_ratio * direction + (index_ratio * cosine - std::sqrt(1 - sine2)) * normal).normalized();
}

// Traces a ray through the solid and out of it.
F4 RefractedLight(const Scene& scene, const Primitive& primitive, const SurfaceView& view) {
  const Rigid3& local_from_world = primitive.local_from_world;
  Vector3d point = local_from_world * view.point.cast<double>();
  const auto entered = Refracted(local_from_world.rotation * view.direction.cast<double>(),
                                 local_from_world.rotation * view.normal.cast<double>(), 1 / kGlassIndex);
  if (!entered) return F4{};
  Vector3d direction = *entered;
  double inside_m = 0, passed = 1;
  for (int i = 0; i < kMostInnerReflections; ++i) {
    const Vector3d from = point + kOffSurface * direction;
    const double distance = Intersect<double>(primitive, {from.x(), from.y(), from.z()},
                                              {direction.x(), direction.y(), direction.z()});
    if (!std::isfinite(distance)) break;
    inside_m += distance;
    point = from + distance * direction;
    const SurfacePoint at = SurfaceAt(
        primitive,
        {static_cast<float>(point.x()), static_cast<float>(point.y()), static_cast<float>(point.z())});
    const Vector3d inward = -Vector3d(at.normal.x, at.normal.y, at.normal.z);
    const auto left = Refracted(direction, inward, kGlassIndex);
    if (!left) {
      direction = (direction - 2 * direction.dot(inward) * inward).normalized();
      continue;
    }
    passed *= 1 - Schlick(kGlassReflectance, static_cast<float>(std::max(0.0, -left->dot(inward))));
    const Rigid3 world_from_local = local_from_world.Inverse();
    const double width = view.distance * view.pixel_angle;
    const F4 seen =
        SeenAlong(scene, {world_from_local * point, world_from_local.rotation * *left, width,
                          kGlassSpread * (view.pixel_angle + width / RadiusOf(primitive)), view.sway_angle});
    F4 tint{};
    for (int c = 0; c < 3; ++c) tint[c] = static_cast<float>(passed * std::exp(-kAbsorption[c] * inside_m));
    return tint * seen;
  }
  return F4{};
}

}  // namespace

F4 SurfaceLight(const Scene& scene, int part, F4 matte, const SurfaceView& view) {
  const Primitive& primitive = scene.primitives()[static_cast<std::size_t>(part)];
  const float facing = std::clamp(-view.normal.dot(view.direction), 0.0f, 1.0f);
  switch (primitive.finish) {
    case Finish::kMatte:
      return matte;
    case Finish::kGlazed:
      return matte + GlazeLight(scene, view, primitive.mirrored);
    case Finish::kPolished: {
      const float share = Schlick(primitive.mirrored, facing);
      return (1 - share) * matte + share * MirroredLight(scene, primitive, view);
    }
    case Finish::kGlass: {
      const float share = Schlick(primitive.mirrored, facing);
      return (1 - share) * RefractedLight(scene, primitive, view) +
             share * MirroredLight(scene, primitive, view);
    }
  }
  return matte;
}

}  // namespace ulf::acquisition
