#include "coverage/session/light_and_focus.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/quantile.h"
#include "coverage/bound/sphere_outline.h"

namespace ulf::coverage {
namespace {

std::vector<double> Magnitudes(const cv::Mat& values) {
  std::vector<double> magnitudes;
  magnitudes.reserve(values.total());
  for (int y = 0; y < values.rows; ++y)
    for (const float *v = values.ptr<float>(y), *end = v + values.cols; v < end; ++v)
      magnitudes.push_back(std::abs(*v));
  return magnitudes;
}

struct Octaves {
  double fine = 0, coarse = 0;  // grey values
};

Octaves StrongestEdges(const cv::Mat& grey8, double strongest) {
  cv::Mat grey, smooth, smoother;
  grey8.convertTo(grey, CV_32F);
  cv::GaussianBlur(grey, smooth, {0, 0}, 1);
  cv::GaussianBlur(grey, smoother, {0, 0}, 2);
  return {Quantile(Magnitudes(grey - smooth), 1 - strongest),
          Quantile(Magnitudes(smooth - smoother), 1 - strongest)};
}

// Where the subject is while nobody has placed it.
std::vector<Eigen::Vector2d> Middle(const Image& image) {
  const double width = image.width(), height = image.height();
  return {{0.25 * width, 0.25 * height},
          {0.75 * width, 0.25 * height},
          {0.75 * width, 0.75 * height},
          {0.25 * width, 0.75 * height}};
}

cv::Rect BoxOf(const std::vector<Eigen::Vector2d>& outline) {
  Eigen::Vector2d low = outline[0], high = outline[0];
  for (const Eigen::Vector2d& corner : outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  return {cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
          cv::Point(static_cast<int>(high.x()), static_cast<int>(high.y()))};
}

}  // namespace

std::optional<double> FineDetail(const cv::Mat& grey8, const cv::Rect& area,
                                 const FineDetailOptions& options) {
  constexpr int kLeastPx = 32;
  cv::Rect box = area & cv::Rect({0, 0}, grey8.size());
  const int cut_x = std::max(0, box.width - options.most_px),
            cut_y = std::max(0, box.height - options.most_px);
  box = {box.x + cut_x / 2, box.y + cut_y / 2, box.width - cut_x, box.height - cut_y};
  if (box.width < kLeastPx || box.height < kLeastPx) return std::nullopt;
  cv::Mat reduced = grey8(box);
  for (int times = 0; times < options.times_halved; ++times) {
    if (std::min(reduced.cols, reduced.rows) < kLeastPx) break;
    cv::resize(reduced, reduced, {}, 0.5, 0.5, cv::INTER_AREA);
    const Octaves octaves = StrongestEdges(reduced, options.strongest);
    if (octaves.coarse >= options.least_texture) return octaves.fine / octaves.coarse;
  }
  return std::nullopt;
}

const PictureFinding& LightAndFocusCheck::After(double time_s, const Image& image, const CameraModel& camera,
                                                const std::optional<Rigid3>& cam_from_world,
                                                const std::optional<Subject>& subject) {
  if (image.empty()) return finding_;
  if (!looked_.empty() && time_s >= looked_.back().time_s &&
      time_s - looked_.back().time_s < options_.every_s)
    return finding_;
  std::optional<std::vector<Eigen::Vector2d>> outline;
  if (subject && cam_from_world) outline = SphereOutline(camera, *cam_from_world, *subject);
  const std::vector<Eigen::Vector2d> shape = outline.value_or(Middle(image));
  finding_.light = LightInside(image, shape);
  looked_.push_back({time_s, FineDetail(GrayForTracking(image), BoxOf(shape))});
  while (time_s - looked_.front().time_s > options_.best_of_s || looked_.front().time_s > time_s)
    looked_.pop_front();
  finding_.fine_detail.reset();
  if (time_s - looked_.front().time_s < 0.5 * options_.best_of_s) return finding_;
  for (const Looked& look : looked_)
    if (look.fine_detail)
      finding_.fine_detail = std::max(finding_.fine_detail.value_or(0), *look.fine_detail);
  return finding_;
}

}  // namespace ulf::coverage
