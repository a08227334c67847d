// How much light a camera passes at each place of its image, compared with the middle: vignetting and
// shading.
//
// Found from a few frames of an evenly lit plain card in linear light. Its logarithm is a polynomial of the
// place (from the image's middle, in units of half the diagonal), one for each of B, G, R; how rich it is, is
// chosen by what left-out parts of the image say: nothing, even powers of the radius up to the 2nd, 4th or
// 6th, or all powers of x and y up to the 4th or 6th. A linear gradient over the image is taken for the
// card's lighting and is never part of it. Dust on the sensor, darker than its surroundings and small, is
// left out of the estimate and not corrected; it is counted so that it can be cleaned.
//
// Recorded photographs are never altered. A light field keeps the flat field of its camera, and what reads
// its views (ReadViewImage) gets them divided by it.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/geometry/sensor_window.h"
#include "core/image/image.h"

namespace ulf {

struct FlatFieldPower {
  int x = 0, y = 0;
  std::array<double, 3> bgr{};  // coefficient of x^i y^j in the logarithm
  bool operator==(const FlatFieldPower&) const = default;
};

struct FlatField {
  int width = 0, height = 0;  // of the images that it was estimated on
  std::vector<FlatFieldPower> powers = {};
  // Where an image point of the images in use lies in those: estimated = offset + scale * used.
  double offset_x = 0, offset_y = 0, scale_x = 1, scale_y = 1;

  // Light relative to the middle of the images that it was estimated on: CV_32FC3.
  cv::Mat Light(int used_width, int used_height) const;
  // Linear float, divided by the light.
  Image Corrected(const Image& image, double black_level = 0) const;

  FlatField ForWindow(const SensorWindow& estimated, const SensorWindow& used) const;
  FlatField ForSize(int used_width, int used_height) const;  // the same picture resized

  bool operator==(const FlatField&) const = default;
};

struct FlatFieldResult {
  std::string refusal = {};  // why these frames give none; empty when they do
  FlatField flat_field = {};
  std::string model = {};              // what was chosen, for people
  std::array<double, 3> corner_bgr{};  // light in the darkest corner
  double residual = 0;                 // standard deviation of what the model leaves, as a share
  double gradient = 0;                 // of the lighting, edge to edge along the diagonal, as a share
  int dust = 0;                        // spots
  int frames = 0;
  bool ok() const { return refusal.empty(); }
};

FlatFieldResult EstimateFlatField(const std::vector<Image>& cards, double black_level = 0);

nlohmann::json FlatFieldToJson(const FlatField& flat_field);
FlatField FlatFieldFromJson(const nlohmann::json& json, const std::string& where);

}  // namespace ulf
