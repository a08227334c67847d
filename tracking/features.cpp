#include "tracking/features.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace ulf {
namespace {

using Eigen::Vector2d;

constexpr int kPatchRadius = 15;  // of orientation and descriptor
constexpr int kBorder =
    20;  // level pixels: the rotated descriptor patch and the corner refinement fit inside
constexpr int kFastStart = 15, kFastLowest = 6, kFastHighest = 40;

struct Corner {
  int x = 0, y = 0;
  float response = 0;
  int rank = 0;  // within its cell, strongest first
};

// The strongest of each cell first, then the second strongest of each, until there are enough: even over the
// image.
void KeepSpread(std::vector<Corner>& corners, int count, cv::Size size) {
  if (static_cast<int>(corners.size()) <= count) return;
  const double cell = std::max(8.0, std::sqrt(static_cast<double>(size.area()) / std::max(1, count)));
  const int columns = static_cast<int>(size.width / cell) + 1;
  std::vector<int> taken(static_cast<std::size_t>(columns * (static_cast<int>(size.height / cell) + 1)), 0);
  const auto stronger = [](const Corner& a, const Corner& b) {
    if (a.response != b.response) return a.response > b.response;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  };
  std::sort(corners.begin(), corners.end(), stronger);
  for (Corner& corner : corners)
    corner.rank = taken[static_cast<std::size_t>(static_cast<int>(corner.y / cell) * columns +
                                                 static_cast<int>(corner.x / cell))]++;
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.rank < b.rank; });
  corners.resize(static_cast<std::size_t>(count));
}

// Where the circle of the orientation patch ends on each row.
std::array<int, kPatchRadius + 1> CircleExtents() {
  std::array<int, kPatchRadius + 1> extents{};
  for (int v = 0; v <= kPatchRadius; ++v)
    extents[static_cast<std::size_t>(v)] =
        static_cast<int>(std::lround(std::sqrt(static_cast<double>(kPatchRadius * kPatchRadius - v * v))));
  return extents;
}

// Direction from the patch's centre to its centroid of intensity.
float Orientation(const cv::Mat& image, int x, int y) {
  static const std::array<int, kPatchRadius + 1> extents = CircleExtents();
  int moment_x = 0, moment_y = 0;
  for (int v = -kPatchRadius; v <= kPatchRadius; ++v) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y + v) + x;
    const int extent = extents[static_cast<std::size_t>(std::abs(v))];
    int sum = 0, weighted = 0;
    for (int u = -extent; u <= extent; ++u) {
      sum += row[u];
      weighted += u * row[u];
    }
    moment_x += weighted;
    moment_y += v * sum;
  }
  return std::atan2(static_cast<float>(moment_y), static_cast<float>(moment_x));
}

// The peak of the corner response around an integer corner, by parabolas: FAST's own maximum is quantised to
// pixels.
Vector2d SubpixelCorner(const cv::Mat& image, int x, int y) {
  constexpr int kWindow = 3, kReach = kWindow + 1, kSide = 2 * kReach + 1;
  float xx[kSide][kSide], xy[kSide][kSide], yy[kSide][kSide];
  for (int v = 0; v < kSide; ++v) {
    const std::uint8_t* above = image.ptr<std::uint8_t>(y + v - kReach - 1) + x - kReach;
    const std::uint8_t* row = image.ptr<std::uint8_t>(y + v - kReach) + x - kReach;
    const std::uint8_t* below = image.ptr<std::uint8_t>(y + v - kReach + 1) + x - kReach;
    for (int u = 0; u < kSide; ++u) {
      const float gx = static_cast<float>(row[u + 1] - row[u - 1]);
      const float gy = static_cast<float>(below[u] - above[u]);
      xx[v][u] = gx * gx;
      xy[v][u] = gx * gy;
      yy[v][u] = gy * gy;
    }
  }
  const auto response = [&](int dx, int dy) {
    float a = 0, b = 0, c = 0;
    for (int v = 1; v < kSide - 1; ++v)
      for (int u = 1; u < kSide - 1; ++u) {
        a += xx[v + dy][u + dx];
        b += xy[v + dy][u + dx];
        c += yy[v + dy][u + dx];
      }
    return a * c - b * b - 0.04f * (a + c) * (a + c);
  };
  const float center = response(0, 0);
  const auto peak = [center](float before, float after) {
    const float curvature = before - 2 * center + after;
    if (curvature >= 0) return 0.0f;
    return std::clamp(0.5f * (before - after) / curvature, -0.5f, 0.5f);
  };
  return {x + peak(response(-1, 0), response(1, 0)), y + peak(response(0, -1), response(0, 1))};
}

}  // namespace

