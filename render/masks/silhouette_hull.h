// The visual hull of silhouettes (Laurentini 1994) in cells: a cell is empty if several silhouettes that have
// it in their picture exclude it. One silhouette alone may be wrong.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::render {

struct Silhouette {
  CameraModel camera;  // of the mask's size
  Rigid3 cam_from_world;
  cv::Mat mask;  // CV_8U, 0 outside
};

class SilhouetteHull {
 public:
  // `cells` is their number along a side of the cube.
  SilhouetteHull(std::span<const Silhouette> silhouettes, const Eigen::Vector3d& center_in_world,
                 double half_side, int cells = 112);

  bool empty() const { return surface_.empty(); }
  double CellSize() const { return 2 * half_side_ / cells_; }
  // Returns the hull as a camera sees it, CV_8U, 255 inside, dilated by half a cell.
  cv::Mat ProjectedInto(const CameraModel& camera, const Rigid3& cam_from_world) const;
  // Returns the size of a cell in such a picture, pixels.
  double CellPx(const CameraModel& camera, const Rigid3& cam_from_world) const;

 private:
  Eigen::Vector3d center_in_world_;
  double half_side_;
  int cells_;
  std::vector<Eigen::Vector3f> surface_;  // centres of full cells beside empty ones
};

}  // namespace ulf::render
