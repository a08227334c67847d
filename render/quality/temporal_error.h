// How restless a rendering is over time, against the truth of the same camera path.
//
// e(t) = rendering - truth at a pixel, in display levels of 255. Its second difference over time,
// e(t-1) - 2 e(t) + e(t+1), is zero for an error that stays or changes evenly, large for one that comes and
// goes: flicker, jumps, popping. Truth's own motion is no error, and a blur, which lacks detail that moves,
// is one. The temporal error is the second difference's root mean square, over all pixels and channels; its
// square is the energy. An error that moves with the picture counts by how fast it moves, so errors can be
// compared along one path, at one number of pictures.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace ulf::render {

class TemporalError {
 public:
  // The next picture and its truth: DisplayLevels(). `disc`: where the subject is, CV_8U.
  void Add(const cv::Mat& rendered, const cv::Mat& truth, const cv::Mat& disc);

  // Zero before the third picture.
  double FrameRms() const;
  double DiscRms() const;
  // Of the pictures themselves, in dB.
  double PsnrDb() const;
  // Over the frame, for each picture but the first and the last.
  const std::vector<double>& over_time() const { return over_time_; }

 private:
  struct Sum {
    double squares = 0, count = 0;
    void Add(const cv::Mat& difference, const cv::Mat& mask);
    double Rms() const;
  };
  std::vector<cv::Mat> errors_;  // of the last two pictures
  cv::Mat last_disc_;
  Sum frame_, disc_, pictures_;
  std::vector<double> over_time_;
};

// Display levels, 0 to 255, in float: CV_32FC3.
cv::Mat DisplayLevels(const cv::Mat& linear);

}  // namespace ulf::render
