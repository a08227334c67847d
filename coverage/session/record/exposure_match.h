// How bright a photograph is against those recorded before it, where nobody tells its exposure (a video, a
// webcam that exposes by itself): from what neighbouring views both show. A renderer brings all photographs
// to one light by it (render/scene/scene), as it does by exposure times where these are told.
//
// Pictures of 48 pixels across, in linear light, are laid over each other by the plane at the depth of what
// is looked at; the median of their logarithmic ratio is what exposure does, since parallax moves edges both
// ways. Six neighbours, not one, so that errors do not add up along the way.
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <span>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/image.h"
#include "core/light_field/light_field.h"
#include "coverage/session/record/held_views.h"

namespace ulf::coverage {

// Linear light, few pixels of it; NaN where it is clipped or nearly black.
cv::Mat SmallLight(const Image& image);

// The logarithm of `now`'s light over `before`'s where both see the plane at `depth` before `now`; none where
// they share less than a fifth of the picture, or their parts do not agree.
std::optional<double> LogLightRatio(const cv::Mat& now, const Rigid3& now_from_world, const cv::Mat& before,
                                    const Rigid3& before_from_world, const CameraModel& camera, double depth);

class ExposureMatch {
 public:
  // `resumed`: its views are compared with, too; their photographs are read when they are needed.
  explicit ExposureMatch(const LightField& resumed);
  // What to multiply the first view's light by to come to this picture's; 1 for the first.
  // `views`: where those that it is compared with stand, in the world that `cam_from_world` and `depth` are
  // of. A map moves them all when it closes a loop or changes its scale.
  double GainOf(const Image& image, const CameraModel& camera, const Rigid3& cam_from_world, double depth,
                const HeldViews& views);
  // The picture that was asked about last has become this view.
  void Keep(int id);

 private:
  struct Kept {
    double log_gain = 0;
    cv::Mat light;  // empty: not read yet
  };
  LightField resumed_;
  std::map<int, Kept> kept_;
  cv::Mat light_;
  double log_gain_ = 0;
};

}  // namespace ulf::coverage
