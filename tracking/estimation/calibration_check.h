// Whether the pictures contradict the focal length they were given.
//
// A wrong focal length bends the whole world and leaves residuals that look like noise. Freed in an
// adjustment it goes where the pictures want it; that is said when it is clearly elsewhere: by more than 1.5
// % and by many standard deviations, with distortion held and with distortion free alike. Flat scenes and
// sideways motion leave it undetermined, the standard deviation says so, and nothing is said.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

struct CalibrationCheck {
  double given_focal_px = 0;
  double fitted_focal_px = 0;
  double sigma_px = 0;      // one standard deviation of the fitted one
  bool determined = false;  // the geometry tells
  bool wrong = false;
  // A rolling shutter was found and left as it is: rows seen one after the other stretch pictures as another
  // focal length does, and the other way round.
  bool rows_uncompensated = false;

  // The same of a camera whose pictures are those that were given, resized.
  CalibrationCheck Of(const CameraModel& resized) const;
  // "images fit a focal length of 551.2 px (± 1.3), 5.0 % more than the 525.0 given"; empty unless wrong.
  std::string Text() const;
  // The same with what to do about it.
  std::string Advice() const;
};

// None where there is too little to go by (fewer than five cameras or 200 points).
std::optional<CalibrationCheck> CheckCalibration(const CameraModel& given, const BundleProblem& problem,
                                                 int lens = 0);

// {given_focal_px, fitted_focal_px, sigma_px, determined, wrong}; null where there is none.
nlohmann::ordered_json ToJson(const std::optional<CalibrationCheck>& check);

class Map;
// Of the map's living keyframes and points.
std::optional<CalibrationCheck> CheckCalibration(const CameraModel& given, const Map& map);

}  // namespace ulf::tracking
