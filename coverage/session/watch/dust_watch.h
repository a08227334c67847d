// Detects dust on the lens: dark spots that stay in place while the scene moves across the picture.
//
// A cell of the picture is compared again when the scene in it has moved away (by the tracks nearby,
// picture_tracks.h). Its content is compared with the same piece of the scene in the earlier picture, where
// that was elsewhere: the scene cancels out, a spot remains. Spots are small, round and present in almost
// every comparison.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "coverage/session/watch/picture_tracks.h"

namespace ulf::coverage {

struct DustSpot {
  cv::Point2f at;       // share of the picture's width and height
  double kept_off = 0;  // share of the light that the spot keeps off
};

class DustWatch {
 public:
  void Update(const PicturePair& pair);  // call it for each pair, in order
  // Returns the spots that have been there for three seconds or longer.
  const std::vector<DustSpot>& spots() const { return spots_; }

 private:
  static constexpr int kColumns = 16, kRows = 12;
  // A cell of the picture: the picture at its last look, and how far the scene has moved there since.
  struct Cell {
    cv::Mat log_light, contrast;
    cv::Point2f moved;
    int looks = 0;
  };
  cv::Rect Area(int row, int column) const;
  void CompareCell(const cv::Rect& area, const cv::Mat& log_light, const cv::Mat& contrast, Cell& cell);
  void LookForSpots();

  // Over the looks: of each pixel's difference of contrast the sum and that of squares; how
  // often it is darker.
  cv::Mat sum_, sum2_, darker_;
  std::vector<Cell> cells_;
  double looked_s_ = 0;
  struct Candidate {
    DustSpot spot;
    double since_s = 0;
  };
  std::vector<Candidate> candidates_;
  std::vector<DustSpot> spots_;
};

}  // namespace ulf::coverage
