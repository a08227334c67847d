#include "tracking/features/succession.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/features/features.h"
#include "tracking/features/matching.h"

namespace ulf::tracking {
namespace {

constexpr double kLongerSide_px = 640;
constexpr int kCorners = 500, kFewCorners = 60;
constexpr double kNearShare = 0.1;  // of the longer side
// The share of the first picture's corners that frames find again, settled on drawn rooms.
constexpr double kFoundAgainShare = 0.1;

}  // namespace

struct Succession::State {
  std::optional<FeatureExtractor> extractor;
  cv::Size size;       // of the pictures as they come
  FeatureSet corners;  // of the last picture
};

Succession::Succession() : state_(std::make_unique<State>()) {}
Succession::~Succession() = default;

void Succession::Add(const cv::Mat& gray) {
  const double scale = std::min(1.0, kLongerSide_px / std::max(gray.cols, gray.rows));
  const cv::Size size(static_cast<int>(std::lround(scale * gray.cols)),
                      static_cast<int>(std::lround(scale * gray.rows)));
  cv::Mat small;
  cv::resize(gray, small, size, 0, 0, cv::INTER_AREA);
  const bool is_first = !state_->extractor;
  const bool is_other_size = state_->size != gray.size();
  if (is_other_size) state_->extractor.emplace(CameraModel::Pinhole(size.width, size.height, size.width));
  state_->size = gray.size();
  FeatureSet corners = state_->extractor->Extract(BuildPyramid(small), kCorners);
  std::swap(corners, state_->corners);  // now those of the picture before
  if (is_first || std::min(corners.size(), state_->corners.size()) < kFewCorners) return;
  if (is_other_size) {
    ++found_.apart;
    return;
  }
  std::vector<Eigen::Vector2d> there;
  for (const Feature& corner : corners.all()) there.push_back(corner.img);
  const double radius_px = kNearShare * std::max(size.width, size.height);
  const auto again = MatchInWindow(corners, state_->corners, there, radius_px);
  ++(static_cast<double>(again.size()) >= kFoundAgainShare * corners.size() ? found_.near : found_.apart);
}

}  // namespace ulf::tracking
