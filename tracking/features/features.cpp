#include "tracking/features/features.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/at.h"
#include "core/geometry/angles.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;

// FAST's threshold in grey levels: where each level starts, and the range in which it adapts to the scene.
// Below, noise gives corners; above, dim textures give none. Guessed.
constexpr int kFastStart = 15, kFastLowest = 6, kFastHighest = 40;
// The threshold adapts until FAST finds this many times the corners that are kept. Fewer leave cells with
// little texture empty, more cost time. Guessed.
constexpr double kLeastCandidates = 1.5, kMostCandidates = 2.25;
// The smallest side of a cell in which corners compete, level pixels. Guessed.
constexpr double kLeastCellPx = 8;

constexpr int kPatchRadius = 15;  // of orientation and descriptor
constexpr int kFastRadius = 3;    // of FAST's circle, which needs as much beside a corner
constexpr float kHarris = 0.04f;  // Harris and Stephens 1988, section 3

struct Corner {
  int x = 0, y = 0;
  int response = 0;
};

bool Stronger(const Corner& a, const Corner& b) {
  if (a.response != b.response) return a.response > b.response;
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

// Chooses corners even over the image: the strongest of each cell first, then the second strongest of each,
// until there are enough.
void Spread(std::vector<Corner>& corners, int count, cv::Size size) {
  if (static_cast<int>(corners.size()) <= count) return;
  const double cell =
      std::max(kLeastCellPx, std::sqrt(static_cast<double>(size.area()) / std::max(1, count)));
  const double cells_per_px = 1 / cell;
  const int columns = static_cast<int>(size.width / cell) + 1;
  const auto cell_of = [&](const Corner& corner) {
    return At(static_cast<int>(corner.y * cells_per_px) * columns +
              static_cast<int>(corner.x * cells_per_px));
  };
  std::vector<int> starts(At(columns * (static_cast<int>(size.height / cell) + 1)) + 1, 0);
  for (const Corner& corner : corners) ++starts[cell_of(corner) + 1];
  for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
  std::vector<int> next(starts.begin(), starts.end() - 1);
  std::vector<Corner> by_cell(corners.size());
  for (const Corner& corner : corners) by_cell[At(next[cell_of(corner)]++)] = corner;
  corners.clear();
  next.clear();  // from here on: the cells that are not exhausted
  for (std::size_t c = 0; c + 1 < starts.size(); ++c) {
    if (starts[c] == starts[c + 1]) continue;
    std::sort(by_cell.begin() + starts[c], by_cell.begin() + starts[c + 1], Stronger);
    next.push_back(static_cast<int>(c));
  }
  for (int rank = 0; static_cast<int>(corners.size()) < count; ++rank) {
    const std::size_t before = corners.size();
    std::erase_if(next, [&](int c) {
      const int at = starts[At(c)] + rank;
      corners.push_back(by_cell[At(at)]);
      return at + 1 == starts[At(c) + 1];
    });
    std::sort(corners.begin() + static_cast<long>(before), corners.end(), Stronger);
  }
  corners.resize(At(count));
}

constexpr int kSide = 32;  // pixels that a row of a patch is read as: whole vectors
using PatchRow = std::array<std::int16_t, kSide>;

// One mask for each row of the orientation patch, from x - kPatchRadius on: it is all ones inside the circle.
std::array<PatchRow, kPatchRadius + 1> CircleMasks() {
  std::array<PatchRow, kPatchRadius + 1> masks{};
  for (int v = 0; v <= kPatchRadius; ++v) {
    const int extent =
        static_cast<int>(std::lround(std::sqrt(static_cast<double>(kPatchRadius * kPatchRadius - v * v))));
    for (int u = -extent; u <= extent; ++u) masks[At(v)][At(u + kPatchRadius)] = -1;
  }
  return masks;
}

// Returns the direction from the patch's centre to its centroid of intensity. Adds the rows above and below
// the centre in pairs, so that 16 bits hold every sum of a column.
float Orientation(const cv::Mat& image, int x, int y) {
  static const std::array<PatchRow, kPatchRadius + 1> masks = CircleMasks();
  PatchRow column{}, column_by_y{};
  const std::uint8_t* center = image.ptr<std::uint8_t>(y) + x - kPatchRadius;
  for (std::size_t u = 0; u < kSide; ++u) column[u] = static_cast<std::int16_t>(center[u] & masks[0][u]);
  for (int v = 1; v <= kPatchRadius; ++v) {
    const std::uint8_t* above = image.ptr<std::uint8_t>(y - v) + x - kPatchRadius;
    const std::uint8_t* below = image.ptr<std::uint8_t>(y + v) + x - kPatchRadius;
    const PatchRow& mask = masks[At(v)];
    for (std::size_t u = 0; u < kSide; ++u) {
      column[u] = static_cast<std::int16_t>(column[u] + ((below[u] + above[u]) & mask[u]));
      column_by_y[u] = static_cast<std::int16_t>(column_by_y[u] + v * ((below[u] - above[u]) & mask[u]));
    }
  }
  int moment_x = 0, moment_y = 0;
  for (int u = 0; u < kSide; ++u) {
    moment_x += (u - kPatchRadius) * column[At(u)];
    moment_y += column_by_y[At(u)];
  }
  return std::atan2(static_cast<float>(moment_y), static_cast<float>(moment_x));
}

// Returns the peak of the corner response around an integer corner, by parabolas.
Vector2d SubpixelCorner(const cv::Mat& image, int x, int y) {
  constexpr int kWindow = 3, kReach = kWindow + 1, kRows = 2 * kReach + 1, kLanes = 16;
  // Structure tensors of a window's columns: of the window around the corner, and one row up and down.
  using Columns = std::array<std::int32_t, kLanes>;
  struct Sums {
    Columns xx{}, xy{}, yy{};
  };
  Sums middle, first, second_last, second, last;
  for (int v = 0; v < kRows; ++v) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y + v - kReach) + x - kReach;
    const std::uint8_t* above = row - image.step;
    const std::uint8_t* below = row + image.step;
    Sums of_row;
    for (std::size_t u = 0; u < kLanes; ++u) {
      const std::int32_t gx = row[u + 1] - *(row + u - 1), gy = below[u] - above[u];
      of_row.xx[u] = gx * gx;
      of_row.xy[u] = gx * gy;
      of_row.yy[u] = gy * gy;
    }
    if (v == 0) first = of_row;
    if (v == 1) second = of_row;
    if (v == kRows - 2) second_last = of_row;
    if (v == kRows - 1) last = of_row;
    if (v == 0 || v == kRows - 1) continue;
    for (std::size_t u = 0; u < kLanes; ++u) {
      middle.xx[u] += of_row.xx[u];
      middle.xy[u] += of_row.xy[u];
      middle.yy[u] += of_row.yy[u];
    }
  }
  const auto window = [](const Columns& columns, int from) {
    std::int32_t sum = 0;
    for (int u = from; u <= from + 2 * kWindow; ++u) sum += columns[At(u)];
    return sum;
  };
  const auto harris = [](std::int32_t xx, std::int32_t xy, std::int32_t yy) {
    const float a = static_cast<float>(xx), b = static_cast<float>(xy), c = static_cast<float>(yy);
    return a * c - b * b - kHarris * (a + c) * (a + c);
  };
  const auto response_beside = [&](int from) {
    return harris(window(middle.xx, from), window(middle.xy, from), window(middle.yy, from));
  };
  const auto response_moved = [&](const Sums& gained, const Sums& left_behind) {
    const auto one = [&](Columns Sums::*which) {
      return window(middle.*which, 1) + window(gained.*which, 1) - window(left_behind.*which, 1);
    };
    return harris(one(&Sums::xx), one(&Sums::xy), one(&Sums::yy));
  };
  const float center = response_beside(1);
  const auto peak = [center](float before, float after) {
    const float curvature = before - 2 * center + after;
    if (curvature >= 0) return 0.0f;
    return std::clamp(0.5f * (before - after) / curvature, -0.5f, 0.5f);
  };
  return {x + peak(response_beside(0), response_beside(2)),
          y + peak(response_moved(first, second_last), response_moved(last, second))};
}

}  // namespace

