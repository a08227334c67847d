#include "coverage/session/record/exposure.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/base/quantile.h"
#include "core/light_field/folder/view_images.h"
#include "coverage/bound/sphere_outline.h"
#include "coverage/bound/subject_light.h"

namespace ulf::coverage {
namespace {

// Guessed.
constexpr std::size_t kMatchNeighbours = 6;  // that a picture is compared with
constexpr std::size_t kMatchMostRead = 2;    // of them from disk, for one picture: that holds up tracking
constexpr double kMatchLeastShared = 0.2;    // of the picture; less overlap says nothing
// Median, of the logarithm; more is no exposure, but a hand before the lens or another lamp.
constexpr double kMatchMostDeviation = 0.3;

// Guessed.
// Frames so far back are compared; longer waits longer after a change.
constexpr double kExposureWindow_s = 0.3;
// The log ratio of exposure time times gain that a settled camera's rounding reaches.
constexpr double kExposureSameSetting = 0.03;
// Log ratio; a third of what one step of an exposure dial changes.
constexpr double kExposureSameLight = 0.08;
// The cosine of two degrees: farther apart other things are seen.
constexpr double kExposureSameDirectionCosine = 0.9994;

constexpr int kSmallWidth = 48;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr int kBlack = 10, kClipped = 247;  // of 255, display-encoded; guessed

// Linear light, NaN where it is clipped or nearly black.
cv::Mat KnownLight(const cv::Mat& pixels, Transfer transfer) {
  cv::Mat linear;
  if (transfer == Transfer::kLinear) {
    pixels.convertTo(linear, CV_32F, 1 / FullScale(pixels.depth()));
    const float low = LinearFromSrgb(kBlack / 255.0f), high = LinearFromSrgb(kClipped / 255.0f);
    for (int y = 0; y < linear.rows; ++y)
      for (float *value = linear.ptr<float>(y), *end = value + linear.cols * linear.channels(); value < end;
           ++value)
        if (*value < low || *value > high) *value = kUnknown;
    return linear;
  }
  cv::Mat encoded, table(1, 256, CV_32F);
  pixels.convertTo(encoded, CV_8U, 255 / FullScale(pixels.depth()));
  for (int i = 0; i < 256; ++i)
    table.at<float>(i) =
        i < kBlack || i > kClipped ? kUnknown : LinearFromSrgb(static_cast<float>(i) / 255.0f);
  cv::LUT(encoded, table, linear);
  return linear;
}

// Interpolated between pixel centres; NaN beside a pixel that is NaN.
float Between(const cv::Mat& light, const Eigen::Vector2d& img) {
  const double u = std::clamp(img.x() - 0.5, 0.0, light.cols - 1.0),
               v = std::clamp(img.y() - 0.5, 0.0, light.rows - 1.0);
  const int x = std::min(static_cast<int>(u), light.cols - 2),
            y = std::min(static_cast<int>(v), light.rows - 2);
  if (x < 0 || y < 0) return light.at<float>(0, 0);
  const auto right = static_cast<float>(u - x), down = static_cast<float>(v - y);
  return (1 - down) * ((1 - right) * light.at<float>(y, x) + right * light.at<float>(y, x + 1)) +
         down * ((1 - right) * light.at<float>(y + 1, x) + right * light.at<float>(y + 1, x + 1));
}

// Returns KnownLight() at few pixels.
cv::Mat SmallLight(const Image& image) {
  constexpr int kFiner =
      4;  // clipped pixels are looked for at so many times the size, before averaging hides them
  const int width = std::min(kSmallWidth, image.width());
  const int height = std::max(1, width * image.height() / image.width());
  cv::Mat reduced;
  cv::resize(image.pixels, reduced, {kFiner * width, kFiner * height}, 0, 0, cv::INTER_AREA);
  const cv::Mat known = KnownLight(reduced, image.transfer);
  const int channels = known.channels();
  cv::Mat light(height, width, CV_32F);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float sum = 0;  // NaN where one of them is
      for (int v = 0; v < kFiner; ++v) {
        const float* value = known.ptr<float>(kFiner * y + v) + kFiner * x * channels;
        for (int i = 0; i < kFiner * channels; ++i) sum += value[i];
      }
      light.at<float>(y, x) = sum / static_cast<float>(kFiner * kFiner * channels);
    }
  return light;
}

bool Differ(double a, double b, double share) { return a > 0 && b > 0 && std::abs(std::log(a / b)) > share; }

}  // namespace

