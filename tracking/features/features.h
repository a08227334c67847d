// Detects corners that are spread evenly over the image and over scale (FAST corners on an image pyramid).
// Each has an oriented binary descriptor (ORB, Rublee et al. 2011) and the ray through it.
//
// Image points are level 0 pixels with centres at integer + 0.5. Pixel x + 0.5 of a coarse level lies at (x +
// 0.5) · scale on level 0, as cv::resize maps it. Descriptors are cv::ORB's, corners are not: cv::ORB's own
// pyramid omits the half pixels, which biases coarse levels by up to 1.3 px here, and cv::ORB keeps the
// strongest corners even where they crowd.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/at.h"
#include "core/geometry/camera_model.h"

namespace ulf::tracking {

using Descriptor = std::array<std::uint64_t, 4>;  // 256 bits

// Returns the Hamming distance, in bits.
inline int Distance(const Descriptor& a, const Descriptor& b) {
  return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) + std::popcount(a[2] ^ b[2]) +
         std::popcount(a[3] ^ b[3]);
}

inline constexpr int kPyramidLevels = 8;
inline constexpr double kPyramidFactor = 1.2;
// The margin of each level without corners, level pixels: the rotated descriptor patch must fit.
inline constexpr int kFeatureBorder = 20;
// kPyramidFactor^level for the levels 0 to kPyramidLevels - 1.
inline constexpr std::array<double, kPyramidLevels> kLevelScales = [] {
  std::array<double, kPyramidLevels> scales{1};
  for (std::size_t l = 1; l < kPyramidLevels; ++l) scales[l] = scales[l - 1] * kPyramidFactor;
  return scales;
}();
inline double LevelScale(int level) { return kLevelScales[At(level)]; }
// Return one standard deviation, level 0 px, of a corner that was detected on a level, and of a point that
// was measured there by aligning a patch (patch_alignment.h). Guessed; smaller ones for aligned patches made
// young maps worse (docs/measured/tracking.md, "The map").
inline double DetectedSigmaPx(int level) { return 1.0 * LevelScale(level); }
inline double AlignedSigmaPx(int level) { return 0.4 * LevelScale(level); }
// Returns the level whose LevelScale() is nearest to `scale`, by ratio.
inline int NearestLevel(double scale) {
  constexpr double kHalfStep = 1.0954451150103321;  // square root of kPyramidFactor
  int level = 0;
  while (level + 1 < kPyramidLevels && scale >= LevelScale(level) * kHalfStep) ++level;
  return level;
}

class RowShift;

// Grey images (CV_8UC1), each 1 / kPyramidFactor the size of the one before.
struct Pyramid {
  std::array<cv::Mat, kPyramidLevels> levels;
  // The shift of a rolling shutter (rolling_shutter.h): image points are those of a global shutter, pixels
  // are where the sensor saw them. Null: the shutter is global.
  std::shared_ptr<const RowShift> rows;
  // Convert an image point to where the sensor saw it, and back: exactly if `point_in_cam` is given, else
  // with a depth that is interpolated from known points around.
  Eigen::Vector2d Seen(const Eigen::Vector2d& img, const Eigen::Vector3d* point_in_cam = nullptr) const;
  Eigen::Vector2d Global(const Eigen::Vector2d& seen, const Eigen::Vector3d* point_in_cam = nullptr) const;
  // Convert pixels (where the sensor saw them) of level 0 to a level and back, by rounded sizes.
  Eigen::Vector2d ToLevel(int level, const Eigen::Vector2d& img) const;
  Eigen::Vector2d FromLevel(int level, const Eigen::Vector2d& on_level) const;
};
Pyramid BuildPyramid(const cv::Mat& gray);  // level 0 shares the pixels of `gray`

// Returns how many pixels of an image of this width are as wide as one pixel of an image 640 px wide.
inline double PxAt640(int width) { return width / 640.0; }

struct Feature {
  Eigen::Vector2d img;
  Eigen::Vector3d ray;  // unit vector in the camera frame
  float angle_rad = 0;  // direction from the corner to the intensity centroid of its patch
  int level = 0;        // on which it was detected
  Descriptor descriptor{};
};

// Returns the index, row by row, of the grid cell of an image point, outside of the image the nearest.
inline std::size_t CellOf(const Eigen::Vector2d& img, const CameraModel& camera, int columns, int rows) {
  const int column = std::clamp(static_cast<int>(img.x() * columns / camera.width), 0, columns - 1);
  const int row = std::clamp(static_cast<int>(img.y() * rows / camera.height), 0, rows - 1);
  return At(row * columns + column);
}

// Returns red, green and blue of the pixel nearest to an image point; `image`: 8 bits, B G R or grey.
std::array<std::uint8_t, 3> RgbAt(const cv::Mat& image, const Eigen::Vector2d& img);

// A frame's features with an index for window searches. `width` and `height` are the image's. Immutable.
class FeatureSet {
 public:
  FeatureSet() = default;
  FeatureSet(std::vector<Feature> features, int width, int height);

  const std::vector<Feature>& all() const { return features_; }
  const Feature& operator[](int i) const { return features_[At(i)]; }
  int size() const { return static_cast<int>(features_.size()); }

  // Calls visit(index) for every feature within `radius` px of `img` on the levels `lowest` to `highest`.
  template <typename Visit>
  void ForEachNear(const Eigen::Vector2d& img, double radius, int lowest, int highest, Visit&& visit) const {
    const int x0 = Cell(img.x() - radius, columns_), x1 = Cell(img.x() + radius, columns_);
    const int y0 = Cell(img.y() - radius, rows_), y1 = Cell(img.y() + radius, rows_);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const std::size_t cell = At(y * columns_ + x);
        for (int k = starts_[cell]; k < starts_[cell + 1]; ++k) {
          const int i = members_[At(k)];
          const Feature& feature = features_[At(i)];
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

struct FeatureOptions {
  // Corners are detected on so many of the finest levels, 1 to kPyramidLevels. Fewer fail in noise, blur and
  // large steps; more cost time and exactness. Measured: docs/measured/charts/tracking_levels.png.
  int levels = 5;
};

// Detects the features of the successive frames of one camera; one thread at a time may use it.
class FeatureExtractor {
 public:
  explicit FeatureExtractor(const CameraModel& camera, const FeatureOptions& options = {});
  ~FeatureExtractor();

  // Returns about `count` features, fewer if the image has fewer corners. The corner threshold adapts from
  // frame to frame, so the result depends on the frames before.
  FeatureSet Extract(const Pyramid& pyramid, int count);
  void SetCamera(const CameraModel& camera);  // replaces the lens; the image size must stay

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::tracking
