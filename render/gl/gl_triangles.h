// Prepares triangles of the viewpoint mesh or of the image for drawing. Each triangle has an order and a
// confidence, and a fan (the thesis's word) for each view that has weight in it; several fans of a triangle
// are drawn together as a batch.
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
  std::array<Vec4, 3> corner;  // clip coordinates; the depth is that of the order
  std::array<Vec4, 3> row;     // of the matrix from rays in the camera to barycentric; w: the confidence
};
struct GpuFan {
  std::uint32_t triangle, view;  // indices
  std::array<std::uint32_t, 2> unused;
  Vec4 weights;  // at the three corners; w is unused
};

struct GpuFanBatch {
  std::uint32_t triangle, first, count;  // its triangle; its fans in FanBatches::fans
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
// Forms batches of up to `most` fans. `array_of` returns the texture array of a view's photograph, or none:
// the view's fans are then left out.
FanBatches MakeFanBatches(const std::vector<GpuFan>& fans,
                          const std::function<std::optional<unsigned>(int view)>& array_of, int most);

// Lists, for each triangle, the views (or vertices that stand for views) that have weight in it.
struct EntryTable {
  // A view's weights at the corners of a triangle.
  struct Entry {
    int key;  // a vertex of the viewpoint mesh, or a view
    std::array<double, 3> weights;
  };
  std::vector<Entry> entries;
  std::vector<std::size_t> first;  // per triangle, its first entry; then the number of all entries
};

// `weights_of_corner(vertex, add)` must call add(key, weight) for each weight at a vertex of the triangles.
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

// Returns none if the triangle does not meet the image. The columns of `corners_in_cam` are the corners from
// the camera's centre, in its axes; the second matrix is their ConeFromRay(). `along` (0 to 1) grows with the
// triangles' order, so that of overlapping triangles the last one counts.
std::optional<GpuTriangle> MakeTriangle(const Eigen::Matrix3d& corners_in_cam,
                                        const Eigen::Matrix3d& cone_from_ray_in_cam,
                                        const CameraModel& camera, double confidence, double along);

// Appends triangle `index` of `table` with its fans to `batch` if it meets the image, and returns whether it
// does. `view_of_key` has the view of each key of the table; empty means that keys are views.
bool AddTriangle(const Eigen::Matrix3d& corners_in_cam, const Eigen::Matrix3d& cone_from_ray_in_cam,
                 const CameraModel& camera, double confidence, double along, const EntryTable& table,
                 std::size_t index, const std::vector<int>& view_of_key, TriangleBatch& batch);

}  // namespace ulf::render
