// A lens of 640x480 pixels, as numbers for the texts of lens files, and what reading such a text must give.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "acquisition/calibration/lens_files/lens_files.h"
#include "core/base/error.h"
#include "tests/support/floors.h"

namespace ulf::lens_texts {

// Of 640x480 pixels. By hand: 320.5 and 239.25 between integer centres are 321 and 239.75 from the corner.
inline CameraModel Radial(double k3 = 0) {
  return {
      640, 480, 600.5, 601.25, 321, 239.75, Distortion::kRadialTangential, {-0.1, 0.05, 0.001, -0.002, k3}};
}
inline CameraModel Fisheye() {
  return {640, 480, 600.5, 601.25, 321, 239.75, Distortion::kFisheye, {-0.01, 0.002, -0.003, 0.0004, 0}};
}

inline constexpr const char* kK = "[600.5, 0, 320.5, 0, 601.25, 239.25, 0, 0, 1]";
inline constexpr const char* kRadialD = "[-0.1, 0.05, 0.001, -0.002]";
inline constexpr const char* kFisheyeD = "[-0.01, 0.002, -0.003, 0.0004]";

inline ReadLens Read(const std::string& text, const std::string& camera = "") {
  const auto read = ReadLensText(text, "the file", camera);
  if (!read) throw Error("not recognised: {}", text);
  return *read;
}
inline std::string ErrorOf(const std::string& text, const std::string& camera = "") {
  try {
    Read(text, camera);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

inline void ExpectLens(const ReadLens& read, const CameraModel& wanted) {
  const CameraModel& camera = read.lens.camera;
  EXPECT_EQ(camera.width, wanted.width);
  EXPECT_EQ(camera.height, wanted.height);
  EXPECT_EQ(camera.fx, wanted.fx);
  EXPECT_NEAR(camera.fy, wanted.fy, 1e-9);
  EXPECT_EQ(camera.cx, wanted.cx);
  EXPECT_EQ(camera.cy, wanted.cy);
  EXPECT_EQ(camera.distortion, wanted.distortion);
  EXPECT_EQ(camera.coefficients, wanted.coefficients);
}

}  // namespace ulf::lens_texts
