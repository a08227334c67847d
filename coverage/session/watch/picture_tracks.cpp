#include "coverage/session/watch/picture_tracks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "core/base/quantile.h"

namespace ulf::coverage {
namespace {

// Guessed.
constexpr int kTracksMostWidth = 480;  // of the reduced pictures, which are a whole number of times smaller
constexpr double kTracksApart_px = 9;
constexpr std::size_t kTracksMost = 150, kTracksFewest = 100;  // points; fewer are filled up
constexpr double kTracksLongest_s = 0.5;                       // between two pictures that are compared

constexpr int kWindow = 15, kLevels = 3;
constexpr int kPatch = 4;  // pixels from a point that its detail is taken from
// Beyond these display-encoded values light is clipped, or noise and black level dominate. Guessed.
constexpr float kDarkest = 0.08f, kBrightest = 0.96f;

const cv::Mat& LogLightTable() {
  static const cv::Mat table = [] {
    cv::Mat values(1, 256, CV_32F);
    for (int i = 0; i < 256; ++i)
      values.at<float>(i) = std::log(std::max(LinearFromSrgb(static_cast<float>(i) / 255.0f), 1e-4f));
    return values;
  }();
  return table;
}

float Between(const cv::Mat& values, cv::Point2f at) {
  const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);  // inside, see IsInside()
  const float right = at.x - static_cast<float>(x), down = at.y - static_cast<float>(y);
  const float *upper = values.ptr<float>(y) + x, *lower = values.ptr<float>(y + 1) + x;
  return (1 - down) * ((1 - right) * upper[0] + right * upper[1]) +
         down * ((1 - right) * lower[0] + right * lower[1]);
}

bool IsKnown(float log_light) {
  static const float low = std::log(LinearFromSrgb(kDarkest)), high = std::log(LinearFromSrgb(kBrightest));
  return log_light > low && log_light < high;
}

// Returns the energy of `detail` around a point across a direction.
float EnergyAcross(const cv::Mat& detail, cv::Point2f at, cv::Point2f along) {
  const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y));
  const cv::Point2f across(-along.y, along.x);
  float sum = 0;
  for (int v = y - kPatch; v <= y + kPatch; ++v)
    for (int u = x - kPatch; u <= x + kPatch; ++u) {
      const float slope = across.x * (detail.at<float>(v, u + 1) - detail.at<float>(v, u - 1)) +
                          across.y * (detail.at<float>(v + 1, u) - detail.at<float>(v - 1, u));
      sum += slope * slope;
    }
  return sum;
}

bool IsInside(const cv::Mat& picture, cv::Point2f at) {
  constexpr float kMargin = kPatch + 2;
  return at.x >= kMargin && at.y >= kMargin && at.x < static_cast<float>(picture.cols) - kMargin &&
         at.y < static_cast<float>(picture.rows) - kMargin;
}

}  // namespace

PictureTracks::Reduced PictureTracks::Reduce(double time_s, const Image& image) const {
  const cv::Mat grey = GrayForTracking(image);
  const int times = (grey.cols + kTracksMostWidth - 1) / kTracksMostWidth;
  cv::Mat small, followed;
  cv::resize(grey, small, {std::max(1, grey.cols / times), std::max(1, grey.rows / times)}, 0, 0,
             cv::INTER_AREA);
  Reduced reduced{.time_s = time_s, .log_light = {}, .smooth = {}, .detail = {}, .pyramid = {}};
  cv::LUT(small, LogLightTable(), reduced.log_light);
  constexpr double kSmooth = 3, kFine = 1, kSlow = 7;
  cv::GaussianBlur(reduced.log_light, reduced.smooth, {}, kSmooth);
  cv::Mat slow;
  cv::GaussianBlur(reduced.log_light, slow, {}, kFine);
  reduced.detail = reduced.log_light - slow;
  cv::blur(slow, slow, {static_cast<int>(2 * kSlow) + 1, static_cast<int>(2 * kSlow) + 1});
  constexpr double kLevelsPerLog = 80;
  cv::Mat(reduced.log_light - slow).convertTo(followed, CV_8U, kLevelsPerLog, 128);
  cv::buildOpticalFlowPyramid(followed, reduced.pyramid, {kWindow, kWindow}, kLevels);
  return reduced;
}

void PictureTracks::FillUp() {
  if (points_.size() >= kTracksFewest) return;
  cv::Mat mask(last_->log_light.size(), CV_8U, cv::Scalar(255));
  for (const cv::Point2f& point : points_)
    cv::circle(mask, point, static_cast<int>(kTracksApart_px), 0, cv::FILLED);
  std::vector<cv::Point2f> corners;
  constexpr double kWeakest = 0.02;  // of the strongest
  cv::goodFeaturesToTrack(last_->pyramid.front(), corners, static_cast<int>(kTracksMost - points_.size()),
                          kWeakest, kTracksApart_px, mask);
  points_.insert(points_.end(), corners.begin(), corners.end());
}

std::optional<PicturePair> PictureTracks::Update(double time_s, const Image& image) {
  if (image.empty()) return std::nullopt;
  Reduced now = Reduce(time_s, image);
  const std::optional<Reduced> before = std::exchange(last_, now);
  const bool follows = before && before->log_light.size() == now.log_light.size() &&
                       time_s > before->time_s && time_s - before->time_s <= kTracksLongest_s;
  if (!follows) points_.clear();
  PicturePair pair{.before_s = before ? before->time_s : 0,
                   .now_s = time_s,
                   .log_light = now.log_light,
                   .tracks = {},
                   .motion = {}};
  if (follows && !points_.empty()) {
    std::vector<cv::Point2f> there;
    std::vector<std::uint8_t> found;
    std::vector<float> errors;
    cv::calcOpticalFlowPyrLK(before->pyramid, now.pyramid, points_, there, found, errors, {kWindow, kWindow},
                             kLevels);
    constexpr float kMostError = 16;  // mean difference of the pixels around, levels; guessed
    std::vector<double> right, down;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!found[i] || errors[i] > kMostError || !IsInside(now.log_light, there[i]) ||
          !IsInside(now.log_light, points_[i]))
        continue;
      pair.tracks.push_back({.before = points_[i], .now = there[i], .log_light = {}});
      right.push_back(there[i].x - points_[i].x);
      down.push_back(there[i].y - points_[i].y);
    }
    pair.motion = {static_cast<float>(Median(std::move(right))), static_cast<float>(Median(std::move(down)))};
    for (PictureTrack& track : pair.tracks) {
      const float light_before = Between(before->smooth, track.before),
                  light_now = Between(now.smooth, track.now);
      if (IsKnown(light_before) && IsKnown(light_now)) track.log_light = light_now - light_before;
      const cv::Point2f moved = track.now - track.before;
      const float length = std::hypot(moved.x, moved.y);
      const cv::Point2f along = length > 0 ? moved / length : cv::Point2f(1, 0);
      constexpr float kLeast = 1e-4f;
      const float detail_before = EnergyAcross(before->detail, track.before, along) + kLeast,
                  detail_now = EnergyAcross(now.detail, track.now, along) + kLeast;
      track.log_detail = std::log(detail_now / detail_before);
      track.detail = std::sqrt(detail_before * detail_now);
    }
    points_.clear();
    for (const PictureTrack& track : pair.tracks) points_.push_back(track.now);
  }
  FillUp();
  if (!follows) return std::nullopt;
  return pair;
}

}  // namespace ulf::coverage
