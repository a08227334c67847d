#include "tests/charts/temporal/step_error.h"

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/at.h"
#include "core/geometry/pinhole.h"

namespace ulf::test {
namespace {

// Of the Gaussian that smooths errors, in pixels: over it sampling anew, which differs by a pixel's
// structure, is a small part of what is left, and ghosts of other views are many pixels away. Chosen by hand.
constexpr double kSmoothingPx = 1.5;
// A point is hidden where the other picture is nearer by more than this share of its depth. Guessed.
constexpr double kHiddenShare = 0.01;

// Nearer to the picture's edge what is beyond it would have to be guessed.
constexpr int kMarginPx = 5;

bool IsInside(const cv::Vec2f& place, const cv::Size& size) {
  return place[0] >= kMarginPx && place[1] >= kMarginPx &&
         place[0] < static_cast<float>(size.width - kMarginPx) &&
         place[1] < static_cast<float>(size.height - kMarginPx);
}

// Catmull and Rom's spline, exact for quadratic functions; OpenCV's cubic interpolation is not even exact for
// linear ones, which would pass for errors that change.
std::array<float, 4> CubicTaps(float x) {
  const float x2 = x * x, x3 = x2 * x;
  return {0.5f * (-x3 + 2 * x2 - x), 0.5f * (3 * x3 - 5 * x2 + 2), 0.5f * (-3 * x3 + 4 * x2 + x),
          0.5f * (x3 - x2)};
}

cv::Vec3f ErrorAt(const cv::Mat& error, const cv::Vec2f& place) {
  const int left = static_cast<int>(place[0]), top = static_cast<int>(place[1]);
  const auto across = CubicTaps(place[0] - static_cast<float>(left));
  const auto down = CubicTaps(place[1] - static_cast<float>(top));
  cv::Vec3f sum(0, 0, 0);
  for (int j = 0; j < 4; ++j) {
    const cv::Vec3f* row = error.ptr<cv::Vec3f>(top + j - 1) + left - 1;
    sum += down[At(j)] * (across[0] * row[0] + across[1] * row[1] + across[2] * row[2] + across[3] * row[3]);
  }
  return sum;
}

double Rms(double squares, long count) {
  return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0;
}

}  // namespace

cv::Mat PlacesIn(const TrueDepth& here, const TrueDepth& there) {
  cv::Mat places(here.depth.size(), CV_32FC2);
  const Rigid3 there_from_here = there.cam_from_world * here.cam_from_world.Inverse();
  const Eigen::Matrix3d rotation = there_from_here.RotationMatrix();
  for (int y = 0; y < places.rows; ++y)
    for (int x = 0; x < places.cols; ++x) {
      cv::Vec2f& place = places.at<cv::Vec2f>(y, x);
      place = {-1, -1};
      const double depth = here.depth.at<float>(y, x);
      const Eigen::Vector3d point =
          rotation * (PinholeRay(here.camera, x, y) * depth) + there_from_here.translation;
      if (!(depth > 0) || !(point.z() > 0)) continue;
      const Eigen::Vector2d img = PinholeImg(there.camera, point) - Eigen::Vector2d(0.5, 0.5);
      const int column = static_cast<int>(std::lround(img.x())), row = static_cast<int>(std::lround(img.y()));
      if (!(img.x() >= 0 && img.y() >= 0) || column >= there.depth.cols || row >= there.depth.rows) continue;
      if (there.depth.at<float>(row, column) < (1 - kHiddenShare) * point.z()) continue;
      place = {static_cast<float>(img.x()), static_cast<float>(img.y())};
    }
  return places;
}

void StepError::Add(const cv::Mat& rendered, const cv::Mat& truth, const TrueDepth& depth,
                    const cv::Mat& disc) {
  Picture& added = last_.emplace_back();
  cv::GaussianBlur(rendered - truth, added.error, {}, kSmoothingPx);
  added.depth = depth;
  added.disc = disc;
  if (last_.size() < 3) return;
  const Picture& here = last_[1];
  const Picture &before = last_[0], &after = last_[2];
  const cv::Mat places_before = PlacesIn(here.depth, before.depth);
  const cv::Mat places_after = PlacesIn(here.depth, after.depth);
  double squares = 0;
  long count = 0;
  const cv::Size size = here.error.size();
  for (int y = kMarginPx; y < size.height - kMarginPx; ++y)
    for (int x = kMarginPx; x < size.width - kMarginPx; ++x) {
      const cv::Vec2f& was = places_before.at<cv::Vec2f>(y, x);
      const cv::Vec2f& will_be = places_after.at<cv::Vec2f>(y, x);
      if (!IsInside(was, size) || !IsInside(will_be, size)) continue;
      const cv::Vec3f second =
          ErrorAt(before.error, was) - 2 * here.error.at<cv::Vec3f>(y, x) + ErrorAt(after.error, will_be);
      const double square = second.dot(second);
      squares += square;
      count += 3;
      if (here.disc.empty() || here.disc.at<std::uint8_t>(y, x) == 0) continue;
      disc_squares_ += square;
      disc_count_ += 3;
    }
  over_time_.push_back(Rms(squares, count));
  squares_ += squares;
  count_ += count;
  last_.pop_front();
}

double StepError::FrameRms() const { return Rms(squares_, count_); }
double StepError::DiscRms() const { return Rms(disc_squares_, disc_count_); }

}  // namespace ulf::test
