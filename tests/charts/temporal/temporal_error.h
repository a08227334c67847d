// How restless a rendering is over time, compared with the true pictures of the same camera path.
//
// e(t) = rendering - truth at a pixel, in display levels of 255. The second difference over time, e(t-1) - 2
// e(t) + e(t+1), is zero for an error that stays or changes evenly, and large for flicker, jumps and popping.
// The motion in the true pictures is no error; a blur, which lacks the details that move, is one. The
// temporal error is the root mean square of the second difference over all pixels and channels, the energy
// its square. An error that moves with the picture counts more the faster it moves, so that only errors along
// one path with one number of pictures can be compared.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace ulf::test {

class TemporalError {
 public:
  // Adds the next picture and the true one, both as DisplayLevels(). `disc`: CV_8U, nonzero where the subject
  // is.
  void Add(const cv::Mat& rendered, const cv::Mat& truth, const cv::Mat& disc);

  // The temporal error on the full image and in the disc; zero before the third picture.
  double FrameRms() const;
  double DiscRms() const;
  // PSNR of all pictures together.
  double PsnrDb() const;
  // On the full image, at each picture except the first and the last.
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

}  // namespace ulf::test
