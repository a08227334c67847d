// Dust on the lens: dark spots that stay where they are in the picture while the scene moves on beneath them.
//
// A place of the picture is looked at again when what it showed has moved away (by the points that are followed nearby,
// picture_tracks.h), so that each look shows another piece of the scene. Over the looks, what the scene has there that
// is darker or brighter than its surroundings averages out; a spot stays.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "coverage/session/watch/picture_tracks.h"

namespace ulf::coverage {

struct DustSpot {
  cv::Point2f at;       // share of the picture's width and height
  double kept_off = 0;  // share of the light
};

class DustWatch {
 public:
  // Settled on simulated scenes (docs/mistakes.md).
  struct Options {
    double moved = 0.04;  // share of the picture's width: what a place showed has moved away
    int fewest_looks = 15;
    double every_s = 1;  // spots are looked for so often
    double least_kept_off = 0.04;
    double sigmas = 7;   // of the mean over the looks
    double round = 0.4;  // least curvature over the greatest: less is the edge of something
  };
  DustWatch() = default;
  explicit DustWatch(const Options& options) : options_(options) {}

  void After(const PicturePair& pair);
  const std::vector<DustSpot>& spots() const { return spots_; }

 private:
  static constexpr int kColumns = 16, kRows = 12;
  void LookAt(const cv::Rect& cell, const cv::Mat& contrast);
  void LookForSpots();

  Options options_;
  cv::Mat sum_, sum2_;              // over the looks, of each pixel's contrast
  std::vector<int> looks_;          // of each cell
  std::vector<cv::Point2f> moved_;  // of each cell, since its last look
  double looked_s_ = 0;
  std::vector<DustSpot> spots_;
};

}  // namespace ulf::coverage
