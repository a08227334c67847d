#include "coverage/session/record/exposure_watch.h"

#include <algorithm>
#include <cmath>

#include "coverage/bound/sphere_outline.h"
#include "coverage/bound/subject_light.h"

namespace ulf::coverage {
namespace {

constexpr double kWindow_s = 0.3;
constexpr double kSameSetting = 0.03;            // of a settled camera: rounding, no more
constexpr double kSameLight = 0.08;              // a third of what one step of an exposure dial changes
constexpr double kSameDirectionCosine = 0.9994;  // of two degrees

bool Differ(double a, double b, double share) { return a > 0 && b > 0 && std::abs(std::log(a / b)) > share; }

}  // namespace

bool ExposureWatch::Settled(const Frame& frame, const CameraModel& camera, const Rigid3& cam_from_world,
                            const Subject& subject, std::optional<bool> held) {
  const bool told = frame.exposure_s > 0;
  if (!held || !(*held || told)) return true;
  Seen now{.time_s = frame.device_time_s, .setting = frame.exposure_s * frame.gain};
  now.direction = (cam_from_world.OriginInSource() - subject.center_in_world).normalized();
  const auto outline = SphereOutline(camera, cam_from_world, subject);
  if (outline &&
      std::all_of(outline->begin(), outline->end(), [&](const auto& img) { return camera.Contains(img); }))
    if (const auto light = LightInside(frame.image, *outline)) now.light = light->mean_linear;
  std::erase_if(recent_, [&](const Seen& seen) {
    return seen.time_s > now.time_s || now.time_s - seen.time_s > kWindow_s;
  });
  const bool settled = std::none_of(recent_.begin(), recent_.end(), [&](const Seen& seen) {
    return Differ(seen.setting, now.setting, kSameSetting) ||
           (seen.direction.dot(now.direction) > kSameDirectionCosine &&
            Differ(seen.light, now.light, kSameLight));
  });
  recent_.push_back(now);
  return settled;
}

}  // namespace ulf::coverage
