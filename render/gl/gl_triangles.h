// What one draw of triangles needs, whatever they are triangles of: the mesh of viewpoints, or the image.
// Each triangle once for its order and confidence, then for the views that weigh in it (its fans, in the
// thesis's word), of which several are drawn together as a batch.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "render/fields/triangle_topology.h"

namespace ulf::render {

using Vec4 = std::array<float, 4>;

inline Vec4 MakeVec4(double x, double y, double z, double w) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(w)};
}

// The shaders' structs (std430).
struct GpuTriangle {
  std::array<Vec4, 3> corner;
  std::array<Vec4, 3> row;
};
struct GpuFan {
  std::uint32_t triangle, view, unused[2];
  Vec4 weights;
};

struct GpuFanBatch {
  std::uint32_t triangle, first, count;  // of its fans
  std::uint32_t array;                   // not for the shaders: the texture that has their photographs
};

struct TriangleBatch {
  std::vector<GpuTriangle> triangles;
  std::vector<GpuFan> fans;  // those of a triangle one behind the other
};

// Each once, in their order.
std::vector<int> ViewsOf(const std::vector<GpuFan>& fans);

struct FanBatches {
  std::vector<GpuFan> fans;
  std::vector<GpuFanBatch> batches;
  bool one_each = true;  // no triangle has two; they are in the order of triangles
};
// Of fans whose photographs are there (`array_of` their view tells in which texture), at most so many in one.
FanBatches MakeFanBatches(const std::vector<GpuFan>& fans,
                          const std::function<std::optional<unsigned>(int view)>& array_of, int most);

// For each triangle the views that weigh in it.
struct EntryTable {
  // A view's weights at the corners of a triangle.
  struct Entry {
    int key;  // vertex of the viewpoint mesh, or view
    std::array<double, 3> weights;
  };
  std::vector<Entry> entries;
  std::vector<std::size_t> first;  // one more than there are triangles
};

// `weights_of_corner(corner, add)` calls add(key, weight).
template <typename WeightsOfCorner>
EntryTable MakeEntries(const std::vector<Triangle>& triangles, WeightsOfCorner&& weights_of_corner) {
  EntryTable table;
  for (const Triangle& t : triangles) {
    table.first.push_back(table.entries.size());
    std::map<int, std::array<double, 3>> of_key;
    for (std::size_t k = 0; k < 3; ++k)
      weights_of_corner(t[k], [&](int key, double weight) { of_key[key][k] += weight; });
    for (const auto& [key, weights] : of_key) table.entries.push_back({key, weights});
  }
  table.first.push_back(table.entries.size());
  return table;
}

// None when it does not meet the frame. Corners are in the camera's axes; `along` (0 to 1) grows with the
// triangles, so that of those that overlap the last one counts.
std::optional<GpuTriangle> MakeTriangle(const Eigen::Matrix3d& corners_in_cam,
                                        const Eigen::Matrix3d& cone_from_ray_in_cam,
                                        const CameraModel& camera, double confidence, double along);

// Adds triangle `index` of `table`, in front of all added before; nothing when it does not meet the frame.
// `view_of_key` by key of the table; empty: keys are views.
void AddTriangle(const Eigen::Matrix3d& corners_in_cam, const Eigen::Matrix3d& cone_from_ray_in_cam,
                 const CameraModel& camera, double confidence, double along, const EntryTable& table,
                 std::size_t index, const std::vector<int>& view_of_key, TriangleBatch& batch);

}  // namespace ulf::render
