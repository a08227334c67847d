// A light field that a rolling shutter took of the textured room, with exact points, the pictures' poses and
// the cameras' velocities, beside the middle rows' poses and the pictures of a global shutter.
#pragma once

#include <filesystem>
#include <vector>

#include "core/light_field/light_field.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/estimation/rolling_shutter.h"

namespace ulf::test {

struct RollingLightField {
  LightField light_field;  // its pictures only with `folder`
  std::vector<Rigid3> middle_rows;
  std::vector<tracking::Twist> twists;
};
inline constexpr double kWallDistance = 3;  // of the room's wall from the origin, along z

// The camera turns at `turn_rad_s` and moves at `shift_m_s`, in another direction for each view. `folder`:
// where the light field is written, with pictures of the wall; empty: nowhere.
RollingLightField MakeRollingLightField(const CameraModel& camera, double readout_s, double turn_rad_s,
                                        double shift_m_s, const std::filesystem::path& folder = {});

// The room's wall alone, without noise.
TexturedRoom PlainWall();
// The wall's depth along the axis at each pixel, CV_32F.
cv::Mat DepthOfWall(const CameraModel& camera, const Rigid3& cam_from_world);

}  // namespace ulf::test