Vector2d Pyramid::ToLevel(int level, const Vector2d& img) const {
  const cv::Mat &base = levels[0], &image = levels[At(level)];
  return {img.x() * image.cols / base.cols, img.y() * image.rows / base.rows};
}

Vector2d Pyramid::FromLevel(int level, const Vector2d& on_level) const {
  const cv::Mat &base = levels[0], &image = levels[At(level)];
  return {on_level.x() * base.cols / image.cols, on_level.y() * base.rows / image.rows};
}

Pyramid BuildPyramid(const cv::Mat& gray) {
  Pyramid pyramid;
  pyramid.levels[0] = gray;
  for (int level = 1; level < kPyramidLevels; ++level) {
    const double scale = LevelScale(level);
    const cv::Size size(std::max(1, static_cast<int>(std::lround(gray.cols / scale))),
                        std::max(1, static_cast<int>(std::lround(gray.rows / scale))));
    cv::resize(pyramid.levels[At(level - 1)], pyramid.levels[At(level)], size, 0, 0, cv::INTER_LINEAR);
  }
  return pyramid;
}

std::array<std::uint8_t, 3> RgbAt(const cv::Mat& image, const Vector2d& img) {
  const int x = std::clamp(static_cast<int>(img.x()), 0, image.cols - 1);
  const int y = std::clamp(static_cast<int>(img.y()), 0, image.rows - 1);
  if (image.channels() == 3) {
    const auto& bgr = image.at<cv::Vec3b>(y, x);
    return {bgr[2], bgr[1], bgr[0]};
  }
  const std::uint8_t value = image.at<std::uint8_t>(y, x);
  return {value, value, value};
}

