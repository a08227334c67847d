// A picture source for tracker tests that costs milliseconds: textured planes drawn by homographies, with
// exact poses. World: x right, y down, z towards the wall, metres.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::test {

// What stands in the room.
enum class Furniture {
  kPanels,    // a wall with tilted panels before it
  kWall,      // one wall: flat
  kBox,       // a wall with one box before it
  kTiles,     // a wall of equal tiles with two panels before it
  kCorridor,  // two walls, floor, ceiling and an end, along z
  kRound,     // walls all around the origin, at different distances
  kRepeated,  // four walls around the origin and a floor; one texture repeats itself on all walls
  kMosaic,    // a wall of tiles, some or all of them equal
  kMirror,    // the panels, and a mirror on the wall that shows what is behind the camera
};

class TexturedRoom {
 public:
  struct Options {
    Furniture furniture = Furniture::kPanels;
    unsigned seed = 1;
    double noise = 2;        // standard deviation, grey levels
    double equal_share = 1;  // of kMosaic's tiles; the others look like no other
  };
  // What one frame is taken under.
  struct Moment {
    double gain = 1;
    Eigen::Vector2d blur_px = Eigen::Vector2d::Zero();  // way of the image during the exposure
    bool shadow = false;  // half as bright on one side of an edge that wanders through the picture
    Eigen::Vector3d furniture_shift = Eigen::Vector3d::Zero();  // of all but the wall, metres
    bool moving_half = false;  // a picture that goes up and down hides the left half
  };
  explicit TexturedRoom(const Options& options);

  static CameraModel Camera() { return CameraModel::Pinhole(640, 480, 520); }
  Frame Take(const Rigid3& cam_from_world, std::uint64_t id, const CameraModel& camera = Camera()) const {
    return Take(cam_from_world, id, camera, {});
  }
  Frame Take(const Rigid3& cam_from_world, std::uint64_t id, const CameraModel& camera,
             const Moment& moment) const;

  // As a rolling shutter takes it, in so many bands; `motion`: the pose at a time in frames, the middle
  // row's at `frame`.
  Frame TakeRolling(const std::function<Rigid3(double)>& motion, int frame, double readout_s,
                    const CameraModel& camera, int bands = 16) const;

  // A hand that sways sideways, up and down and forth, looking at the panels; 30 frames a second.
  static Rigid3 HandAt(int frame);
  // Turning about a fixed centre.
  static Rigid3 TurningAt(int frame);
  // Turning about all three axes at up to 60 degrees a second, while the hand sways by 20 cm.
  static Rigid3 TurningAndSwayingAt(double frame);
  // Walking along z, a little unsteady, looking ahead.
  static Rigid3 WalkingAt(int frame);
  // Walking in a circle, looking outwards: once around in kRoundFrames.
  static Rigid3 RoundAt(int frame);
  static constexpr int kRoundFrames = 360;

  static constexpr double kTile = 0.4;  // metres

 private:
  struct Plane {
    Eigen::Vector3d corner, along_x, along_y;  // unit axes
    double pixels_per_m;
    cv::Mat texture;
  };
  void Add(const Eigen::Vector3d& center, const Eigen::Matrix3d& axes, double width, double height,
           double pixels_per_m);
  void Draw(const Plane& plane, const Rigid3& cam_from_world, const CameraModel& camera,
            cv::Mat& image) const;
  void DrawMirror(const Rigid3& cam_from_world, const CameraModel& camera, cv::Mat& image) const;

  Options options_;
  std::vector<Plane> planes_;    // far to near
  std::vector<Plane> mirrored_;  // what the mirror shows, where it shows it: behind the wall
  cv::Mat scrolling_;
};

}  // namespace ulf::test