double LevelScale(int level) {
  static const auto scales = [] {
    std::array<double, kPyramidLevels> made{};
    for (int l = 0; l < kPyramidLevels; ++l) made[static_cast<std::size_t>(l)] = std::pow(kPyramidFactor, l);
    return made;
  }();
  return scales[static_cast<std::size_t>(level)];
}

Vector2d Pyramid::ToLevel(int level, const Vector2d& img) const {
  const cv::Mat &base = levels[0], &image = levels[static_cast<std::size_t>(level)];
  return {img.x() * image.cols / base.cols, img.y() * image.rows / base.rows};
}

Vector2d Pyramid::FromLevel(int level, const Vector2d& on_level) const {
  const cv::Mat &base = levels[0], &image = levels[static_cast<std::size_t>(level)];
  return {on_level.x() * base.cols / image.cols, on_level.y() * base.rows / image.rows};
}

Pyramid BuildPyramid(const cv::Mat& gray) {
  Pyramid pyramid;
  pyramid.levels[0] = gray;
  for (int level = 1; level < kPyramidLevels; ++level) {
    const double scale = LevelScale(level);
    const cv::Size size(std::max(1, static_cast<int>(std::lround(gray.cols / scale))),
                        std::max(1, static_cast<int>(std::lround(gray.rows / scale))));
    cv::resize(pyramid.levels[static_cast<std::size_t>(level - 1)],
               pyramid.levels[static_cast<std::size_t>(level)], size, 0, 0, cv::INTER_LINEAR);
  }
  return pyramid;
}

FeatureSet::FeatureSet(std::vector<Feature> features, int width, int height)
    : features_(std::move(features)),
      columns_(std::max(1, static_cast<int>(std::ceil(width / kCellPx)))),
      rows_(std::max(1, static_cast<int>(std::ceil(height / kCellPx)))) {
  const auto cell_of = [&](const Feature& feature) {
    return static_cast<std::size_t>(Cell(feature.img.y(), rows_) * columns_ +
                                    Cell(feature.img.x(), columns_));
  };
  starts_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (const Feature& feature : features_) ++starts_[cell_of(feature) + 1];
  for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
  std::vector<int> next(starts_.begin(), starts_.end() - 1);
  members_.resize(features_.size());
  for (int i = 0; i < size(); ++i) {
    const std::size_t cell = cell_of(features_[static_cast<std::size_t>(i)]);
    members_[static_cast<std::size_t>(next[cell]++)] = i;
  }
}

int FeatureSet::Cell(double coordinate, int count) {
  if (!(coordinate > 0)) return 0;
  return coordinate >= kCellPx * count ? count - 1 : static_cast<int>(coordinate / kCellPx);
}

struct FeatureExtractor::State {
  CameraModel camera;
  cv::Ptr<cv::ORB> describer;
  std::array<int, kPyramidLevels> fast_threshold;
};