FeatureSet::FeatureSet(std::vector<Feature> features, int width, int height)
    : features_(std::move(features)),
      columns_(std::max(1, static_cast<int>(std::ceil(width / kCellPx)))),
      rows_(std::max(1, static_cast<int>(std::ceil(height / kCellPx)))) {
  const auto cell_of = [&](const Feature& feature) {
    return At(Cell(feature.img.y(), rows_) * columns_ + Cell(feature.img.x(), columns_));
  };
  starts_.assign(At(columns_ * rows_) + 1, 0);
  for (const Feature& feature : features_) ++starts_[cell_of(feature) + 1];
  for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
  std::vector<int> next(starts_.begin(), starts_.end() - 1);
  members_.resize(features_.size());
  for (int i = 0; i < size(); ++i) {
    const std::size_t cell = cell_of(features_[At(i)]);
    members_[At(next[cell]++)] = i;
  }
}

int FeatureSet::Cell(double coordinate, int count) {
  if (!(coordinate > 0)) return 0;
  return coordinate >= kCellPx * count ? count - 1 : static_cast<int>(coordinate / kCellPx);
}

struct FeatureExtractor::State {
  CameraModel camera;
  FeatureOptions options;
  cv::Ptr<cv::ORB> describer;
  std::array<int, kPyramidLevels> fast_threshold;
  // These are kept from frame to frame, so that their memory need not be allocated again.
  std::vector<cv::KeyPoint> keypoints;
  std::vector<Corner> corners;
  cv::Mat descriptors;
};

