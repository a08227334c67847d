#include "coverage/session/capture_state.h"

#include <fmt/format.h>

#include <cmath>

#include "core/geometry/angles.h"

namespace ulf::coverage {
namespace {

std::string Part(double amount, const char* unit, const char* forward, const char* backward) {
  if (std::abs(amount) < 1) return {};
  return fmt::format("{:.0f}{} {}", std::abs(amount), unit, amount > 0 ? forward : backward);
}

}  // namespace

const char* Name(StoppedBecause why) {
  constexpr std::array kNames{"covered", "frames",      "seconds", "ended",
                              "signal",  "device_lost", "disk",    "closed"};
  return kNames[static_cast<std::size_t>(why)];
}

std::string WayInWords(const CaptureState& state) {
  if (!state.cam_from_world || !state.subject || !state.guidance.toward) return {};
  const Eigen::Vector3d offset = state.cam_from_world->OriginInSource() - state.subject->center_in_world;
  const double distance = offset.norm();
  if (!(distance > 0)) return {};
  const Eigen::Vector3d here = offset / distance, there = *state.guidance.toward;
  const Eigen::Vector3d along = there - here * here.dot(there);
  if (!(along.norm() > 0)) return {};
  const double degrees = Degrees(std::atan2(along.norm(), here.dot(there)));
  const Eigen::Vector3d in_cam = degrees * (state.cam_from_world->rotation * along.normalized());
  const double wanted = state.guidance.distance;
  const double farther = wanted > 0 ? 100 * (wanted / distance - 1) : 0;
  std::string words;
  for (const std::string& part : {Part(in_cam.x(), "°", "right", "left"), Part(in_cam.y(), "°", "down", "up"),
                                  Part(farther, " %", "back", "nearer")})
    if (!part.empty()) words += (words.empty() ? "" : ", ") + part;
  return words;
}

}  // namespace ulf::coverage
