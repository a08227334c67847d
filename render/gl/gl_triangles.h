// The data of one draw of triangles of the viewpoint mesh or of the image. Each triangle has an order and a
// confidence, and a fan (the thesis's word) for each view that has weight in it; several fans are drawn
// together as a batch.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "render/viewpoints/triangle_topology.h"

namespace ulf::render {

using Vec4 = std::array<float, 4>;

inline Vec4 MakeVec4(double x, double y, double z, double w) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(w)};
}

// These are the shaders' structs (std430).
struct GpuTriangle {
  std::array<Vec4, 3> corner;
  std::array<Vec4, 3> row;
};
struct GpuFan {
  std::uint32_t triangle, view;
  std::array<std::uint32_t, 2> unused;
  Vec4 weights;
};

struct GpuFanBatch {
  std::uint32_t triangle, first, count;  // of its fans
  std::uint32_t array;                   // the texture of their photographs; the shaders do not read it
};

struct TriangleBatch {
  std::vector<GpuTriangle> triangles;
  std::vector<GpuFan> fans;  // fans of one triangle are consecutive
};

// Returns the views of the fans, each once, ascending.
std::vector<int> ViewsOf(const std::vector<GpuFan>& fans);

struct FanBatches {
  std::vector<GpuFan> fans;
  std::vector<GpuFanBatch> batches;
  bool one_each = true;  // no triangle has two batches; the batches are in the order of the triangles
};
// Forms batches of up to `most` fans. `array_of` returns the texture of a view's photograph; fans of views
// without one are left out.
FanBatches MakeFanBatches(const std::vector<GpuFan>& fans,
                          const std::function<std::optional<unsigned>(int view)>& array_of, int most);

// Lists, for each triangle, the views that have weight in it.
struct EntryTable {
  // A view's weights at the corners of a triangle.
  struct Entry {
    int key;  // a vertex of the viewpoint mesh, or a view
    std::array<double, 3> weights;
  };
  std::vector<Entry> entries;
  std::vector<std::size_t> first;  // per triangle, and the end
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
    for (const auto& [key, weights] : of_key) table.entries.push_back({.key = key, .weights = weights});
  }
  table.first.push_back(table.entries.size());
  return table;
}

// Returns none if the triangle does not meet the image. Corners are in the camera's axes. `along` (0 to 1)
// grows with the triangles' order, so that of overlapping triangles the last one counts.
std::optional<GpuTriangle> MakeTriangle(const Eigen::Matrix3d& corners_in_cam,
                                        const Eigen::Matrix3d& cone_from_ray_in_cam,
                                        const CameraModel& camera, double confidence, double along);

// Adds triangle `index` of `table` in front of all earlier ones if it meets the image, and returns whether it
// does. `view_of_key` has the view of each key of the table; empty means that keys are views.
bool AddTriangle(const Eigen::Matrix3d& corners_in_cam, const Eigen::Matrix3d& cone_from_ray_in_cam,
                 const CameraModel& camera, double confidence, double along, const EntryTable& table,
                 std::size_t index, const std::vector<int>& view_of_key, TriangleBatch& batch);

}  // namespace ulf::render
