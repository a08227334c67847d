#include "render/stereo/depth_range.h"

#include <algorithm>
#include <cmath>

namespace ulf::render {
namespace {

// Depths of the first sweep with a larger agreement (DepthMap::agreement) count. Guessed.
constexpr float kSure = 0.6f;

// Returns how many pixels the middle of the view's image moves in a neighbour's image over the range of
// depths.
double PathLengthPx(const StereoView& view, const StereoView& neighbour, double nearest, double farthest) {
  const Eigen::Vector3d ray = view.RayInWorld(view.camera.width / 2, view.camera.height / 2);
  const auto at = [&](double depth) {
    return neighbour.camera.ImgFromCam(neighbour.cam_from_world * (view.center_in_world + depth * ray));
  };
  const auto near = at(nearest), far = at(farthest);
  return near && far ? (*near - *far).norm() : 0;
}

}  // namespace

InverseDepthRange PixelSpacedRange(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                                   double nearest, double farthest) {
  double widest = 0;
  for (const StereoView* neighbour : neighbours)
    widest = std::max(widest, PathLengthPx(view, *neighbour, nearest, farthest));
  const int planes = std::clamp(static_cast<int>(std::ceil(std::min(widest, 1.0 * kMostPlanes))) + 1,
                                kFewestPlanes, kMostPlanes);
  return {1 / farthest, 1 / nearest, planes};
}

double DepthStepOfPixel(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                        double distance) {
  constexpr double kSmallStep = 1e-3;  // of the distance: the change is assumed linear
  const double step = kSmallStep * distance;
  double widest = 0;
  for (const StereoView* neighbour : neighbours)
    widest = std::max(widest, PathLengthPx(view, *neighbour, distance, distance + step));
  return step / widest;
}

InverseDepthRange FindRange(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                            double subject_distance, const DepthRangeOptions& options) {
  StereoView small = HalfSize(view);
  std::vector<StereoView> small_neighbours;
  for (const StereoView* neighbour : neighbours) small_neighbours.push_back(HalfSize(*neighbour));
  while (std::max(small.grey.cols, small.grey.rows) > options.size_px) {
    small = HalfSize(small);
    for (StereoView& neighbour : small_neighbours) neighbour = HalfSize(neighbour);
  }
  std::vector<const StereoView*> pointers;
  for (const StereoView& neighbour : small_neighbours) pointers.push_back(&neighbour);
  const double nearest = options.nearest * subject_distance, farthest = options.farthest * subject_distance;
  const DepthMap map = SweepPlanes(small, pointers, PixelSpacedRange(small, pointers, nearest, farthest),
                                   {.coarse_from_px = options.coarse_from_px, .given_up = options.given_up});

  std::vector<double> inverse;
  for (int y = 0; y < map.depth.rows; ++y)
    for (int x = 0; x < map.depth.cols; ++x)
      if (map.agreement.at<float>(y, x) > kSure) inverse.push_back(1 / map.depth.at<float>(y, x));
  if (inverse.size() < options.fewest) return PixelSpacedRange(view, neighbours, nearest, farthest);
  std::ranges::sort(inverse);
  const std::size_t left_out =
      static_cast<std::size_t>(options.left_out * static_cast<double>(inverse.size()));
  const double least = inverse[left_out], most = inverse[inverse.size() - 1 - left_out];
  const double margin = options.margin * (most - least) + options.margin_of_most * most;
  return PixelSpacedRange(view, neighbours, 1 / std::min(1 / nearest, most + margin),
                          1 / std::max(1 / farthest, least - margin));
}

}  // namespace ulf::render
