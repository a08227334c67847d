// Models a rolling shutter: the sensor reads the rows one after the other, so that each has its own pose.
//
// A frame's pose and time are those of its middle row. Row y was read readout · (y / height - 1/2) later
// (earlier above the middle), when the camera's velocity had moved the image of a point. The tracker removes
// this shift from every image point when it detects the features, and again, with the velocity that the frame
// itself shows, when it fixes the pose; from then on image points are a global shutter's. Adjustments of the
// whole map find the velocities of fast keyframes anew (map_adjustment.cpp). Only pixels stay where the
// sensor saw them, so code that reads pixels converts by the pyramid's RowShift. The shift is exact for a
// known point of the scene and a constant velocity; otherwise the depth is interpolated from known points
// around.
//
// The velocity over a frame's readout is estimated with the pose (as in Hedborg, Forssén, Felsberg and
// Ringaby 2012) and held to the velocity between frames: alone it would absorb a stretch of the image in y
// (Albl, Sugimoto and Pajdla 2016).
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

// A velocity in the camera's frame, rotation (rad/s) then translation (world units/s): t seconds later
// cam_from_world is Perturbed(cam_from_world, t * twist).
using Twist = Eigen::Matrix<double, 6, 1>;
// Returns the mean velocity between two poses cam_from_world that are `step_s` apart.
Twist TwistBetween(const Rigid3& before, const Rigid3& after, double step_s);
// Returns where in the camera's frame a point of that frame is `time_s` later, to second order in the
// rotation. Sets `by_point` and `by_twist`, unless null, to the derivatives.
Eigen::Vector3d PointAfter(const Twist& twist, const Eigen::Vector3d& point, double time_s,
                           Eigen::Matrix3d* by_point = nullptr,
                           Eigen::Matrix<double, 3, 6>* by_twist = nullptr);
// Returns when a row was read, relative to the middle one.
inline double RowTime(double readout_s, double row, int height) { return readout_s * (row / height - 0.5); }

// Interpolates depths over the image from those of some points: a bilinear grid of inverse depths, which
// tends to their mean where there are no points. Depths are along the optical axis, world units.
class DepthField {
 public:
  // Guessed: the grid, the weight of the mean in points, and the depth where nothing is known.
  static constexpr int kColumns = 17, kRows = 13;
  static constexpr double kMeanWeight = 0.1, kFar = 1e6;
  struct Sample {
    Eigen::Vector2d img;
    double depth;
  };
  DepthField(const CameraModel& camera, std::span<const Sample> samples);
  double At(const Eigen::Vector2d& img) const;  // kFar without samples
  void Scale(double scale);                     // multiplies the depths

 private:
  struct Corner {
    std::size_t node;  // upper left node of an image point's cell
    double fx, fy;     // place in the cell, from 0 to 1
  };
  Corner CornerOf(const Eigen::Vector2d& img) const;

  double width_, height_;
  std::vector<double> inverse_;
};

// Converts the image points of one frame between where the sensor saw them ("seen") and where a global
// shutter at the time of the middle row would have ("global").
class RowShift {
 public:
  RowShift(const CameraModel& camera, double readout_s, const Twist& twist, DepthField depths);

  // `point_in_cam` is the known point in the camera's frame at the time of the middle row.
  Eigen::Vector2d Global(const Eigen::Vector2d& seen, const Eigen::Vector3d& point_in_cam) const;
  Eigen::Vector2d Seen(const Eigen::Vector2d& global, const Eigen::Vector3d& point_in_cam) const;
  // These interpolate the depth.
  Eigen::Vector2d Global(const Eigen::Vector2d& seen) const;
  Eigen::Vector2d Seen(const Eigen::Vector2d& global) const;

  // Returns the point, in the camera's frame at the time of the middle row, that the sensor saw at an image
  // point with this ray, by an interpolated depth.
  Eigen::Vector3d GlobalPoint(const Eigen::Vector2d& seen, const Eigen::Vector3d& ray) const;

  // Returns the same shift in a world whose lengths are `scale` times as large.
  RowShift Scaled(double scale) const;

  const Twist& twist() const { return twist_; }
  double readout_s() const { return readout_s_; }

 private:
  double TimeOf(const Eigen::Vector2d& seen) const { return RowTime(readout_s_, seen.y(), camera_.height); }
  Eigen::Vector2d Moved(const Eigen::Vector3d& point_in_cam, double time_s) const;

  CameraModel camera_;
  double readout_s_;
  Twist twist_;
  DepthField depths_;
};

// Returns features from which the shift `to` is removed in place of `from`; null: no shift, features are
// where the sensor saw them. Features keep their order; those that cannot be moved stay.
std::shared_ptr<const FeatureSet> MoveFeatures(const CameraModel& camera, const FeatureSet& features,
                                               const RowShift* from, const RowShift* to);
// Removes a shift from features as the sensor saw them.
std::shared_ptr<const FeatureSet> RemoveRows(const CameraModel& camera, const FeatureSet& detected,
                                             const RowShift& rows);
// Returns the pyramid, whose images are shared, with another shift (null: none).
std::shared_ptr<const Pyramid> WithRows(const Pyramid& pyramid, std::shared_ptr<const RowShift> rows);

// A known point, and where the sensor saw it.
struct SeenPoint {
  Eigen::Vector3d point_in_world;
  Eigen::Vector2d seen;
  double sigma_px = 1;
};

// A point and its velocity in the image, px/s.
struct PointFlow {
  Eigen::Vector3d point_in_cam;
  Eigen::Vector2d px_s;
};

// Returns the camera's velocity that explains the flow robustly; none with fewer than 12 usable points.
std::optional<Twist> TwistFromFlow(const CameraModel& camera, std::span<const PointFlow> flow);

// The expected velocity, and its standard deviations.
struct MotionPrior {
  Twist twist = Twist::Zero();
  Twist sigma = Twist::Ones();
};

struct PoseAndMotion {
  Rigid3 cam_from_world;
  Twist twist;
};

// Returns the pose of the middle row and the velocity during the readout that explain the observations
// robustly. Returns none with fewer than 8 visible points.
std::optional<PoseAndMotion> RefinePoseAndMotion(const CameraModel& camera, double readout_s,
                                                 std::span<const SeenPoint> points, const Rigid3& initial,
                                                 const MotionPrior& prior);

}  // namespace ulf::tracking
