#include "acquisition/simulator/simulated_chart.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>

#include "acquisition/simulator/bench_device.h"
#include "acquisition/simulator/scene/noise.h"
#include "core/fiducials/color_chart_patches.h"
#include "core/geometry/angles.h"
#include "core/image/color_difference.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBlackRim = 1.5;  // units of the chart around its outline

double UnitShare(std::uint64_t seed, std::uint64_t frame, int which) {
  return UnitFloat(
      HashLattice(static_cast<std::int32_t>(frame), which, 29, static_cast<std::uint32_t>(seed)));
}

// Returns linear sRGB at a place on the chart; the white patch has about 0.9.
Vector3d ChartLight(const Vector2d& at) {
  static const std::array<Vector3d, kChartPatches> patches = [] {
    std::array<Vector3d, kChartPatches> light;
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = LinearSrgbFromLab(ChartLab()[i]);
    return light;
  }();
  constexpr double kFrame = 0.02, kWall = 0.3;  // reflectances
  const bool on_card = at.x() > -kBlackRim && at.y() > -kBlackRim && at.x() < kChartWidth + kBlackRim &&
                       at.y() < kChartHeight + kBlackRim;
  if (!on_card) return Vector3d::Constant(kWall);
  const double pitch = kPatchWidth + kPatchGap;
  const int column = static_cast<int>(std::floor((at.x() - 0.5 * kPatchGap) / pitch)),
            row = static_cast<int>(std::floor((at.y() - 0.5 * kPatchGap) / pitch));
  if (column < 0 || row < 0 || column >= kChartColumns || row >= kChartRows)
    return Vector3d::Constant(kFrame);
  const int patch = kChartColumns * row + column;
  const Vector2d off = (at - PatchCenter(patch)).cwiseAbs();
  if (off.maxCoeff() > 0.5 * kPatchWidth) return Vector3d::Constant(kFrame);
  return patches[static_cast<std::size_t>(patch)];
}

// From the picture's plane (x right, y down, in picture widths from the middle, depth 1) to the chart.
struct Placement {
  Eigen::Matrix3d chart_from_ray;
  Vector2d At(double x, double y) const { return (chart_from_ray * Vector3d(x, y, 1)).hnormalized(); }
};

Placement PlacementOf(const ChartSceneOptions& options, std::uint64_t frame) {
  const auto jitter = [&](int which, double size) {
    return size * (2 * UnitShare(options.seed, frame, which) - 1);
  };
  const double turn = Radians(options.turn_deg + jitter(1, 0.5)),
               tilt = Radians(options.tilt_deg + jitter(2, 0.5));
  constexpr double kWidthShare = 0.62,
                   kDistance = 1.2;  // the chart's width in the picture; picture widths away
  const double unit = kWidthShare * kDistance / kChartWidth;
  const Eigen::Matrix3d rotation =
      (Eigen::AngleAxisd(turn, Vector3d::UnitZ()) * Eigen::AngleAxisd(tilt, Vector3d::UnitY()))
          .toRotationMatrix();
  const Vector3d middle(jitter(3, 0.004), jitter(4, 0.004), kDistance);
  // A point of the chart in the camera: middle + rotation * unit * (at - half of the chart).
  Eigen::Matrix3d camera_from_chart;
  camera_from_chart.col(0) = unit * rotation.col(0);
  camera_from_chart.col(1) = unit * rotation.col(1);
  camera_from_chart.col(2) =
      middle - 0.5 * unit * (kChartWidth * rotation.col(0) + kChartHeight * rotation.col(1));
  return {camera_from_chart.inverse()};
}

}  // namespace

Image RenderChart(const ChartSceneOptions& options, std::uint64_t frame) {
  const Placement placement = PlacementOf(options, frame);
  const Eigen::Matrix3d camera_from_srgb = options.colors.CameraFromSrgb();
  const Vector3d white = camera_from_srgb * LinearSrgbFromLab(ChartLab()[kFirstGrey]);
  constexpr double kCardGrey = 0.18;
  const double scale = options.card
                           ? options.white / (camera_from_srgb * Vector3d::Constant(kCardGrey)).maxCoeff()
                           : options.white / white.maxCoeff();
  constexpr int kSamples = 3;  // in each direction of a pixel
  cv::Mat radiance(options.height, options.width, CV_32FC4);
  for (int y = 0; y < radiance.rows; ++y)
    for (int x = 0; x < radiance.cols; ++x) {
      Vector3d sum = Vector3d::Zero();
      for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i)
          sum += options.card ? Vector3d(Vector3d::Constant(kCardGrey))
                              : ChartLight(placement.At(
                                    (x + (i + 0.5) / kSamples) / options.width - 0.5,
                                    (y + (j + 0.5) / kSamples - 0.5 * options.height) / options.width));
      const double lamp = 1 + options.gradient * ((x + 0.5) / options.width - 0.5);
      const Vector3d light = scale * lamp / (kSamples * kSamples) * (camera_from_srgb * sum);
      radiance.at<cv::Vec4f>(y, x) = {static_cast<float>(light[2]), static_cast<float>(light[1]),
                                      static_cast<float>(light[0]), 0};
    }
  return Expose(radiance, {.exposure_s = kReferenceExposure_s,
                           .gain = 1,
                           .format = options.format,
                           .noise_seed = options.seed * 1000003 + frame,
                           .noise = options.noise});
}

std::unique_ptr<Device> OpenSimulatedChart(const DeviceUri& uri) {
  uri.AllowOnly({"width", "height", "seed", "format", "lamp_k", "crosstalk", "white", "gradient", "turn_deg",
                 "tilt_deg", "noise", "frames"});
  ChartSceneOptions options;
  options.card = uri.path == "grey";
  options.width = uri.Whole("width", 64, 4096).value_or(options.width);
  options.height = uri.Whole("height", 64, 4096).value_or(options.height);
  options.seed = static_cast<std::uint64_t>(uri.Whole("seed", 0, 1 << 30).value_or(7));
  if (const auto format = SensorFormatOf(uri)) options.format = *format;
  options.colors = SensorColors::FromUri(uri);
  options.white = uri.Number("white", options.card ? 0.5 : options.white, 0.01, 10);
  options.gradient = uri.Number("gradient", 0, -1, 1);
  options.turn_deg = uri.Number("turn_deg", options.turn_deg, -180, 180);
  options.tilt_deg = uri.Number("tilt_deg", options.tilt_deg, -50, 50);
  options.noise = uri.Whole("noise", 0, 1).value_or(1) == 1;
  const auto count = static_cast<std::uint64_t>(uri.Whole("frames", 1, 1000000).value_or(100));
  return MakeBenchDevice(
      {.uri = uri,
       .seed = options.seed,
       .window = {options.width, options.height, 0, 0, options.width, options.height},
       .held = {.exposure = true, .white_balance = true, .focus = true},
       .picture = [options](std::uint64_t frame, double /*time_s*/) { return RenderChart(options, frame); },
       .is_over = [count](std::uint64_t frames) { return frames >= count; }});
}

}  // namespace ulf::acquisition
