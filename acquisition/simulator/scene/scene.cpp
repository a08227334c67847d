#include "acquisition/simulator/scene/scene.h"

#include <fmt/format.h>

#include <map>

#include "acquisition/simulator/scene/built_scenes.h"
#include "core/base/error.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {

using Eigen::Vector3d;

namespace {

struct NamedScene {
  const char* name;
  std::shared_ptr<const Scene> (*build)();
};
constexpr NamedScene kScenes[] = {
    {"studio", BuildStudio}, {"easel", BuildEasel},       {"wall", BuildWall},
    {"gloss", BuildGloss},   {"glass", BuildGlass},       {"plant", BuildPlant},
    {"bust", BuildBust},     {"room", BuildRoom},         {"picture", BuildPicture},
    {"branch", BuildBranch}, {"lightbox", BuildLightbox}, {"turntable", BuildTurntable}};

constexpr double kSwayEasesS = 0.7;  // in which a swing grows, and dies away

}  // namespace

std::vector<std::string> Scene::Names() {
  std::vector<std::string> names;
  for (const NamedScene& scene : kScenes) names.emplace_back(scene.name);
  return names;
}

std::shared_ptr<const Scene> Scene::Named(const std::string& name) {
  static Mutex mutex;
  static std::map<std::string, std::shared_ptr<const Scene>> built ULF_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  if (const auto found = built.find(name); found != built.end()) return found->second;
  for (const NamedScene& scene : kScenes)
    if (name == scene.name) return built[name] = scene.build();
  throw Refusal("", name, fmt::format("there is no scene '{}' to simulate", name),
                fmt::format("there are: {}", fmt::join(Names(), ", ")));
}

double Scene::SwayAngle(double since_s, double lasts_s) const {
  if (!sway_ || sway_->goes_round || since_s <= 0 || since_s >= lasts_s) return 0;
  const double ease = std::min({since_s / kSwayEasesS, (lasts_s - since_s) / kSwayEasesS, 1.0});
  const double share = ease * ease * (3 - 2 * ease);
  return sway_->amplitude * share * std::sin(2 * M_PI * since_s / sway_->period_s);
}

Rigid3 Scene::MovedFromRest(double sway_angle) const {
  if (!sway_ || sway_angle == 0) return {};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(sway_angle, sway_->axis));
  return {turn, sway_->pivot - turn * sway_->pivot};
}

Hit Scene::FirstHit(const Vector3d& origin_in_world, const Vector3d& direction_in_world, double sway_angle,
                    bool through_glass) const {
  const Rigid3 rest_from_moved = MovedFromRest(sway_angle).Inverse();
  const Vector3d moved_origin = rest_from_moved * origin_in_world;
  const Vector3d moved_direction = rest_from_moved.rotation * direction_in_world;
  Hit first;
  for (std::size_t i = 0; i < primitives_.size(); ++i) {
    const Primitive& primitive = primitives_[i];
    if (through_glass && primitive.finish == Finish::kGlass) continue;
    const Vector3d& origin = primitive.moves ? moved_origin : origin_in_world;
    const Vector3d& direction = primitive.moves ? moved_direction : direction_in_world;
    const Vector3d to_center = bounds_[i].center_in_world - origin;
    const double along = to_center.dot(direction), radius = bounds_[i].radius;
    if (along < -radius || to_center.squaredNorm() - along * along > radius * radius) continue;
    const Vector3d o = primitive.local_from_world * origin;
    const Vector3d d = primitive.local_from_world.rotation * direction;
    const double distance = Intersect<double>(primitive, {o.x(), o.y(), o.z()}, {d.x(), d.y(), d.z()});
    if (distance < first.distance) first = {distance, static_cast<int>(i)};
  }
  return first;
}

}  // namespace ulf::acquisition
