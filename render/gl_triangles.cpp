#include "render/gl_triangles.h"

#include <algorithm>

namespace ulf {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::optional<GpuTriangle> MakeTriangle(const Matrix3d& corners_in_cam, const Matrix3d& cone_from_ray_in_cam,
                                        const CameraModel& camera, double confidence, double along) {
  GpuTriangle triangle;
  std::array<int, 5> outside{};
  for (int k = 0; k < 3; ++k) {
    const Vector3d c = corners_in_cam.col(k);
    const double x = 2 * (camera.fx * c.x() + camera.cx * c.z()) / camera.width - c.z();
    const double y = 2 * (camera.fy * c.y() + camera.cy * c.z()) / camera.height - c.z();
    outside[0] += c.z() <= 0;
    outside[1] += x > c.z();
    outside[2] += -x > c.z();
    outside[3] += y > c.z();
    outside[4] += -y > c.z();
    triangle.corner[static_cast<std::size_t>(k)] = MakeVec4(x, y, 0.9 - 1.8 * along, c.z());
    triangle.row[static_cast<std::size_t>(k)] = MakeVec4(
        cone_from_ray_in_cam(k, 0), cone_from_ray_in_cam(k, 1), cone_from_ray_in_cam(k, 2), confidence);
  }
  if (std::count(outside.begin(), outside.end(), 3) > 0) return std::nullopt;
  return triangle;
}

void AddTriangle(const Matrix3d& corners_in_cam, const Matrix3d& cone_from_ray_in_cam,
                 const CameraModel& camera, double confidence, double along, const EntryTable& table,
                 std::size_t index, const std::vector<int>& view_of_key, TriangleBatch& batch) {
  const auto triangle = MakeTriangle(corners_in_cam, cone_from_ray_in_cam, camera, confidence, along);
  if (!triangle) return;
  for (std::size_t e = table.first[index]; e < table.first[index + 1]; ++e) {
    const EntryTable::Entry& entry = table.entries[e];
    batch.fans.push_back(
        {static_cast<std::uint32_t>(batch.triangles.size()),
         static_cast<std::uint32_t>(view_of_key.empty() ? entry.key
                                                        : view_of_key[static_cast<std::size_t>(entry.key)]),
         {0, 0},
         MakeVec4(entry.weights[0], entry.weights[1], entry.weights[2], 0)});
  }
  batch.triangles.push_back(*triangle);
}

std::vector<FanRun> SortByView(std::vector<GpuFan>& fans) {
  std::stable_sort(fans.begin(), fans.end(),
                   [](const GpuFan& a, const GpuFan& b) { return a.view < b.view; });
  std::vector<FanRun> runs;
  for (std::size_t i = 0; i < fans.size(); ++i) {
    if (i == 0 || fans[i].view != fans[i - 1].view) runs.push_back({static_cast<int>(fans[i].view), i, 0});
    ++runs.back().count;
  }
  return runs;
}

}  // namespace ulf
