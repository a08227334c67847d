// Models a rolling shutter: the sensor reads the rows one after the other, so that each has its own pose.
//
// A frame's pose and time are those of its middle row. Row y was read readout · (y / height - 1/2) later
// (earlier above the middle), when the camera's velocity had moved the image of a point. The tracker removes
// this shift from every image point when it detects the features, and again, with the velocity that the frame
// itself shows, when it fixes the pose; from then on poses and points know global shutters only. Adjustments
// of the whole map find the velocities of fast keyframes anew (map_adjustment.cpp). Only pixels stay where
// the sensor saw them, so code that reads pixels converts by the pyramid's RowShift. For a known point of the
// scene the shift is exact at a constant velocity; otherwise its depth is interpolated from the points
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
Twist TwistBetween(const Rigid3& before, const Rigid3& after, double step_s);
// Returns where a point of the camera's frame is in that frame `time_s` later, to second order in the
// rotation. The derivatives, if wanted, are by the point and by the twist.
Eigen::Vector3d PointAfter(const Twist& twist, const Eigen::Vector3d& point, double time_s,
                           Eigen::Matrix3d* by_point = nullptr,
                           Eigen::Matrix<double, 3, 6>* by_twist = nullptr);
// Returns when a row was read, relative to the middle one.
inline double RowTime(double readout_s, double row, int height) { return readout_s * (row / height - 0.5); }

// Interpolates depths over the image from those of some points: a bilinear grid of inverse depths, which
// tends to their mean where there are no points. Depths are in the points' unit.
class DepthField {
 public:
  // Guessed: the grid, the weight of the mean in points, and the depth where nothing is known.
  static constexpr int kColumns = 17, kRows = 13;
  static constexpr double kMeanWeight = 0.1, kFar = 1e6;
  struct Sample {
    Eigen::Vector2d img;
    double depth;  // along the optical axis
  };
  DepthField(const CameraModel& camera, std::span<const Sample> samples);
  double At(const Eigen::Vector2d& img) const;
  void Scale(double scale);

 private:
  struct Corner {
    std::size_t node;  // the upper left one of an image point's cell
    double fx, fy;     // shares of the cell, from there
  };
  Corner CornerOf(const Eigen::Vector2d& img) const;

  double width_, height_;
  std::vector<double> inverse_;
};

// Converts between where the sensor saw a point and where a global shutter at the frame's time would have.
class RowShift {
 public:
  RowShift(const CameraModel& camera, double readout_s, const Twist& twist, DepthField depths);

  Eigen::Vector2d Global(const Eigen::Vector2d& seen, const Eigen::Vector3d& point_in_cam) const;
  Eigen::Vector2d Seen(const Eigen::Vector2d& global, const Eigen::Vector3d& point_in_cam) const;
  // Does the same with an interpolated depth.
  Eigen::Vector2d Global(const Eigen::Vector2d& seen) const;
  Eigen::Vector2d Seen(const Eigen::Vector2d& global) const;

  // Returns, not normalised, where a global shutter would have seen from the camera what the sensor saw at an
  // image point with this ray.
  Eigen::Vector3d GlobalPoint(const Eigen::Vector2d& seen, const Eigen::Vector3d& ray) const;

  // Converts the shift to another unit of length.
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

// Replaces the shift that was removed from a frame's features; null: no shift, as the sensor saw them.
std::shared_ptr<const FeatureSet> MoveFeatures(const CameraModel& camera, const FeatureSet& features,
                                               const RowShift* from, const RowShift* to);
// Removes a shift from features as the sensor saw them.
std::shared_ptr<const FeatureSet> RemoveRows(const CameraModel& camera, const FeatureSet& detected,
                                             const RowShift& rows);
std::shared_ptr<const Pyramid> WithRows(const Pyramid& pyramid, std::shared_ptr<const RowShift> rows);

struct SeenPoint {
  Eigen::Vector3d point_in_world;
  Eigen::Vector2d seen;
  double sigma_px = 1;
};

// A point and its velocity in the image.
struct PointFlow {
  Eigen::Vector3d point_in_cam;
  Eigen::Vector2d px_s;
};

// Returns the camera's velocity that explains the flow robustly; none where there are too few points.
std::optional<Twist> TwistFromFlow(const CameraModel& camera, std::span<const PointFlow> flow);

struct MotionPrior {
  Twist twist = Twist::Zero();
  Twist sigma = Twist::Ones();
};

struct PoseAndMotion {
  Rigid3 cam_from_world;
  Twist twist;
};

// Returns the pose of the middle row and the velocity about it that explain the observations robustly.
// Returns none where the points do not determine them.
std::optional<PoseAndMotion> RefinePoseAndMotion(const CameraModel& camera, double readout_s,
                                                 std::span<const SeenPoint> points, const Rigid3& initial,
                                                 const MotionPrior& prior);

}  // namespace ulf::tracking
