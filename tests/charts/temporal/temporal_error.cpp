#include "tests/charts/temporal/temporal_error.h"

#include <algorithm>
#include <cmath>

#include "core/image/image.h"

namespace ulf::test {

cv::Mat DisplayLevels(const cv::Mat& linear) {
  cv::Mat levels(linear.size(), CV_32FC3);
  for (int y = 0; y < linear.rows; ++y) {
    const float* in = linear.ptr<float>(y);
    float* out = levels.ptr<float>(y);
    for (int x = 0; x < 3 * linear.cols; ++x) out[x] = 255 * SrgbFromLinear(std::clamp(in[x], 0.0f, 1.0f));
  }
  return levels;
}

void TemporalError::Sum::Add(const cv::Mat& difference, const cv::Mat& mask) {
  for (int y = 0; y < difference.rows; ++y)
    for (int x = 0; x < difference.cols; ++x) {
      if (!mask.empty() && mask.at<std::uint8_t>(y, x) == 0) continue;
      const cv::Vec3f& d = difference.at<cv::Vec3f>(y, x);
      squares += d.dot(d);
      count += 3;
    }
}

double TemporalError::Sum::Rms() const { return count > 0 ? std::sqrt(squares / count) : 0; }

void TemporalError::Add(const cv::Mat& rendered, const cv::Mat& truth, const cv::Mat& disc) {
  const cv::Mat error = rendered - truth;
  pictures_.Add(error, {});
  if (errors_.size() == 2) {
    const cv::Mat second = errors_[0] - 2 * errors_[1] + error;
    Sum now;
    now.Add(second, {});
    over_time_.push_back(now.Rms());
    frame_.squares += now.squares;
    frame_.count += now.count;
    disc_.Add(second, last_disc_);
    errors_.erase(errors_.begin());
  }
  errors_.push_back(error);
  last_disc_ = disc;
}

double TemporalError::FrameRms() const { return frame_.Rms(); }
double TemporalError::DiscRms() const { return disc_.Rms(); }
double TemporalError::PsnrDb() const { return 20 * std::log10(255 / std::max(pictures_.Rms(), 1e-3)); }

}  // namespace ulf::test
