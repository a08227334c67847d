// Rolling shutter: rows are read one after the other, so that each is seen from its own pose.
//
// A frame's pose and time are those of its middle row. Row y was seen readout · (y / height - 1/2) later
// (earlier above the middle), when a point of the scene had moved in the image by as much as the camera's
// velocity makes it. That is taken away from every image point where a frame's features enter, and again,
// with the velocity that the frame itself shows, when its pose is fixed; from then on poses, points and
// bundle adjustment know global shutters only. Only pixels are where the sensor saw them: whoever reads
// pixels asks the pyramid, which knows its RowShift. Where the point of the scene is known the shift is exact
// for a constant velocity; where it is not, a depth is taken from the points around.
//
// The velocity over a frame's readout is found with the pose (as in Hedborg, Forssén, Felsberg and Ringaby
// 2012), and held to that between frames: alone it would be free to take up an image stretched in y (Albl,
// Sugimoto and Pajdla 2016).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/features/features.h"

namespace ulf::tracking {

// Of the camera's frame, per second, rotation then translation: t seconds later cam_from_world is
// Perturbed(cam_from_world, t * twist).
using Twist = Eigen::Matrix<double, 6, 1>;
Twist TwistBetween(const Rigid3& before, const Rigid3& after, double step_s);

// Depths anywhere in the image from those of some points: a bilinear grid of inverse depths, drawn to their
// mean where there are none. Scale as the points'.
class DepthField {
 public:
  struct Sample {
    Eigen::Vector2d img;
    double depth;  // along the optical axis
  };
  DepthField(const CameraModel& camera, std::span<const Sample> samples);
  double At(const Eigen::Vector2d& img) const;
  void Scale(double scale);

 private:
  static constexpr int kColumns = 17, kRows = 13;
  double width_, height_;
  std::vector<double> inverse_;
};

// Between where the sensor saw a point and where a global shutter at the frame's time would have.
class RowShift {
 public:
  RowShift(const CameraModel& camera, double readout_s, const Twist& twist, DepthField depths);

  Eigen::Vector2d Global(const Eigen::Vector2d& seen, const Eigen::Vector3d& point_in_cam) const;
  Eigen::Vector2d Seen(const Eigen::Vector2d& global, const Eigen::Vector3d& point_in_cam) const;
  // Of a point whose depth is that of those around.
  Eigen::Vector2d Global(const Eigen::Vector2d& seen) const;
  Eigen::Vector2d Seen(const Eigen::Vector2d& global) const;

  // The same in another unit of length.
  RowShift Scaled(double scale) const;

  const Twist& twist() const { return twist_; }
  double readout_s() const { return readout_s_; }
  // By how much this and another differ at the upper and lower edge, at most, in pixels.
  double ApartPx(const RowShift& other) const;

 private:
  double TimeOf(const Eigen::Vector2d& seen) const { return readout_s_ * (seen.y() / camera_.height - 0.5); }
  Eigen::Vector2d Moved(const Eigen::Vector3d& point_in_cam, double time_s) const;

  CameraModel camera_;
  double readout_s_;
  Twist twist_;
  DepthField depths_;
};

// A frame's features, brought to its time by another shift than so far; null: where the sensor saw them.
std::shared_ptr<const FeatureSet> MoveFeatures(const CameraModel& camera, const FeatureSet& features,
                                               const RowShift* from, const RowShift* to);
std::shared_ptr<const Pyramid> WithRows(const Pyramid& pyramid, std::shared_ptr<const RowShift> rows);

struct SeenPoint {
  Eigen::Vector3d point_in_world;
  Eigen::Vector2d seen;
  double sigma_px = 1;
};

// What moves in the image so.
struct PointFlow {
  Eigen::Vector3d point_in_cam;
  Eigen::Vector2d px_s;
};

// The camera's velocity that explains most of them best; none where there are too few.
std::optional<Twist> TwistFromFlow(const CameraModel& camera, std::span<const PointFlow> flow);

struct MotionPrior {
  Twist twist = Twist::Zero();
  Twist sigma = Twist::Ones();
};

struct PoseAndMotion {
  Rigid3 cam_from_world;
  Twist twist;
};

// The pose of the middle row and the velocity about it that explain what was seen, robustly. None where the
// points do not fix them.
std::optional<PoseAndMotion> RefinePoseAndMotion(const CameraModel& camera, double readout_s,
                                                 std::span<const SeenPoint> points, const Rigid3& initial,
                                                 const MotionPrior& prior);

}  // namespace ulf::tracking
