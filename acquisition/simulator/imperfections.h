// Simulates mistakes of lens, lamps and automatics (docs/capture.md#mistakes), each requested as a fault
// (simulated_faults.h).
//
// Pictures hold linear radiance, CV_32FC4 as RayCaster makes it. Lengths are pixels of the camera's own
// picture, times seconds of the hand's clock.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

// Blurs as a lens focused far from the subject: the image of a point is an evenly lit disc, as of a round
// aperture. All of the picture is blurred alike, which is right where the scene's depths differ little
// compared with the distance to the plane of focus.
void Defocus(cv::Mat& radiance, double radius_px);

// A hunting autofocus. The lens breathes: its focal length grows with the blur.
struct FocusHunt {
  double radius_px = 0;  // radius of a point's image at the worst focus
  double period_s = 0;   // from best to worst focus and back
  double BlurPx(double t_s) const;
  // Returns the focal length over the one in focus, 1 to 1.02.
  double FocalRatio(double t_s) const;
};
// Resamples the picture as for a lens whose focal length is `focal_ratio` times as long.
void Breathe(cv::Mat& radiance, const CameraModel& camera, double focal_ratio);

// Lamps on an alternating current: a factor of 1 + depth cos(2 pi hz t + phase) on the light.
struct LampFlicker {
  double hz = 0, depth = 0;
  // Returns the mean factor over an exposure. The seed decides the phase.
  double During(double open_s, double exposure_s, std::uint64_t seed) const;
};

// Returns the factors on the light, CV_32FC1, of fixed spots: one to two hundredths of the picture's width
// across, with blurred edges, each blocking 15 to 40 % of the light.
cv::Mat DustSpots(const CameraModel& camera, int spots, std::uint64_t seed);

}  // namespace ulf::acquisition
