#include "coverage/session/turn_back.h"

#include <fmt/format.h>

#include <cmath>

#include "core/geometry/angles.h"
#include "tracking/tracker/track.h"

namespace ulf::coverage {

using Eigen::Vector2d;
using Eigen::Vector3d;

double CameraTurn::Angle() const { return AngleBetween(ReferenceAxis(), Vector3d::UnitZ()); }

std::string TurnBackInWords(const CameraTurn& turned) {
  if (Degrees(turned.Angle()) < kReachedDeg) return {};
  const Vector3d there = turned.ReferenceAxis();
  const double right_deg = Degrees(std::atan2(there.x(), there.z()));
  const double down_deg = Degrees(std::atan2(there.y(), std::hypot(there.x(), there.z())));
  std::string words;
  const auto add = [&](double degrees, const char* forward, const char* backward) {
    if (std::abs(degrees) < 0.5 * kReachedDeg) return;
    words += fmt::format("{} {:.0f}° {}", words.empty() ? "turn" : ",", std::abs(degrees),
                         degrees > 0 ? forward : backward);
  };
  add(right_deg, "right", "left");
  add(down_deg, "down", "up");
  return words;
}

bool IsPureRotation(tracking::TrackState state, const std::optional<tracking::StartProgress>& start,
                    const std::optional<CameraTurn>& turned) {
  // A turned camera soon has too few matches with the picture that it began with.
  return state == tracking::TrackState::kInitializing && turned && start &&
         (start->obstacle == tracking::StartObstacle::kRotationOnly ||
          start->obstacle == tracking::StartObstacle::kTooFewMatches);
}

std::string InWords(const tracking::Track& track, const std::optional<CameraTurn>& turned,
                    FrameSource source) {
  if (IsPureRotation(track.state, track.start, turned))
    return tracking::Advice(tracking::StartObstacle::kRotationOnly, source);
  if (IsTaken(source) || track.state != tracking::TrackState::kLost || !turned || !turned->reference_has_pose)
    return tracking::InWords(track, source);
  const std::string way = TurnBackInWords(*turned);
  return fmt::format("position lost, only turns are followed: {}, or {}",
                     way.empty() ? "this is where it looked last, go back to where it was"
                                 : way + " to where it looked last",
                     track.start ? "begin anew here: " + tracking::InWords(*track.start, source)
                                 : "show another part that was seen before");
}

std::vector<std::vector<Vector2d>> FormerFrameOutline(const CameraTurn& turned, const CameraModel& camera) {
  constexpr int kSteps = 12;  // along each side: a distorted border is bent
  // Beyond, a lens model says nothing: its picture is not much wider than the image.
  const auto corner = camera.RayFromImg({0, 0});
  const double widest = corner ? 1.5 * AngleBetween(*corner, Vector3d::UnitZ()) : 0;
  const double width = camera.width, height = camera.height;
  const Vector2d corners[]{{0, 0}, {width, 0}, {width, height}, {0, height}, {0, 0}};
  std::vector<std::vector<Vector2d>> lines(1);
  for (int side = 0; side < 4; ++side)
    for (int step = side == 0 ? 0 : 1; step <= kSteps; ++step) {
      const double share = static_cast<double>(step) / kSteps;
      const auto then = camera.RayFromImg((1 - share) * corners[side] + share * corners[side + 1]);
      const Vector3d now = then ? Vector3d(turned.now_from_reference * *then) : Vector3d(-Vector3d::UnitZ());
      const auto img = AngleBetween(now, Vector3d::UnitZ()) < widest ? camera.ImgFromCam(now) : std::nullopt;
      if (img)
        lines.back().push_back(*img);
      else if (!lines.back().empty())
        lines.emplace_back();
    }
  std::erase_if(lines, [](const auto& line) { return line.size() < 2; });
  return lines;
}

}  // namespace ulf::coverage
