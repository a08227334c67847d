// A camera's flat field: how much light each place of the image gets compared with the middle (vignetting and
// shading).
//
// The flat field is estimated from a few frames of a plain, evenly lit card in linear light. Its logarithm is
// a polynomial of the position (from the image's middle, in half diagonals), one for each of B, G, R. The
// model is chosen by cross-validation over parts of the image: constant, even powers of the radius up to the
// 2nd, 4th or 6th, or all powers of x and y up to the 4th or 6th. A linear gradient is attributed to the
// card's lighting and is never part of the flat field. Dust on the sensor (small dark spots) is excluded from
// the estimate and not corrected; it is counted, so that the sensor can be cleaned.
//
// Recorded photographs are never changed. A light field keeps the flat field of its camera, and
// ReadViewImage() divides by it.
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
  // Where a point of the images in use lies in the images of the estimate: estimated = offset + scale * used,
  // pixels.
  double offset_x = 0, offset_y = 0, scale_x = 1, scale_y = 1;

  // The light relative to the middle, for images of this size: CV_32FC3.
  cv::Mat Light(int used_width, int used_height) const;
  // The image in linear float, divided by the light. `black_level`: as a share of full scale.
  Image Corrected(const Image& image, double black_level = 0) const;

  // The same for images of another part of the sensor, or resized to another size.
  FlatField ForWindow(const SensorWindow& estimated, const SensorWindow& used) const;
  FlatField ForSize(int used_width, int used_height) const;

  bool operator==(const FlatField&) const = default;
};

struct FlatFieldResult {
  std::string refusal = {};  // why these frames give no flat field; empty when they do
  FlatField flat_field = {};
  std::string model = {};              // the model that was chosen, for display
  std::array<double, 3> corner_bgr{};  // light in the darkest corner
  double residual = 0;                 // standard deviation of what the model does not explain, as a share
  double gradient = 0;                 // of the lighting, edge to edge along the diagonal, as a share
  int dust = 0;                        // spots
  int frames = 0;
  bool ok() const { return refusal.empty(); }
};

// `cards`: frames of the card. `black_level`: as a share of full scale.
FlatFieldResult EstimateFlatField(const std::vector<Image>& cards, double black_level = 0);

// In the journal, in calibration files and in recordings. Throws Error that begins with `where`.
nlohmann::json FlatFieldToJson(const FlatField& flat_field);
FlatField FlatFieldFromJson(const nlohmann::json& json, const std::string& where);

}  // namespace ulf
