// Tracks points from one live picture to the next by their pixels alone, and measures how bright and how
// sharp they are in both. The watches on light, focus and dust use these measurements, which need no poses.
//
// Points are tracked in reduced pictures (Lucas and Kanade, in pyramids) by the logarithm of their light
// without its slow changes over the picture, so that neither exposure nor bands of light move a point. A
// moving camera blurs along the motion, a lens out of focus also across it: detail is compared across.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/image/image.h"

namespace ulf::coverage {

struct PictureTrack {
  cv::Point2f before, now;  // pixels of the reduced pictures
  // Natural logarithm of the light now over the light before; none where either is clipped or nearly black.
  std::optional<float> log_light;
  // The same of the energy of fine detail across the motion, and the geometric mean of that energy in both.
  float log_detail = 0, detail = 0;
};

struct PicturePair {
  double before_s = 0, now_s = 0;  // the times that Update() got
  // The picture now, CV_32F, reduced to 480 pixels of width or less: natural logarithm of linear light, 0 at
  // full scale.
  cv::Mat log_light;
  std::vector<PictureTrack> tracks;
  cv::Point2f motion;  // the tracks' median, reduced pixels; 0 without tracks
};

class PictureTracks {
 public:
  // Call it after each live frame, with the device's time. Returns none for the first frame, and for one more
  // than half a second after the last.
  std::optional<PicturePair> Update(double time_s, const Image& image);

 private:
  struct Reduced {
    double time_s = 0;
    cv::Mat log_light, smooth, detail;  // CV_32F
    std::vector<cv::Mat> pyramid;
  };
  Reduced Reduce(double time_s, const Image& image) const;
  void FillUp();

  std::optional<Reduced> last_;
  std::vector<cv::Point2f> points_;  // in the last picture
};

}  // namespace ulf::coverage
