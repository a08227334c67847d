// Whether views follow one another in steps along a camera path, compared with the true pictures.
//
// temporal_error.h compares pixels, so that an error counts that moves with the picture: a blur, and the
// rough edge of a geometry. Here e(t) = rendering - truth is followed at points of the scene, which the true
// depth finds in the pictures before and after, and its second difference e(t-1) - 2 e(t) + e(t+1) is taken
// there. A blur stays with its point, and a view that fades in and out changes the error smoothly: both are
// nothing or little. A view that replaces another one jumps, and linear weights have a kink at each
// viewpoint. The step error is the root mean square over all points and channels, in display levels of 255.
//
// Pictures are sampled anew from picture to picture, which moves errors within a pixel; therefore e is
// smoothed first. Points that one of the three pictures does not see are left out. As with the temporal error
// only pictures of one path with one number of pictures can be compared: a step is the same however many
// there are, a smooth change is spread over them.
#pragma once

#include <deque>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::test {

// A true picture's camera, and the depth along its optical axis: CV_32F.
struct TrueDepth {
  CameraModel camera;
  Rigid3 cam_from_world;
  cv::Mat depth;
};

// Where the points seen at the pixels of `here` lie in the picture `there`: CV_32FC2, (x, y); (-1, -1) where
// it does not see them.
cv::Mat PlacesIn(const TrueDepth& here, const TrueDepth& there);

class StepError {
 public:
  // Adds the next picture and the true one, both as DisplayLevels(). `disc`: as of TemporalError.
  void Add(const cv::Mat& rendered, const cv::Mat& truth, const TrueDepth& depth, const cv::Mat& disc);

  // On the full image and in the disc; zero before the third picture.
  double FrameRms() const;
  double DiscRms() const;
  const std::vector<double>& over_time() const { return over_time_; }

 private:
  struct Picture {
    cv::Mat error;  // smoothed
    TrueDepth depth;
    cv::Mat disc;
  };
  std::deque<Picture> last_;  // up to three
  double squares_ = 0, disc_squares_ = 0;
  long count_ = 0, disc_count_ = 0;
  std::vector<double> over_time_;
};

}  // namespace ulf::test
