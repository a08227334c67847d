#include "render/masks/silhouette_hull.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel_for.h"

namespace ulf::render {

// A cell is empty if this share of the silhouettes that have it in their picture exclude it. Guessed.
constexpr double kEmptyShare = 0.06;
constexpr int kFewestEmpty = 2;

using Eigen::Vector3d;

SilhouetteHull::SilhouetteHull(std::span<const Silhouette> silhouettes, const Vector3d& center_in_world,
                               double half_side, int cells)
    : center_in_world_(center_in_world), half_side_(half_side), cells_(cells) {
  const int n = cells_;
  const auto at = [n](int x, int y, int z) {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(n) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(n) +
           static_cast<std::size_t>(x);
  };
  const auto middle_of = [&](int x, int y, int z) {
    return Vector3d(center_in_world_ +
                    CellSize() * Vector3d(x + 0.5 - 0.5 * n, y + 0.5 - 0.5 * n, z + 0.5 - 0.5 * n));
  };
  std::vector<char> full(
      static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n), 0);
  ParallelFor(static_cast<std::size_t>(n), [&](std::size_t layer) {
    const int z = static_cast<int>(layer);
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const Vector3d point = middle_of(x, y, z);
        int seen = 0, left_out = 0;
        const auto limit = [&] {
          return std::max(kFewestEmpty, static_cast<int>(std::ceil(kEmptyShare * seen)));
        };
        const int most = std::max(
            kFewestEmpty, static_cast<int>(std::ceil(kEmptyShare * static_cast<double>(silhouettes.size()))));
        for (const Silhouette& silhouette : silhouettes) {
          const auto img = silhouette.camera.ImgFromCam(silhouette.cam_from_world * point);
          if (!img || !silhouette.camera.Contains(*img)) continue;
          ++seen;
          left_out +=
              silhouette.mask.at<std::uint8_t>(static_cast<int>(img->y()), static_cast<int>(img->x())) == 0;
          if (left_out >= most) break;
        }
        full[at(x, y, z)] = seen >= kFewestEmpty && left_out < limit();
      }
  });
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        if (!full[at(x, y, z)]) continue;
        const bool inside = x > 0 && y > 0 && z > 0 && x + 1 < n && y + 1 < n && z + 1 < n &&
                            full[at(x - 1, y, z)] && full[at(x + 1, y, z)] && full[at(x, y - 1, z)] &&
                            full[at(x, y + 1, z)] && full[at(x, y, z - 1)] && full[at(x, y, z + 1)];
        if (!inside) surface_.push_back(middle_of(x, y, z).cast<float>());
      }
}

double SilhouetteHull::CellPx(const CameraModel& camera, const Rigid3& cam_from_world) const {
  return camera.MeanFocalPx() * CellSize() / (cam_from_world * center_in_world_).norm();
}

cv::Mat SilhouetteHull::ProjectedInto(const CameraModel& camera, const Rigid3& cam_from_world) const {
  cv::Mat seen = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  // A cell reaches to its corners.
  const double reach = 0.5 * std::sqrt(3.0) * CellSize();
  for (const Eigen::Vector3f& point : surface_) {
    const Vector3d in_cam = cam_from_world * point.cast<double>();
    const auto img = camera.ImgFromCam(in_cam);
    if (!img) continue;
    const int radius = std::max(1, static_cast<int>(std::lround(camera.MeanFocalPx() * reach / in_cam.z())));
    cv::circle(seen, {static_cast<int>(img->x()), static_cast<int>(img->y())}, radius, cv::Scalar(255),
               cv::FILLED);
  }
  return seen;
}

}  // namespace ulf::render
