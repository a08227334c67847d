#include "render/proxy/depth_raster.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/pinhole.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;

struct CutPolygon {
  std::array<Vector3d, 4> corners;
  std::size_t count = 0;
};

CutPolygon CutNear(const std::array<Vector3d, 3>& corners, double near) {
  CutPolygon cut;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d &a = corners[k], &b = corners[(k + 1) % 3];
    if (a.z() >= near) cut.corners[cut.count++] = a;
    if ((a.z() >= near) != (b.z() >= near))
      cut.corners[cut.count++] = a + (near - a.z()) / (b.z() - a.z()) * (b - a);
  }
  return cut;
}

// All corners must lie in front of the camera.
void DrawTriangle(const std::array<Vector3d, 3>& corners, const CameraModel& camera, cv::Mat& inverse_depth) {
  std::array<Vector3d, 3> at;  // pixels, inverse depth
  for (std::size_t k = 0; k < 3; ++k) {
    at[k].head<2>() = PinholeImg(camera, corners[k]);
    at[k].z() = 1 / corners[k].z();
  }
  const auto [left, right] = std::minmax({at[0].x(), at[1].x(), at[2].x()});
  const auto [top, bottom] = std::minmax({at[0].y(), at[1].y(), at[2].y()});
  if (!(right > 0 && bottom > 0 && left < camera.width && top < camera.height)) return;
  const int first_x = static_cast<int>(std::ceil(std::max(left, 0.0) - 0.5));
  const int first_y = static_cast<int>(std::ceil(std::max(top, 0.0) - 0.5));
  const int last_x = static_cast<int>(std::floor(std::min<double>(right, camera.width) - 0.5));
  const int last_y = static_cast<int>(std::floor(std::min<double>(bottom, camera.height) - 0.5));
  if (first_x > last_x || first_y > last_y) return;

  // Edge functions are positive inside; their sum is twice the area.
  const double doubled =
      (at[1].x() - at[0].x()) * (at[2].y() - at[0].y()) - (at[1].y() - at[0].y()) * (at[2].x() - at[0].x());
  if (doubled == 0) return;
  std::array<double, 3> by_x{}, by_y{}, at_first{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d &from = at[(k + 1) % 3], &to = at[(k + 2) % 3];
    by_x[k] = -(to.y() - from.y()) / doubled;
    by_y[k] = (to.x() - from.x()) / doubled;
    at_first[k] = by_x[k] * (first_x + 0.5 - from.x()) + by_y[k] * (first_y + 0.5 - from.y());
  }
  for (int y = first_y; y <= last_y; ++y) {
    float* row = inverse_depth.ptr<float>(y);
    std::array<double, 3> share = at_first;
    for (std::size_t k = 0; k < 3; ++k) share[k] += by_y[k] * (y - first_y);
    for (int x = first_x; x <= last_x; ++x) {
      if (share[0] >= 0 && share[1] >= 0 && share[2] >= 0) {
        const auto value =
            static_cast<float>(share[0] * at[0].z() + share[1] * at[1].z() + share[2] * at[2].z());
        row[x] = std::max(row[x], value);
      }
      for (std::size_t k = 0; k < 3; ++k) share[k] += by_x[k];
    }
  }
}

}  // namespace

cv::Mat DrawInverseDepth(const TriangleMesh& mesh, const CameraModel& camera, const Rigid3& cam_from_world) {
  cv::Mat inverse_depth = cv::Mat::zeros(camera.height, camera.width, CV_32F);
  const Eigen::Matrix3f rotation = cam_from_world.RotationMatrix().cast<float>();
  const Eigen::Vector3f translation = cam_from_world.translation.cast<float>();
  std::vector<Eigen::Vector3f> in_cam(mesh.vertices.size());
  for (std::size_t i = 0; i < in_cam.size(); ++i) in_cam[i] = rotation * mesh.vertices[i] + translation;
  for (const auto& t : mesh.triangles) {
    const std::array<Vector3d, 3> corners{in_cam[t[0]].cast<double>(), in_cam[t[1]].cast<double>(),
                                          in_cam[t[2]].cast<double>()};
    const double farthest = std::max({corners[0].z(), corners[1].z(), corners[2].z()});
    if (!(farthest > 0)) continue;
    const CutPolygon cut = CutNear(corners, kNearShare * farthest);
    for (std::size_t k = 2; k < cut.count; ++k)
      DrawTriangle({cut.corners[0], cut.corners[k - 1], cut.corners[k]}, camera, inverse_depth);
  }
  return inverse_depth;
}

void FillHoles(cv::Mat& inverse_depth) {
  std::vector<cv::Mat> levels{inverse_depth};
  while (levels.back().rows > 1 || levels.back().cols > 1) {
    const cv::Mat& fine = levels.back();
    cv::Mat coarse((fine.rows + 1) / 2, (fine.cols + 1) / 2, CV_32F);
    for (int y = 0; y < coarse.rows; ++y)
      for (int x = 0; x < coarse.cols; ++x) {
        float sum = 0, known = 0;
        for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
          if (2 * y + dy >= fine.rows || 2 * x + dx >= fine.cols) continue;
          const float value = fine.at<float>(2 * y + dy, 2 * x + dx);
          sum += value;
          known += value > 0 ? 1.0f : 0.0f;
        }
        coarse.at<float>(y, x) = known > 0 ? sum / known : 0;
      }
    levels.push_back(coarse);
  }
  for (std::size_t level = levels.size() - 1; level-- > 0;) {
    const cv::Mat& coarse = levels[level + 1];
    cv::Mat& fine = levels[level];
    for (int y = 0; y < fine.rows; ++y)
      for (int x = 0; x < fine.cols; ++x) {
        if (fine.at<float>(y, x) > 0) continue;
        const int left = x / 2, top = y / 2;
        const int beside = std::clamp(left + (x % 2 ? 1 : -1), 0, coarse.cols - 1);
        const int above = std::clamp(top + (y % 2 ? 1 : -1), 0, coarse.rows - 1);
        fine.at<float>(y, x) = (9 * coarse.at<float>(top, left) + 3 * coarse.at<float>(top, beside) +
                                3 * coarse.at<float>(above, left) + coarse.at<float>(above, beside)) /
                               16;
      }
  }
}

}  // namespace ulf::render
