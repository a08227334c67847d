// What a lens, a lamp and a camera's automatics do to the pictures of somebody who has not taken care: the
// simulated camera's mistakes (docs/capture.md#mistakes), each asked for as a fault (simulated_faults.h).
//
// Light is linear radiance, CV_32FC4 as of RayCaster. Lengths are pixels of the camera's own picture, times
// seconds of the hand's clock.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

// A lens that is focused far from the subject: the image of a point is an evenly lit disc, as a round
// aperture makes it. All of the picture alike: right where the depths of the scene differ little against the
// distance to the plane of focus.
void Defocus(cv::Mat& radiance, double radius_px);

// An automatic focus that goes to and fro and finds nothing. The lens breathes: its focal length grows with
// the blur.
struct FocusHunt {
  double radius_px = 0;  // at its farthest
  double period_s = 0;   // there and back
  double BlurPx(double t_s) const;
  // Focal length over that in focus; up to 2 % more at the farthest.
  double FocalRatio(double t_s) const;
};
// The picture through a lens whose focal length is so many times as long.
void Breathe(cv::Mat& radiance, const CameraModel& camera, double focal_ratio);

// Lamps on an alternating current: their light is 1 + depth cos(2 pi hz t).
struct LampFlicker {
  double hz = 0, depth = 0;
  // Mean factor on the light over an exposure.
  double During(double open_s, double exposure_s, std::uint64_t seed) const;
};

// Spots that stay where they are in the picture: factors on the light, CV_32FC1. Between one and two
// hundredths of the picture's width across, edges blurred, 15 to 40 % of the light kept off.
cv::Mat DustSpots(const CameraModel& camera, int spots, std::uint64_t seed);

}  // namespace ulf::acquisition
