// Detects corners that are spread evenly over the image and over scale. Each has an oriented binary
// descriptor (ORB, Rublee et al. 2011) and the ray through it.
//
// Image points are level 0 pixels with centres at integer + 0.5; features.cpp converts OpenCV's
// integer-centred coordinates. Pixel x + 0.5 of a coarse level lies at (x + 0.5) · scale on level 0, as
// cv::resize maps it. Descriptors are cv::ORB's, corners are not, for two reasons: cv::ORB's own pyramid
// omits the half pixels, which biases coarse levels by up to 1.3 px here, and cv::ORB keeps the strongest
// corners even where they crowd.
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

using Descriptor = std::array<std::uint64_t, 4>;

inline int Distance(const Descriptor& a, const Descriptor& b) {
  return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) + std::popcount(a[2] ^ b[2]) +
         std::popcount(a[3] ^ b[3]);
}

inline constexpr int kPyramidLevels = 8;
inline constexpr double kPyramidFactor = 1.2;
// Level pixels at the image's edge without corners, for the rotated descriptor patch and the refinement.
inline constexpr int kFeatureBorder = 20;
// kPyramidFactor^level for the levels 0 to kPyramidLevels - 1.
inline constexpr std::array<double, kPyramidLevels> kLevelScales = [] {
  std::array<double, kPyramidLevels> scales{1};
  for (std::size_t l = 1; l < kPyramidLevels; ++l) scales[l] = scales[l - 1] * kPyramidFactor;
  return scales;
}();
inline double LevelScale(int level) { return kLevelScales[At(level)]; }
// One standard deviation, px, of a corner that was detected on a level, and of a point that was measured
// there by aligning a patch (patch_alignment.h). Guessed; smaller ones for aligned patches made young maps
// worse (docs/measured/tracking.md, "The map").
inline double DetectedSigmaPx(int level) { return 1.0 * LevelScale(level); }
inline double AlignedSigmaPx(int level) { return 0.4 * LevelScale(level); }
// Returns the level whose scale is nearest, by ratio.
inline int NearestLevel(double scale) {
  constexpr double kHalfStep = 1.0954451150103321;  // square root of kPyramidFactor
  int level = 0;
  while (level + 1 < kPyramidLevels && scale >= LevelScale(level) * kHalfStep) ++level;
  return level;
}

class RowShift;

// Grey images, each 1 / kPyramidFactor of the one before.
struct Pyramid {
  std::array<cv::Mat, kPyramidLevels> levels;
  // Under a rolling shutter image points are those of a global shutter, and pixels are where the sensor saw
  // them. Null: the shutter is global.
  std::shared_ptr<const RowShift> rows;
  // Convert an image point to where the sensor saw it, and back: exactly where `point_in_cam` is given, else
  // with a depth that is interpolated from the points around.
  Eigen::Vector2d Seen(const Eigen::Vector2d& img, const Eigen::Vector3d* point_in_cam = nullptr) const;
  Eigen::Vector2d Global(const Eigen::Vector2d& seen, const Eigen::Vector3d* point_in_cam = nullptr) const;
  // Convert between level 0 and level pixels (where the sensor saw them) by the ratio of rounded sizes.
  Eigen::Vector2d ToLevel(int level, const Eigen::Vector2d& img) const;
  Eigen::Vector2d FromLevel(int level, const Eigen::Vector2d& on_level) const;
};
Pyramid BuildPyramid(const cv::Mat& gray);

// Returns the pixels of an image of this width that correspond to one pixel of an image 640 px wide.
inline double PxAt640(int width) { return width / 640.0; }

struct Feature {
  Eigen::Vector2d img;
  Eigen::Vector3d ray;  // unit, camera frame
  float angle_rad = 0;  // of the patch's intensity centroid
  int level = 0;
  Descriptor descriptor{};
};

// Returns the grid cell of an image point; a point outside of the image belongs to the nearest cell.
inline std::size_t CellOf(const Eigen::Vector2d& img, const CameraModel& camera, int columns, int rows) {
  const int column = std::clamp(static_cast<int>(img.x() * columns / camera.width), 0, columns - 1);
  const int row = std::clamp(static_cast<int>(img.y() * rows / camera.height), 0, rows - 1);
  return At(row * columns + column);
}

// Returns red, green and blue of the pixel nearest to an image point; `image`: 8 bits, B G R or grey.
std::array<std::uint8_t, 3> RgbAt(const cv::Mat& image, const Eigen::Vector2d& img);

// A frame's features with a grid index for window searches.
class FeatureSet {
 public:
  FeatureSet() = default;
  FeatureSet(std::vector<Feature> features, int width, int height);

  const std::vector<Feature>& all() const { return features_; }
  const Feature& operator[](int i) const { return features_[At(i)]; }
  int size() const { return static_cast<int>(features_.size()); }

  // Calls visit(index) for every feature within `radius` px of `img` on levels lowest to highest.
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
  // The finest levels of the pyramid that corners are detected on, 1 to kPyramidLevels. Fewer are lost in
  // noise, blur and large steps, more cost time and exactness. Measured:
  // docs/measured/charts/tracking_levels.png.
  int levels = 5;
};

class FeatureExtractor {
 public:
  explicit FeatureExtractor(const CameraModel& camera, const FeatureOptions& options = {});
  ~FeatureExtractor();

  // Returns about `count` features. The corner threshold adapts from frame to frame, so the result depends on
  // the frames before.
  FeatureSet Extract(const Pyramid& pyramid, int count);
  void SetCamera(const CameraModel& camera);  // another lens, the same image size

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::tracking
