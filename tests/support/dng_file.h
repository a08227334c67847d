// Makes a camera's raw file with known light in it: a DNG (Adobe's specification 1.4) of an uncompressed
// mosaic, as the sensor of the camera described would have seen it.
#pragma once

#include <array>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "tests/support/floors.h"

namespace ulf::test {

struct DngCamera {
  // Of the visible area's first pixels: 2x2, 4x4 (quad Bayer), 6x6 (X-Trans), 8x8. Empty: every pixel has all
  // colours (linear DNG).
  std::string pattern = "RGGB";
  int bits = 14;  // 12 and 14 are packed
  int black = 512, white = 15871;
  std::optional<std::array<int, 3>> blacks = {};  // of a linear DNG: one for each colour, in place of `black`
  int mosaic_layout = 1;                          // 1: rectangular; 2 to 5: staggered
  int tile = 0;                                   // the side of square tiles; 0: one strip
  cv::Size sensor{120, 88};                       // all that the file holds
  cv::Rect visible{8, 4, 104, 80};                // of the sensor
  std::optional<cv::Rect> crop{{4, 8, 96, 64}};   // of the visible area, as the camera crops; none: not said
  std::array<double, 3> neutral{0.48, 1, 0.66};  // what its pixels make of white, green is 1; all 0: not said
  // XYZ (D65) to the sensor's colours, by rows; all 0: not said. A Nikon D700's, rounded.
  std::array<double, 9> matrix{0.8139, -0.2171, -0.0663, -0.8747, 1.6541, 0.2295, -0.1925, 0.2008, 0.8093};
  double exposure_s = 1 / 60.0, f_number = 5.6, focal_mm = 35;
  int iso = 400, focal_35mm = 52, orientation = 1;
  std::string model = "Acme Studio 1", lens = "Acme 35mm f/2";
  // What the file says of white where it is not `neutral`: a white balance that the camera found for itself.
  std::optional<std::array<double, 3>> told_neutral = {};
};

// Returns linear light, R, G, B, full scale 1, at a pixel of the visible area.
using DngLight = std::function<cv::Vec3d(int x, int y)>;

std::string DngBytes(const DngCamera& camera, const DngLight& light);

// Returns the light that a picture of this size and place in the visible area shows: CV_32FC3, B, G, R.
cv::Mat LightOf(const DngLight& light, const cv::Rect& crop);

}  // namespace ulf::test
