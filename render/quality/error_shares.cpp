#include "render/quality/error_shares.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ulf::render {
namespace {

// All of these are guessed; they divide the table and change no picture.
constexpr int kShareWindowPx =
    7;  // blur and displacement are judged within this square; light within twice its side
constexpr double kMostLeftShare =
    0.5;  // of the squared error in the window: an explanation leaves at most this much
constexpr int kEdgePx = 4;
constexpr int kThinPx = 8;
constexpr double kJump = 0.02;  // of inverse depth, within kEdgePx: more is an edge

constexpr std::array kBlurSigmasPx{0.6, 0.9, 1.3, 1.9};
constexpr double kDisplacementStepPx = 0.5;  // displacements up to a pixel in each direction

cv::Mat Square(int reach_px) { return cv::Mat::ones(2 * reach_px + 1, 2 * reach_px + 1, CV_8U); }

// Returns CV_8U, 255 near jumps of inverse depth.
cv::Mat DepthEdges(const cv::Mat& inverse_depth) {
  cv::Mat most, least;
  cv::dilate(inverse_depth, most, Square(kEdgePx));
  cv::erode(inverse_depth, least, Square(kEdgePx));
  return most - least > kJump * most;
}

// Returns CV_8U, 255 on and beside near, narrow objects: an opening removes them from the inverse depth.
cv::Mat ThinParts(const cv::Mat& inverse_depth) {
  cv::Mat opened, thin;
  cv::morphologyEx(inverse_depth, opened, cv::MORPH_OPEN, Square(kThinPx / 2));
  cv::dilate(inverse_depth - opened > kJump * inverse_depth, thin, Square(kEdgePx));
  return thin;
}

// Compares the photograph's explanations of the rendering with the actual error.
class Explanations {
 public:
  Explanations(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid)
      : least_left_(rendered.size(), CV_32F, cv::Scalar(kMostLeftShare)),
        kinds_(rendered.size(), CV_8U, cv::Scalar(static_cast<int>(ErrorKind::kOther))) {
    rendered.convertTo(rendered_, CV_32F);
    photograph.convertTo(photograph_, CV_32F);
    valid.convertTo(valid_, CV_32F, 1 / 255.0);
    error_ = MeanSquare(rendered_ - photograph_, kShareWindowPx);
    for (const double sigma : kBlurSigmasPx) {
      cv::Mat blurred;
      cv::GaussianBlur(photograph_, blurred, {}, sigma);
      Take(ErrorKind::kBlurred, MeanSquare(rendered_ - blurred, kShareWindowPx), error_);
    }
    for (double y = -1; y <= 1; y += kDisplacementStepPx)
      for (double x = -1; x <= 1; x += kDisplacementStepPx)
        if (x != 0 || y != 0)
          Take(ErrorKind::kDisplaced, MeanSquare(rendered_ - Displaced(x, y), kShareWindowPx), error_);
    ExplainByLight();
  }

  // Returns CV_8U, of ErrorKind.
  const cv::Mat& Kinds() const { return kinds_; }

 private:
  // Returns CV_32F: the mean over a square of the squares, summed over the channels, of valid pixels.
  cv::Mat MeanSquare(const cv::Mat& difference, int side_px) const {
    std::vector<cv::Mat> channels;
    cv::split(difference.mul(difference), channels);
    cv::Mat mean;
    cv::blur((channels[0] + channels[1] + channels[2]).mul(valid_), mean, {side_px, side_px});
    return mean;
  }

  cv::Mat Displaced(double x, double y) const {
    const cv::Matx23d shift(1, 0, x, 0, 1, y);
    cv::Mat displaced;
    cv::warpAffine(photograph_, displaced, shift, photograph_.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    return displaced;
  }

  // A constant offset of each channel over the window leaves the variance of the difference.
  void ExplainByLight() {
    const int side_px = 2 * kShareWindowPx;
    const cv::Mat difference = rendered_ - photograph_;
    std::vector<cv::Mat> channels;
    cv::split(difference, channels);
    cv::Mat weight, explained = cv::Mat::zeros(difference.size(), CV_32F);
    cv::blur(valid_, weight, {side_px, side_px});
    for (const cv::Mat& channel : channels) {
      cv::Mat sum;
      cv::blur(channel.mul(valid_), sum, {side_px, side_px});
      explained += sum.mul(sum) / cv::max(weight, 1e-6F);
    }
    const cv::Mat error = MeanSquare(difference, side_px);
    Take(ErrorKind::kLight, error - explained, error);
  }

  void Take(ErrorKind kind, const cv::Mat& left, const cv::Mat& error) {
    const cv::Mat share = left / cv::max(error, 1e-6F);
    const cv::Mat better = share < least_left_;
    share.copyTo(least_left_, better);
    kinds_.setTo(static_cast<int>(kind), better);
  }
  cv::Mat rendered_, photograph_, valid_, error_, least_left_, kinds_;
};

}  // namespace

ErrorShares ShareErrors(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid,
                        const cv::Mat& depth, const cv::Mat& confidence) {
  cv::Mat kinds = Explanations(rendered, photograph, valid).Kinds().clone();
  const cv::Mat inverse_depth = 1 / depth;
  kinds.setTo(static_cast<int>(ErrorKind::kEdge), DepthEdges(inverse_depth));
  kinds.setTo(static_cast<int>(ErrorKind::kThin), ThinParts(inverse_depth));
  kinds.setTo(static_cast<int>(ErrorKind::kUnseen), confidence <= 0);

  ErrorShares shares;
  std::vector<double> errors;
  double all = 0;
  for (int y = 0; y < rendered.rows; ++y)
    for (int x = 0; x < rendered.cols; ++x) {
      if (!valid.at<std::uint8_t>(y, x)) continue;
      const cv::Vec3d off =
          cv::Vec3d(rendered.at<cv::Vec3b>(y, x)) - cv::Vec3d(photograph.at<cv::Vec3b>(y, x));
      const double error = off.dot(off);
      const std::size_t kind = kinds.at<std::uint8_t>(y, x);
      shares.of_error[kind] += error;
      shares.of_pixels[kind] += 1;
      errors.push_back(error);
      all += error;
    }
  if (errors.empty()) return shares;
  const std::size_t worst = std::max<std::size_t>(1, errors.size() / 100);
  std::nth_element(errors.begin(), errors.end() - static_cast<std::ptrdiff_t>(worst), errors.end());
  for (std::size_t i = errors.size() - worst; i < errors.size(); ++i) shares.of_worst_hundredth += errors[i];
  for (double& share : shares.of_pixels) share /= static_cast<double>(errors.size());
  if (!(all > 0)) return shares;
  for (double& share : shares.of_error) share /= all;
  shares.of_worst_hundredth /= all;
  return shares;
}

}  // namespace ulf::render
