// A recorded view's depth map, from which the soft field (render/renderer/soft_pixel.h) takes surfaces and
// the view's visibility. Inverse depths have 16 bits, as on disk (depth_map_files.h) and in graphics memory.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

struct ViewDepthMap {
  CameraModel camera;     // without distortion, of the map's size
  cv::Mat inverse_depth;  // CV_16UC1: 1 / (depth along the optical axis), in units of `unit`; 0: unknown
  double unit = 0;        // 1 / world units
  double step = 0;        // 1 / world units: uncertainty of the map's inverse depths

  double InverseDepthAt(int x, int y) const { return unit * inverse_depth.at<std::uint16_t>(y, x); }
};

// `inverse_depth` is CV_32F, 0: unknown.
ViewDepthMap MakeViewDepthMap(const CameraModel& camera, const cv::Mat& inverse_depth, double step);

// Draws the mesh as this camera (without distortion) sees it; holes of the mesh get the depths around them.
ViewDepthMap DepthMapOfMesh(const TriangleMesh& mesh, const CameraModel& camera, const Rigid3& cam_from_world,
                            double step);

// Returns about how far points at `distance` move in the image, px of `camera`, when its pose changes.
double MovedPx(const CameraModel& camera, const Rigid3& then, const Rigid3& now, double distance);

// Makes or reads a map at the first Get(), in the thread that calls it, because a picture needs the maps of
// few views. Several threads may call it.
template <typename Map>
class Lazy {
 public:
  explicit Lazy(std::function<Map()> make) : make_(std::move(make)) {}
  const Map& Get() const {
    std::call_once(made_, [this] { map_ = make_(); });
    return *map_;
  }

 private:
  std::function<Map()> make_;
  mutable std::once_flag made_;
  mutable std::optional<Map> map_;
};
using LazyDepthMap = Lazy<ViewDepthMap>;

}  // namespace ulf::render
