#include "coverage/session/capture_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "core/geometry/angles.h"

namespace ulf::coverage {
namespace {

std::string Part(double degrees, const char* forward, const char* backward) {
  if (std::abs(degrees) < 1) return {};
  return fmt::format("{:.0f}° {}", std::abs(degrees), degrees > 0 ? forward : backward);
}

// Returns how far `there` is from `here` about the axis and along it, degrees: counterclockwise as seen from
// above, and up.
Eigen::Vector2d AboutAxis(const Eigen::Vector3d& up, const Eigen::Vector3d& here,
                          const Eigen::Vector3d& there) {
  const Eigen::Vector3d a = here - up * up.dot(here), b = there - up * up.dot(there);
  return {Degrees(std::atan2(up.dot(a.cross(b)), a.dot(b))),
          Degrees(std::asin(std::clamp(up.dot(there), -1.0, 1.0)) -
                  std::asin(std::clamp(up.dot(here), -1.0, 1.0)))};
}

std::string Joined(std::initializer_list<std::string> parts) {
  std::string words;
  for (const std::string& part : parts)
    if (!part.empty()) words += (words.empty() ? "" : ", ") + part;
  return words;
}

}  // namespace

const char* Name(StoppedBecause why) {
  constexpr std::array kNames{"covered", "frames",      "seconds", "ended",
                              "signal",  "device_lost", "disk",    "closed"};
  return kNames[static_cast<std::size_t>(why)];
}

LengthToGo LengthToGo::Of(const CaptureState& state, double from_distance, double to_distance) {
  const double length = std::abs(to_distance - from_distance);
  if (!state.metric) return {100 * length / from_distance, Unit::kPercent};
  if (length < 0.01) return {1000 * length, Unit::kMillimetres};
  return length < 1 ? LengthToGo{100 * length, Unit::kCentimetres} : LengthToGo{length, Unit::kMetres};
}

std::string LengthToGo::Text() const {
  constexpr std::array kUnits{"%", "mm", "cm", "m"};
  return fmt::format("{:.{}f} {}", amount, unit == Unit::kMetres ? 1 : 0,
                     kUnits[static_cast<std::size_t>(unit)]);
}

double LengthToGo::ShareOf(double distance_m) const {
  switch (unit) {
    case Unit::kPercent:
      return 0.01 * std::nearbyint(amount);
    case Unit::kMillimetres:
      return 0.001 * std::nearbyint(amount) / distance_m;
    case Unit::kCentimetres:
      return 0.01 * std::nearbyint(amount) / distance_m;
    case Unit::kMetres:
      break;
  }
  return std::nearbyint(10 * amount) / 10 / distance_m;
}

std::string WayInWords(const CaptureState& state) {
  if (IsTaken(state.source) || !state.cam_from_world || !state.subject || !state.guidance.toward) return {};
  const Eigen::Vector3d offset = state.cam_from_world->OriginInSource() - state.subject->center_in_world;
  const double distance = offset.norm();
  if (!(distance > 0)) return {};
  const Eigen::Vector3d here = offset / distance, there = *state.guidance.toward;
  const double wanted = state.guidance.distance;
  constexpr double kWorthSaying = 0.01;  // of the distance
  std::string farther;
  if (wanted > 0 && std::abs(wanted / distance - 1) >= kWorthSaying)
    farther = LengthToGo::Of(state, distance, wanted).Text() + (wanted > distance ? " back" : " nearer");
  if (state.table_up_in_world) {
    const Eigen::Vector2d to_go = AboutAxis(*state.table_up_in_world, here, there);
    const std::string turn = Part(to_go.x(), "clockwise", "counterclockwise"),
                      rise = Part(to_go.y(), "up", "down");
    return Joined({turn.empty() ? "" : "turn the table " + turn, rise.empty() ? "" : "the camera " + rise,
                   farther.empty() ? "" : "the camera " + farther});
  }
  const Eigen::Vector3d along = there - here * here.dot(there);
  if (!(along.norm() > 0)) return {};
  const double degrees = Degrees(std::atan2(along.norm(), here.dot(there)));
  const Eigen::Vector3d in_cam = degrees * (state.cam_from_world->rotation * along.normalized());
  return Joined({Part(in_cam.x(), "right", "left"), Part(in_cam.y(), "down", "up"), farther});
}

std::string MeshInWords(const CaptureState& state) {
  if (state.mesh) return "over the mesh so far";
  return state.mesh_may_come ? "over a plane: no mesh yet" : "over a plane: no mesh is made";
}

std::string ErrorsInWords(const CaptureState& state) {
  if (state.errors) return "measured at frames";
  if (!state.errors_may_come) return "errors: not measured";
  return state.mesh ? "errors: none measured yet" : "errors: no mesh yet";
}

}  // namespace ulf::coverage
