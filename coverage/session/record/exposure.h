// Keeps the exposure of a capture's pictures equal, because they must differ by viewpoint alone.
//
// If a camera reports that it holds its exposure, or which exposure it takes, the capture waits until the
// exposure and the light on the subject no longer change. A moving camera changes what it sees, too; so
// brightness is compared only between frames from nearly the same direction, a fraction of a second apart.
// For a video, or a webcam that exposes by itself and does not report it, waiting would be useless: its
// frames are recorded as they are, and their light is matched.
//
// Matching measures how bright a photograph is against those recorded before it, from what neighbouring views
// both show. A renderer brings all photographs to one light by this ratio (render/scene/scene), as it does by
// exposure times where they are known. Pictures of 48 pixels across, in linear light, are laid over each
// other by the plane at the subject's depth; the median of their logarithmic ratio is the exposure's part,
// since parallax moves edges both ways. Six neighbours are used, so that errors do not add up over the views.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <map>
#include <opencv2/core.hpp>
#include <optional>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "coverage/session/record/recorded_views.h"

namespace ulf::coverage {

// Watches whether exposure and light no longer change.
class ExposureWatch {
 public:
  // Call it, in order, for every frame with a pose. `held`: whether the camera's automatic exposure is off,
  // none where it does not tell (Device::Held). Returns true when exposure and light have settled, as far as
  // can be told; light is compared where the whole subject is in the picture.
  bool Settled(const Frame& frame, const CameraModel& camera, const Rigid3& cam_from_world,
               const Subject& subject, std::optional<bool> held);

 private:
  struct Seen {
    double time_s = 0;
    double setting = 0;                                   // exposure time x gain; 0: not told
    double light = 0;                                     // mean, linear; 0: not known
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // from the subject
  };
  std::deque<Seen> recent_;
};

// Estimates the relative light of views whose exposure is not known.
class ExposureMatch {
 public:
  // `resumed`: a light field of earlier sessions. Pictures are compared with its views, too, whose
  // photographs are read when they are needed; what cannot be read is not compared.
  explicit ExposureMatch(const LightField& resumed);
  // Returns this picture's light divided by the first view's; 1 for the first. If the picture shares too
  // little with its neighbours, the nearest one's value counts. `depth`: of the subject, world units.
  // `views`: those to compare with, whose poses are of the same state of the world as `cam_from_world`.
  double GainOf(const Image& image, const CameraModel& camera, const Rigid3& cam_from_world, double depth,
                const RecordedViews& views);
  // Notes that the picture of the last GainOf() has become this view.
  void Keep(int id);

 private:
  struct Kept {
    double log_gain = 0;
    cv::Mat light;  // empty: not read yet
  };
  std::optional<double> LogLightRatio(const CameraModel& now_camera, const Rigid3& now_from_world,
                                      const cv::Mat& before, const CameraModel& before_camera,
                                      const Rigid3& before_from_world, double depth) const;

  LightField resumed_;
  std::map<int, Kept> kept_;
  cv::Mat light_;  // of the last GainOf()
  double log_gain_ = 0;
};

}  // namespace ulf::coverage
