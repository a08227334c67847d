// The visual hull of silhouettes (Laurentini 1994), in a cube of cells: a cell is empty if at least two of
// the silhouettes that have it in their picture exclude it (of many more, for one alone may be wrong), or if
// fewer than two have it there.
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
  cv::Mat mask;  // CV_8U, 0 outside the subject
};

class SilhouetteHull {
 public:
  // `half_side` is half of the cube's side, world units; `cells` is their number along a side.
  SilhouetteHull(std::span<const Silhouette> silhouettes, const Eigen::Vector3d& center_in_world,
                 double half_side, int cells = 112);

  bool empty() const { return surface_.empty(); }
  double CellSize() const { return 2 * half_side_ / cells_; }  // world units
  // Returns the hull as a camera sees it, CV_8U, 255 inside; each cell is drawn as the disc around it.
  cv::Mat ProjectedInto(const CameraModel& camera, const Rigid3& cam_from_world) const;
  // Returns the size in pixels of a cell in the middle of the cube, as this camera sees it.
  double CellPx(const CameraModel& camera, const Rigid3& cam_from_world) const;

 private:
  Eigen::Vector3d center_in_world_;
  double half_side_;
  int cells_;
  std::vector<Eigen::Vector3f> surface_;  // centres of full cells beside empty ones
};

}  // namespace ulf::render
