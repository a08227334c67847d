// A camera's flat field: the light at each place of the image relative to the middle (vignetting, shading).
//
// The flat field is estimated from a few frames of a plain, evenly lit card in linear light. Its logarithm is
// a polynomial of the position (from the image's middle, in half diagonals), one for each of B, G, R. The
// model is chosen by cross-validation over parts of the image: constant, even powers of the radius up to the
// 2nd, 4th or 6th, or all powers of x and y up to the 4th or 6th. A linear gradient is attributed to the
// card's lighting and is never part of the flat field. Dust on the sensor (small dark spots) is excluded from
// the estimate and not corrected; it is counted, so that the sensor can be cleaned.
//
// Recorded photographs are never changed: ReadViewImage() divides by the light field's flat field.
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
  int width = 0, height = 0;  // size of the images that it was estimated on, in px
  std::vector<FlatFieldPower> powers = {};
  // Maps a pixel of the images in use to the images of the estimate: estimated = offset + scale * used.
  double offset_x = 0, offset_y = 0, scale_x = 1, scale_y = 1;

  // Returns the light relative to the middle, for images of this size: CV_32FC3.
  cv::Mat Light(int used_width, int used_height) const;
  // Returns the image in linear float, divided by the light. `black_level` (share of full scale) stays in it.
  Image Corrected(const Image& image, double black_level = 0) const;

  // These return the flat field for images of another part of the sensor, or of another size. `estimated` is
  // the window of the images that it was estimated on.
  FlatField ForWindow(const SensorWindow& estimated, const SensorWindow& used) const;
  FlatField ForSize(int used_width, int used_height) const;

  bool operator==(const FlatField&) const = default;
};

struct FlatFieldResult {
  std::string refusal = {};  // why these frames give no flat field; empty when they do
  FlatField flat_field = {};
  std::string model = {};              // the model that was chosen, for display
  std::array<double, 3> corner_bgr{};  // light in the darkest corner, relative to the middle
  double residual = 0;                 // standard deviation that the model leaves, as a share
  double gradient = 0;                 // change of the lighting from corner to corner, as a share
  int dust = 0;                        // number of spots
  int frames = 0;
  bool ok() const { return refusal.empty(); }
};

// `cards` are frames of the card, of one size. `black_level` is a share of full scale.
FlatFieldResult EstimateFlatField(const std::vector<Image>& cards, double black_level = 0);

// For the journal, calibration files and recordings. Reading throws an Error that begins with `where`.
nlohmann::json FlatFieldToJson(const FlatField& flat_field);
FlatField FlatFieldFromJson(const nlohmann::json& json, const std::string& where);

}  // namespace ulf