bool ExposureWatch::Settled(const Frame& frame, const CameraModel& camera, const Rigid3& cam_from_world,
                            const Subject& subject, std::optional<bool> held) {
  if (!held || !(*held || frame.exposure_s > 0)) return true;
  Seen now{.time_s = frame.device_time_s, .setting = frame.exposure_s * frame.gain};
  now.direction = (cam_from_world.OriginInSource() - subject.center_in_world).normalized();
  const auto outline = SphereOutline(camera, cam_from_world, subject);
  if (outline && std::ranges::all_of(*outline, [&](const auto& img) { return camera.Contains(img); }))
    if (const auto light = LightInside(frame.image, *outline)) now.light = light->mean_linear;
  std::erase_if(recent_, [&](const Seen& seen) {
    return seen.time_s > now.time_s || now.time_s - seen.time_s > kExposureWindow_s;
  });
  const bool settled = std::ranges::none_of(recent_, [&](const Seen& seen) {
    return Differ(seen.setting, now.setting, kExposureSameSetting) ||
           (seen.direction.dot(now.direction) > kExposureSameDirectionCosine &&
            Differ(seen.light, now.light, kExposureSameLight));
  });
  recent_.push_back(now);
  return settled;
}

// Returns the logarithm of the ratio of this picture's light to `before`'s, on the plane at `depth` before
// this camera; none where they share too little of the plane, or the ratios of its parts do not agree.
std::optional<double> ExposureMatch::LogLightRatio(const CameraModel& now_camera,
                                                   const Rigid3& now_from_world, const cv::Mat& before,
                                                   const CameraModel& before_camera,
                                                   const Rigid3& before_from_world, double depth) const {
  const CameraModel small = now_camera.ScaledTo(light_.cols, light_.rows),
                    small_before = before_camera.ScaledTo(light_.cols, light_.rows);
  const Rigid3 before_from_now = before_from_world * now_from_world.Inverse();
  std::vector<double> ratios;
  for (int y = 0; y < light_.rows; ++y)
    for (int x = 0; x < light_.cols; ++x) {
      const float here = light_.at<float>(y, x);
      if (!(here > 0)) continue;
      const auto ray = small.RayFromImg({x + 0.5, y + 0.5});
      if (!ray || !(ray->z() > 0)) continue;
      const auto img = small_before.ImgFromCam(before_from_now * Eigen::Vector3d(*ray * (depth / ray->z())));
      if (!img || !small_before.Contains(*img)) continue;
      const float there = Between(before, *img);
      if (there > 0) ratios.push_back(std::log(here / there));
    }
  if (static_cast<double>(ratios.size()) < kMatchLeastShared * light_.cols * light_.rows) return std::nullopt;
  const double median = Median(ratios);
  std::vector<double> deviations;
  for (const double ratio : ratios) deviations.push_back(std::abs(ratio - median));
  if (Median(std::move(deviations)) > kMatchMostDeviation) return std::nullopt;
  return median;
}

ExposureMatch::ExposureMatch(const LightField& resumed) : resumed_(resumed) {
  resumed_.points.clear();
  for (const View& view : resumed_.views)
    if (view.exposure_s <= 0 && view.gain > 0) kept_[view.id] = {std::log(view.gain), {}};
}

double ExposureMatch::GainOf(const Image& image, const CameraModel& camera, const Rigid3& cam_from_world,
                             double depth, const RecordedViews& views) {
  light_ = SmallLight(image);
  log_gain_ = 0;
  std::vector<std::pair<double, const RecordedViews::Entry*>> nearest;
  for (const RecordedViews::Entry& view : views.views()) {
    if (!kept_.contains(view.id)) continue;
    const Rigid3 moved = cam_from_world * view.cam_from_world.Inverse();
    nearest.emplace_back(moved.translation.norm() / depth + RotationAngle(moved.rotation), &view);
  }
  const std::size_t count = std::min(kMatchNeighbours, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count), nearest.end());
  nearest.resize(count);
  double sum = 0;
  std::size_t shared = 0, read = 0;
  for (const auto& [apart, view] : nearest) {
    Kept& kept = kept_.at(view->id);
    if (kept.light.empty()) {
      if (++read > kMatchMostRead) continue;
      try {
        const auto recorded = std::ranges::find(resumed_.views, view->id, &View::id);
        kept.light = SmallLight(ReadRecordedImage(resumed_, *recorded));
      } catch (const std::exception&) {  // programs that read the light field report the damage
        continue;
      }
    }
    if (kept.light.size() != light_.size()) continue;
    if (const auto ratio = LogLightRatio(camera, cam_from_world, kept.light, view->CameraOr(camera),
                                         view->cam_from_world, depth)) {
      sum += kept.log_gain + *ratio;
      ++shared;
    }
  }
  if (shared > 0)
    log_gain_ = sum / static_cast<double>(shared);
  else if (!nearest.empty())
    log_gain_ = kept_.at(nearest.front().second->id).log_gain;
  return std::exp(log_gain_);
}

void ExposureMatch::Keep(int id) { kept_[id] = {log_gain_, std::exchange(light_, {})}; }

}  // namespace ulf::coverage
