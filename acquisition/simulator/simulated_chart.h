// Simulates colour calibration with known ground truth: `sim:chart` and `sim:grey`.
//
//   sim:chart  a chart of 24 patches with the published colours (core/fiducials/color_chart_patches.h) on
//              black, before a plain wall, held in a hand that is not quite still
//   sim:grey   a grey card that fills the picture
//
// The image is sampled by area, then converted by the sensor's colours and the sensor itself (sensor.h).
// Everything is a pure function of the options and the frame number.
#pragma once

#include <memory>

#include "acquisition/device/device.h"
#include "acquisition/simulator/sensor.h"

namespace ulf::acquisition {

struct ChartSceneOptions {
  bool card = false;  // a grey card in place of the chart
  int width = 640, height = 480;
  std::uint64_t seed = 7;
  SensorFormat format = SensorFormat::kRgb8;
  SensorColors colors = {};
  double white = 0.75;   // brightest channel of the white patch, or card, of full scale; above 1 it clips
  double gradient = 0;   // of the light: right edge minus left, as a share of the middle's
  double turn_deg = 5;   // of the chart in the picture, clockwise
  double tilt_deg = 10;  // about its upright axis, the left edge away from the camera
  bool noise = true;
};

Image RenderChart(const ChartSceneOptions& options, std::uint64_t frame);

// Opens `sim:chart?width=640&height=480&seed=7&format=rgb8&lamp_k=6504&crosstalk=0&white=0.75&gradient=0
// &turn_deg=5&tilt_deg=10&noise=1&frames=100`, or `sim:grey` with the same ones (white=0.5). Throws Refusal.
std::unique_ptr<Device> OpenSimulatedChart(const DeviceUri& uri);

}  // namespace ulf::acquisition
