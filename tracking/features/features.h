// Corners spread evenly over the image and over scale, each with an oriented binary descriptor (ORB, Rublee
// et al. 2011) and the ray through it.
//
// Image points are level 0 pixels with centres at integer + 0.5; OpenCV's integer-centred coordinates end
// inside features.cpp. A coarse level's pixel (x + 0.5) lies at (x + 0.5) · scale of level 0, as cv::resize
// maps it (cv::ORB's own pyramid forgets the half pixels, which biases coarse levels by up to 1.3 px here:
// one reason to detect ourselves; the other is that cv::ORB keeps the strongest corners, wherever they
// crowd). Descriptors are cv::ORB's.
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera_model.h"

namespace ulf::tracking {

using Descriptor = std::array<std::uint64_t, 4>;

inline int Distance(const Descriptor& a, const Descriptor& b) {
  return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) + std::popcount(a[2] ^ b[2]) +
         std::popcount(a[3] ^ b[3]);
}

inline constexpr int kPyramidLevels = 8;
inline constexpr double kPyramidFactor = 1.2;
// kPyramidFactor^level, level 0 to kPyramidLevels - 1
inline constexpr std::array<double, kPyramidLevels> kLevelScales = [] {
  std::array<double, kPyramidLevels> scales{1};
  for (std::size_t l = 1; l < kPyramidLevels; ++l) scales[l] = scales[l - 1] * kPyramidFactor;
  return scales;
}();
inline double LevelScale(int level) { return kLevelScales[static_cast<std::size_t>(level)]; }
// The level whose scale is nearest, by ratio.
inline int NearestLevel(double scale) {
  constexpr double kHalfStep = 1.0954451150103321;  // the root of kPyramidFactor
  int level = 0;
  while (level + 1 < kPyramidLevels && scale >= LevelScale(level) * kHalfStep) ++level;
  return level;
}

class RowShift;

// Grey images, each 1 / kPyramidFactor of the one before.
struct Pyramid {
  std::array<cv::Mat, kPyramidLevels> levels;
  // Of a rolling shutter: image points are those of a global one, pixels are where the sensor saw them.
  std::shared_ptr<const RowShift> rows;
  // Where the sensor saw what is at an image point, and back; of a point whose place is known, exactly.
  Eigen::Vector2d Seen(const Eigen::Vector2d& img, const Eigen::Vector3d* point_in_cam = nullptr) const {
    return rows ? SeenByRow(img, point_in_cam) : img;
  }
  Eigen::Vector2d Global(const Eigen::Vector2d& seen, const Eigen::Vector3d* point_in_cam = nullptr) const {
    return rows ? GlobalByRow(seen, point_in_cam) : seen;
  }
  // Level pixels per level 0 pixel (both where the sensor saw them), as the rounded sizes make it.
  Eigen::Vector2d ToLevel(int level, const Eigen::Vector2d& img) const;
  Eigen::Vector2d FromLevel(int level, const Eigen::Vector2d& on_level) const;

 private:
  Eigen::Vector2d SeenByRow(const Eigen::Vector2d& img, const Eigen::Vector3d* point_in_cam) const;
  Eigen::Vector2d GlobalByRow(const Eigen::Vector2d& seen, const Eigen::Vector3d* point_in_cam) const;
};
Pyramid BuildPyramid(const cv::Mat& gray);

struct Feature {
  Eigen::Vector2d img;
  Eigen::Vector3d ray;  // unit, camera frame
  float angle_rad = 0;  // of the patch's intensity centroid
  int level = 0;
  Descriptor descriptor{};
};

// A frame's features with an index for window searches.
class FeatureSet {
 public:
  FeatureSet() = default;
  FeatureSet(std::vector<Feature> features, int width, int height);

  const std::vector<Feature>& all() const { return features_; }
  const Feature& operator[](int i) const { return features_[static_cast<std::size_t>(i)]; }
  int size() const { return static_cast<int>(features_.size()); }

  // Calls visit(index) for every feature within `radius` px of `img` on levels lowest to highest.
  template <typename Visit>
  void ForEachNear(const Eigen::Vector2d& img, double radius, int lowest, int highest, Visit&& visit) const {
    const int x0 = Cell(img.x() - radius, columns_), x1 = Cell(img.x() + radius, columns_);
    const int y0 = Cell(img.y() - radius, rows_), y1 = Cell(img.y() + radius, rows_);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const std::size_t cell = static_cast<std::size_t>(y * columns_ + x);
        for (int k = starts_[cell]; k < starts_[cell + 1]; ++k) {
          const int i = members_[static_cast<std::size_t>(k)];
          const Feature& feature = features_[static_cast<std::size_t>(i)];
          if (feature.level < lowest || feature.level > highest) continue;
          if ((feature.img - img).squaredNorm() <= radius * radius) visit(i);
        }
      }
  }

 private:
  static constexpr double kCellPx = 16;
  static int Cell(double coordinate, int count);
  std::vector<Feature> features_;
  int columns_ = 1, rows_ = 1;
  std::vector<int> starts_{0, 0};  // by cell, into members_
  std::vector<int> members_;
};

class FeatureExtractor {
 public:
  // On the finest `levels` of a pyramid.
  explicit FeatureExtractor(const CameraModel& camera, int levels = kPyramidLevels);
  ~FeatureExtractor();
  FeatureExtractor(FeatureExtractor&&) noexcept;
  FeatureExtractor& operator=(FeatureExtractor&&) noexcept;

  // About `count` features. The corner threshold adapts from frame to frame, so the result depends on what
  // came before.
  FeatureSet Extract(const Pyramid& pyramid, int count);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::tracking
