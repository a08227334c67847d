#include "render/gl/gl_triangles.h"

#include <algorithm>

namespace ulf::render {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::optional<GpuTriangle> MakeTriangle(const Matrix3d& corners_in_cam, const Matrix3d& cone_from_ray_in_cam,
                                        const CameraModel& camera, double confidence, double along) {
  constexpr double kNearest = 0.9;  // depths go from this to its negative, well inside the clip space
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
    triangle.corner[static_cast<std::size_t>(k)] = MakeVec4(x, y, kNearest - 2 * kNearest * along, c.z());
    triangle.row[static_cast<std::size_t>(k)] = MakeVec4(
        cone_from_ray_in_cam(k, 0), cone_from_ray_in_cam(k, 1), cone_from_ray_in_cam(k, 2), confidence);
  }
  if (std::ranges::count(outside, 3) > 0) return std::nullopt;
  return triangle;
}

bool AddTriangle(const Matrix3d& corners_in_cam, const Matrix3d& cone_from_ray_in_cam,
                 const CameraModel& camera, double confidence, double along, const EntryTable& table,
                 std::size_t index, const std::vector<int>& view_of_key, TriangleBatch& batch) {
  const auto triangle = MakeTriangle(corners_in_cam, cone_from_ray_in_cam, camera, confidence, along);
  if (!triangle) return false;
  for (std::size_t e = table.first[index]; e < table.first[index + 1]; ++e) {
    const EntryTable::Entry& entry = table.entries[e];
    batch.fans.push_back(
        {static_cast<std::uint32_t>(batch.triangles.size()),
         static_cast<std::uint32_t>(view_of_key.empty() ? entry.key
                                                        : view_of_key[static_cast<std::size_t>(entry.key)]),
         {},
         MakeVec4(entry.weights[0], entry.weights[1], entry.weights[2], 0)});
  }
  batch.triangles.push_back(*triangle);
  return true;
}

std::vector<int> ViewsOf(const std::vector<GpuFan>& fans) {
  std::vector<int> of_views;
  for (const GpuFan& fan : fans) of_views.push_back(static_cast<int>(fan.view));
  std::ranges::sort(of_views);
  of_views.erase(std::unique(of_views.begin(), of_views.end()), of_views.end());
  return of_views;
}

FanBatches MakeFanBatches(const std::vector<GpuFan>& fans,
                          const std::function<std::optional<unsigned>(int view)>& array_of, int most) {
  FanBatches made;
  std::vector<std::pair<unsigned, GpuFan>> of_triangle;
  for (std::size_t done = 0; done < fans.size();) {
    const std::uint32_t triangle = fans[done].triangle;
    of_triangle.clear();
    for (; done < fans.size() && fans[done].triangle == triangle; ++done)
      if (const auto array = array_of(static_cast<int>(fans[done].view)))
        of_triangle.emplace_back(*array, fans[done]);
    std::ranges::sort(of_triangle, [](const auto& a, const auto& b) {
      return std::pair(a.first, a.second.view) < std::pair(b.first, b.second.view);
    });
    const std::size_t before = made.batches.size();
    for (const auto& [array, fan] : of_triangle) {
      if (made.batches.size() == before || made.batches.back().array != array ||
          made.batches.back().count == static_cast<std::uint32_t>(most))
        made.batches.push_back({triangle, static_cast<std::uint32_t>(made.fans.size()), 0, array});
      ++made.batches.back().count;
      made.fans.push_back(fan);
    }
    made.one_each = made.one_each && made.batches.size() <= before + 1;
  }
  if (!made.one_each)  // batches are added up: their order does not matter
    std::ranges::stable_sort(made.batches, [](const GpuFanBatch& a, const GpuFanBatch& b) {
      return std::pair(a.array, a.count) < std::pair(b.array, b.count);
    });
  return made;
}

}  // namespace ulf::render