FeatureExtractor::FeatureExtractor(const CameraModel& camera, const FeatureOptions& options)
    : state_(std::make_unique<State>()) {
  state_->camera = camera;
  state_->options = options;
  state_->options.levels = std::clamp(options.levels, 1, kPyramidLevels);
  // One level only: positions, levels and orientations are computed here.
  state_->describer =
      cv::ORB::create(1, 1.2f, 1, kPatchRadius + 1, 0, 2, cv::ORB::FAST_SCORE, 2 * kPatchRadius + 1);
  state_->fast_threshold.fill(kFastStart);
}
FeatureExtractor::~FeatureExtractor() = default;

void FeatureExtractor::SetCamera(const CameraModel& camera) { state_->camera = camera; }

FeatureSet FeatureExtractor::Extract(const Pyramid& pyramid, int count) {
  const FeatureOptions& options = state_->options;
  // Levels share the features in proportion to their side length.
  double shares = 0;
  for (int level = 0; level < options.levels; ++level) shares += 1 / LevelScale(level);

  std::vector<Feature> features;
  features.reserve(At(count) + kPyramidLevels);
  std::vector<cv::KeyPoint>& keypoints = state_->keypoints;
  std::vector<Corner>& corners = state_->corners;
  for (int level = 0; level < options.levels; ++level) {
    const cv::Mat& image = pyramid.levels[At(level)];
    if (image.cols <= 2 * kFeatureBorder || image.rows <= 2 * kFeatureBorder) break;
    const int wanted = static_cast<int>(std::lround(count / LevelScale(level) / shares));
    int& threshold = state_->fast_threshold[At(level)];
    constexpr int kOutside = kFeatureBorder - kFastRadius;
    const cv::Rect inside(kOutside, kOutside, image.cols - 2 * kOutside, image.rows - 2 * kOutside);
    cv::FAST(image(inside), keypoints, threshold, true);
    const auto found = static_cast<double>(keypoints.size());
    const int step = std::max(1, threshold / 8);
    if (found < kLeastCandidates * wanted) threshold = std::max(kFastLowest, threshold - step);
    if (found > kMostCandidates * wanted) threshold = std::min(kFastHighest, threshold + step);

    corners.clear();
    for (const cv::KeyPoint& keypoint : keypoints)
      corners.push_back({static_cast<int>(keypoint.pt.x) + inside.x,
                         static_cast<int>(keypoint.pt.y) + inside.y, static_cast<int>(keypoint.response)});
    Spread(corners, wanted, image.size());

    keypoints.clear();
    for (const Corner& corner : corners) {
      cv::KeyPoint keypoint(static_cast<float>(corner.x), static_cast<float>(corner.y), 2 * kPatchRadius + 1);
      keypoint.angle = Orientation(image, corner.x, corner.y) * static_cast<float>(Degrees(1));
      if (keypoint.angle < 0) keypoint.angle += 360;
      keypoint.octave = 0;
      keypoint.class_id = static_cast<int>(keypoints.size());
      keypoints.push_back(keypoint);
    }
    if (keypoints.empty()) continue;
    cv::Mat& descriptors = state_->descriptors;
    state_->describer->compute(image, keypoints, descriptors);
    for (int k = 0; k < static_cast<int>(keypoints.size()); ++k) {
      const cv::KeyPoint& keypoint = keypoints[At(k)];
      const Corner& corner = corners[At(keypoint.class_id)];
      // OpenCV's pixel centres are integers, ours are half a pixel of this level farther.
      const Vector2d on_level = SubpixelCorner(image, corner.x, corner.y) + Vector2d(0.5, 0.5);
      Feature feature;
      feature.img = pyramid.FromLevel(level, on_level);
      const auto ray = state_->camera.RayFromImg(feature.img);
      if (!ray) continue;
      feature.ray = *ray;
      feature.angle_rad = keypoint.angle * static_cast<float>(Radians(1));
      feature.level = level;
      std::memcpy(feature.descriptor.data(), descriptors.ptr(k), sizeof(Descriptor));
      features.push_back(feature);
    }
  }
  return FeatureSet(std::move(features), state_->camera.width, state_->camera.height);
}

}  // namespace ulf::tracking
