// A picture source for tracker tests that costs milliseconds: a textured wall with tilted panels before it,
// drawn by homographies, with exact poses. World: x right, y down, z towards the wall, metres.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "acquisition/camera_model.h"
#include "acquisition/frame.h"
#include "acquisition/rigid3.h"

namespace ulf::test {

class TexturedRoom {
 public:
  struct Options {
    bool panels = true;  // false: one wall, the flat case
    unsigned seed = 1;
    double noise = 2;  // standard deviation, grey levels
  };
  explicit TexturedRoom(const Options& options);

  static CameraModel Camera() { return CameraModel::Pinhole(640, 480, 520); }
  Frame Take(const Rigid3& cam_from_world, std::uint64_t id, const CameraModel& camera = Camera()) const;

  // A hand that sways sideways, up and down and forth, looking at the panels; 30 frames a second.
  static Rigid3 HandAt(int frame);
  // Turning about a fixed centre.
  static Rigid3 TurningAt(int frame);

 private:
  struct Plane {
    Eigen::Vector3d corner, along_x, along_y;  // unit axes
    double pixels_per_m;
    cv::Mat texture;
  };
  Options options_;
  std::vector<Plane> planes_;  // far to near
};

}  // namespace ulf::test