FeatureExtractor::FeatureExtractor(const CameraModel& camera) : state_(std::make_unique<State>()) {
  state_->camera = camera;
  // One level only: positions, levels and orientations are ours.
  state_->describer =
      cv::ORB::create(1, 1.2f, 1, kPatchRadius + 1, 0, 2, cv::ORB::FAST_SCORE, 2 * kPatchRadius + 1);
  state_->fast_threshold.fill(kFastStart);
}
FeatureExtractor::~FeatureExtractor() = default;
FeatureExtractor::FeatureExtractor(FeatureExtractor&&) noexcept = default;
FeatureExtractor& FeatureExtractor::operator=(FeatureExtractor&&) noexcept = default;

FeatureSet FeatureExtractor::Extract(const Pyramid& pyramid, int count) {
  // Levels share the features in proportion to their side length.
  double shares = 0;
  for (int level = 0; level < kPyramidLevels; ++level) shares += 1 / LevelScale(level);

  std::vector<Feature> features;
  std::vector<cv::KeyPoint> keypoints;
  std::vector<Corner> corners;
  for (int level = 0; level < kPyramidLevels; ++level) {
    const cv::Mat& image = pyramid.levels[static_cast<std::size_t>(level)];
    if (image.cols <= 2 * kBorder || image.rows <= 2 * kBorder) break;
    const int wanted = static_cast<int>(std::lround(count / LevelScale(level) / shares));
    int& threshold = state_->fast_threshold[static_cast<std::size_t>(level)];
    const cv::Rect inside(kBorder - 3, kBorder - 3, image.cols - 2 * kBorder + 6,
                          image.rows - 2 * kBorder + 6);
    cv::FAST(image(inside), keypoints, threshold, true);
    // Several times as many candidates as wanted leave something for poorly textured cells.
    const int found = static_cast<int>(keypoints.size());
    if (found < 3 * wanted) threshold = std::max(kFastLowest, threshold - std::max(1, threshold / 8));
    if (found > 5 * wanted) threshold = std::min(kFastHighest, threshold + std::max(1, threshold / 8));

    corners.clear();
    for (const cv::KeyPoint& keypoint : keypoints)
      corners.push_back({static_cast<int>(keypoint.pt.x) + inside.x,
                         static_cast<int>(keypoint.pt.y) + inside.y, keypoint.response});
    KeepSpread(corners, wanted, image.size());

    keypoints.clear();
    for (const Corner& corner : corners) {
      cv::KeyPoint keypoint(static_cast<float>(corner.x), static_cast<float>(corner.y), 2 * kPatchRadius + 1);
      keypoint.angle = Orientation(image, corner.x, corner.y) * static_cast<float>(180 / M_PI);
      if (keypoint.angle < 0) keypoint.angle += 360;
      keypoint.octave = 0;
      keypoint.class_id = static_cast<int>(keypoints.size());
      keypoints.push_back(keypoint);
    }
    if (keypoints.empty()) continue;
    cv::Mat descriptors;
    state_->describer->compute(image, keypoints, descriptors);
    for (int k = 0; k < static_cast<int>(keypoints.size()); ++k) {
      const cv::KeyPoint& keypoint = keypoints[static_cast<std::size_t>(k)];
      const Corner& corner = corners[static_cast<std::size_t>(keypoint.class_id)];
      // From OpenCV's integer centres to ours: half a pixel of this level.
      const Vector2d on_level = SubpixelCorner(image, corner.x, corner.y) + Vector2d(0.5, 0.5);
      Feature feature;
      feature.img = pyramid.FromLevel(level, on_level);
      const auto ray = state_->camera.RayFromImg(feature.img);
      if (!ray) continue;
      feature.ray = *ray;
      feature.angle_rad = keypoint.angle * static_cast<float>(M_PI / 180);
      feature.level = level;
      std::memcpy(feature.descriptor.data(), descriptors.ptr(k), sizeof(Descriptor));
      features.push_back(feature);
    }
  }
  return FeatureSet(std::move(features), state_->camera.width, state_->camera.height);
}

}  // namespace ulf
