#include "render/splats/splat_renderer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace ulf::render {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr int kTile = 16;
constexpr float kLowPass = 0.3f;  // px squared, of Kerbl et al.'s rasteriser, as the next two
constexpr float kLeastAlpha = 1.0f / 255;
constexpr float kMostAlpha = 0.99f;
constexpr float kGuardBand = 1.3f;  // beyond this multiple of the picture the projection is no longer linear
constexpr float kLeastTransmittance = 1e-3f;  // of a tile's clearest pixel: what lies behind is not drawn

// An ellipse in the picture.
struct Splat {
  float x, y;     // px
  float a, b, c;  // inverse covariance
  float opacity, depth;
  float half_width, half_height;  // px: farther off it gives less than kLeastAlpha
  Vector3f color;
  std::uint32_t gaussian;
};

class Projector {
 public:
  Projector(const CameraModel& camera, const Rigid3& cam_from_world)
      : camera_(camera),
        rotation_(cam_from_world.RotationMatrix().cast<float>()),
        translation_(cam_from_world.translation.cast<float>()),
        center_(cam_from_world.OriginInSource().cast<float>()),
        fx_(static_cast<float>(camera.fx)),
        fy_(static_cast<float>(camera.fy)),
        cx_(static_cast<float>(camera.cx)),
        cy_(static_cast<float>(camera.cy)),
        least_({-kGuardBand * cx_ / fx_, -kGuardBand * cy_ / fy_}),
        most_({kGuardBand * (static_cast<float>(camera.width) - cx_) / fx_,
               kGuardBand * (static_cast<float>(camera.height) - cy_) / fy_}) {}

  // Returns false if nothing of it is in the picture.
  bool Project(const Gaussian& gaussian, Splat& splat) const {
    const Vector3f in_cam = rotation_ * gaussian.position_in_world + translation_;
    if (!(in_cam.z() > 0) || !(gaussian.opacity > kLeastAlpha)) return false;
    const float per_depth = 1 / in_cam.z();
    const float slope_x = in_cam.x() * per_depth, slope_y = in_cam.y() * per_depth;
    splat.x = fx_ * slope_x + cx_;
    splat.y = fy_ * slope_y + cy_;
    const float wide_x = std::clamp(slope_x, least_[0], most_[0]);
    const float wide_y = std::clamp(slope_y, least_[1], most_[1]);
    // The rows of the projection's derivative, in the world's axes.
    const Vector3f along_x = (fx_ * per_depth) * (rotation_.row(0) - wide_x * rotation_.row(2)).transpose();
    const Vector3f along_y = (fy_ * per_depth) * (rotation_.row(1) - wide_y * rotation_.row(2)).transpose();
    const Matrix3f axes = gaussian.world_from_axes.toRotationMatrix();
    const Vector3f u = (axes.transpose() * along_x).cwiseProduct(gaussian.scale);
    const Vector3f v = (axes.transpose() * along_y).cwiseProduct(gaussian.scale);
    const float xx = u.squaredNorm() + kLowPass, xy = u.dot(v), yy = v.squaredNorm() + kLowPass;
    const float determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) return false;
    const float extent = std::sqrt(2 * std::log(gaussian.opacity / kLeastAlpha));
    splat.half_width = extent * std::sqrt(xx);
    splat.half_height = extent * std::sqrt(yy);
    if (!(splat.x + splat.half_width > 0 && splat.y + splat.half_height > 0 &&
          splat.x - splat.half_width < static_cast<float>(camera_.width) &&
          splat.y - splat.half_height < static_cast<float>(camera_.height)))
      return false;
    splat.a = yy / determinant;
    splat.b = -xy / determinant;
    splat.c = xx / determinant;
    splat.opacity = gaussian.opacity;
    splat.depth = in_cam.z();
    splat.color = ColorOf(gaussian, HarmonicsAt((gaussian.position_in_world - center_).normalized()));
    return true;
  }

 private:
  const CameraModel& camera_;
  Matrix3f rotation_;
  Vector3f translation_, center_;
  float fx_, fy_, cx_, cy_;
  std::array<float, 2> least_, most_;  // slopes
};

// Returns the splats' indices by depth, the nearest first: a radix sort, because depths are positive.
std::vector<std::uint32_t> ByDepth(const std::vector<Splat>& splats) {
  struct Keyed {
    std::uint32_t key, index;
  };
  std::vector<Keyed> from(splats.size()), to(splats.size());
  for (std::size_t i = 0; i < splats.size(); ++i)
    from[i] = {std::bit_cast<std::uint32_t>(splats[i].depth), static_cast<std::uint32_t>(i)};
  constexpr int kBits = 11;
  for (int shift = 0; shift < 32; shift += kBits) {
    std::array<std::uint32_t, (1 << kBits) + 1> begins{};
    const auto digit = [&](std::uint32_t key) { return (key >> shift) & ((1u << kBits) - 1); };
    for (const Keyed& one : from) ++begins[digit(one.key) + 1];
    for (std::size_t d = 1; d < begins.size(); ++d) begins[d] += begins[d - 1];
    for (const Keyed& one : from) to[begins[digit(one.key)]++] = one;
    std::swap(from, to);
  }
  std::vector<std::uint32_t> order(splats.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = from[i].index;
  return order;
}

// The splats of a picture, and for each of its tiles those that reach into it, the nearest first.
class SplatTiles {
 public:
  SplatTiles(const Gaussians& gaussians, const CameraModel& camera, const Rigid3& cam_from_world)
      : width_(camera.width),
        height_(camera.height),
        columns_((camera.width + kTile - 1) / kTile),
        rows_((camera.height + kTile - 1) / kTile) {
    const Projector projector(camera, cam_from_world);
    Splat splat{};
    for (std::size_t i = 0; i < gaussians.size(); ++i) {
      splat.gaussian = static_cast<std::uint32_t>(i);
      if (projector.Project(gaussians[i], splat)) splats_.push_back(splat);
    }
    begins_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
    for (const Splat& one : splats_) ForTilesOf(one, [&](std::size_t tile) { ++begins_[tile + 1]; });
    for (std::size_t t = 1; t < begins_.size(); ++t) begins_[t] += begins_[t - 1];
    listed_.resize(begins_.back());
    std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
    for (const std::uint32_t index : ByDepth(splats_))
      ForTilesOf(splats_[index], [&](std::size_t tile) { listed_[next[tile]++] = index; });
  }

  const std::vector<Splat>& splats() const { return splats_; }

  // Calls each(area, indices, count) for the tiles.
  template <typename Each>
  void ForEachTile(const Each& each) const {
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) {
        const cv::Rect area(column * kTile, row * kTile, std::min(kTile, width_ - column * kTile),
                            std::min(kTile, height_ - row * kTile));
        const std::size_t tile = Index(column, row);
        each(area, listed_.data() + begins_[tile], begins_[tile + 1] - begins_[tile]);
      }
  }

 private:
  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  template <typename Each>
  void ForTilesOf(const Splat& splat, const Each& each) const {
    const auto tile_of = [](float px, int count) {
      return std::clamp(static_cast<int>(std::floor(px / kTile)), 0, count - 1);
    };
    const int right = tile_of(splat.x + splat.half_width, columns_);
    const int bottom = tile_of(splat.y + splat.half_height, rows_);
    for (int row = tile_of(splat.y - splat.half_height, rows_); row <= bottom; ++row)
      for (int column = tile_of(splat.x - splat.half_width, columns_); column <= right; ++column)
        each(Index(column, row));
  }

  int width_, height_, columns_, rows_;
  std::vector<Splat> splats_;
  std::vector<std::size_t> begins_;
  std::vector<std::uint32_t> listed_;
};

// Returns e to the power of x <= 0, to 1e-5; 0 far below.
inline float FastExp(float x) {
  const float by_two = std::max(x * 1.44269504f, -120.0f);
  const float whole = std::floor(by_two), rest = by_two - whole;
  const float power =
      1 + rest * (0.69314718f +
                  rest * (0.24022651f + rest * (0.05550411f + rest * (0.00961812f + rest * 0.00133336f))));
  return power * std::bit_cast<float>((static_cast<std::int32_t>(whole) + 127) << 23);
}

// Returns the natural logarithm of 0 < x <= 1, to 1e-2.
inline float FastLog(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const float mantissa = std::bit_cast<float>((bits & 0x7fffff) | 0x3f800000);  // 1 to 2
  const float by_two = static_cast<float>((bits >> 23) - 127) - 1.7f + mantissa * (2.05f - 0.35f * mantissa);
  return std::min(0.0f, 0.69314718f * by_two);
}

// Blends the splats of one tile.
class TileBlend {
 public:
  struct Part {  // of a splat in the tile
    std::uint32_t index;
    int left, top, right, bottom;  // of the tile, the last ones exclusive
    std::size_t first;             // weight in `weights`
  };

  void Blend(const cv::Rect& area, const std::uint32_t* indices, std::size_t count,
             const std::vector<Splat>& splats, bool keeps_weights) {
    parts_.clear();
    weights_.clear();
    for (auto& row : transmittance_) row.fill(1);
    for (auto& channel : color_)
      for (auto& row : channel) row.fill(0);
    constexpr std::size_t kBetweenLooks = 32;
    for (std::size_t n = 0; n < count; ++n) {
      if (n % kBetweenLooks == 0 && n > 0 && Clearest(area) < kLeastTransmittance) break;
      Add(area, indices[n], splats[indices[n]], keeps_weights);
    }
  }
  const std::vector<Part>& parts() const { return parts_; }
  const float* WeightsOf(const Part& part) const { return weights_.data() + part.first; }
  float Transmittance(int x, int y) const {
    return transmittance_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
  }
  Vector3f Color(int x, int y) const {
    const auto column = static_cast<std::size_t>(x), row = static_cast<std::size_t>(y);
    return {color_[0][row][column], color_[1][row][column], color_[2][row][column]};
  }

 private:
  using Row = std::array<float, kTile>;

  float Clearest(const cv::Rect& area) const {
    float most = 0;
    for (std::size_t y = 0; y < static_cast<std::size_t>(area.height); ++y)
      for (std::size_t x = 0; x < static_cast<std::size_t>(area.width); ++x)
        most = std::max(most, transmittance_[y][x]);
    return most;
  }

  void Add(const cv::Rect& area, std::uint32_t index, const Splat& splat, bool keeps_weights) {
    const float at_x = splat.x - 0.5f - static_cast<float>(area.x);
    const float at_y = splat.y - 0.5f - static_cast<float>(area.y);
    const auto first = [](float from) { return std::max(0, static_cast<int>(std::ceil(from))); };
    const auto end = [](float to, int size) { return std::min(size, static_cast<int>(std::floor(to)) + 1); };
    const Part part{index,
                    first(at_x - splat.half_width),
                    first(at_y - splat.half_height),
                    end(at_x + splat.half_width, area.width),
                    end(at_y + splat.half_height, area.height),
                    weights_.size()};
    if (part.left >= part.right || part.top >= part.bottom) return;
    float weights[kTile];
    const int columns = part.right - part.left;
    for (int y = part.top; y < part.bottom; ++y) {
      const auto row = static_cast<std::size_t>(y);
      const float dy = static_cast<float>(y) - at_y;
      const float of_row = -0.5f * splat.c * dy * dy;
      float* clear = transmittance_[row].data() + part.left;
      for (int n = 0; n < columns; ++n) {
        const float dx = static_cast<float>(part.left + n) - at_x;
        const float power = of_row - dx * (0.5f * splat.a * dx + splat.b * dy);
        float alpha = std::min(kMostAlpha, splat.opacity * FastExp(std::min(0.0f, power)));
        alpha = alpha < kLeastAlpha ? 0.0f : alpha;
        weights[n] = clear[n] * alpha;
        clear[n] *= 1 - alpha;
      }
      for (std::size_t c = 0; c < 3; ++c) {
        float* sum = color_[c][row].data() + part.left;
        const float of_splat = splat.color[static_cast<int>(c)];
        for (int n = 0; n < columns; ++n) sum[n] += weights[n] * of_splat;
      }
      if (keeps_weights) weights_.insert(weights_.end(), weights, weights + columns);
    }
    if (keeps_weights) parts_.push_back(part);
  }

  std::array<Row, kTile> transmittance_{};
  std::array<std::array<Row, kTile>, 3> color_{};  // R G B
  std::vector<Part> parts_;
  std::vector<float> weights_;
};

// Adds to the sums of the tile's splats what they gave to the pixels that `photograph` shows.
void AddTile(const cv::Rect& area, const TileBlend& blend, const cv::Mat& photograph,
             std::vector<SplatShare>& sums, SplatComparison& comparison) {
  std::array<std::array<Vector3f, kTile>, kTile> difference;
  for (auto& row : difference) row.fill(Vector3f::Zero());
  std::array<std::array<float, kTile>, kTile> counts{};
  const int channels = photograph.channels();
  for (int y = 0; y < area.height; ++y) {
    const std::uint8_t* bgr = photograph.ptr<std::uint8_t>(area.y + y) + channels * area.x;
    for (int x = 0; x < area.width; ++x, bgr += channels) {
      if (channels == 4 && bgr[3] < 255) continue;
      const Vector3f off = Vector3f(bgr[2], bgr[1], bgr[0]) / 255.0f - blend.Color(x, y);
      difference[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = off;
      counts[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = 1;
      comparison.squared_error += static_cast<double>(off.squaredNorm());
      ++comparison.pixels;
    }
  }
  for (const TileBlend::Part& part : blend.parts()) {
    const float* weight = blend.WeightsOf(part);
    SplatShare& sum = sums[part.index];
    for (int y = part.top; y < part.bottom; ++y)
      for (int x = part.left; x < part.right; ++x, ++weight) {
        const auto row = static_cast<std::size_t>(y), column = static_cast<std::size_t>(x);
        sum.weight += *weight * counts[row][column];
        sum.difference += *weight * difference[row][column];
      }
  }
}

// How the picture changes with the opacities and sizes of a tile's splats.
class TileShapes {
 public:
  void Add(const cv::Rect& area, const TileBlend& blend, const cv::Mat& photograph,
           const std::vector<Splat>& splats, std::vector<SplatShare>& sums) {
    Begin(area, blend, photograph);
    for (const TileBlend::Part& part : blend.parts())
      AddPart(part, blend.WeightsOf(part), splats[part.index]);
    const Entry* entry = entries_.data();
    for (const TileBlend::Part& part : blend.parts()) {
      SplatShare& sum = sums[part.index];
      for (int y = part.top; y < part.bottom; ++y)
        for (int x = part.left; x < part.right; ++x, ++entry) {
          sum.shape_slope += entry->off * entry->by_shape;
          sum.shape_curvature += entry->size * At(x, y).sizes * entry->by_shape;
        }
    }
  }

 private:
  struct Pixel {
    Vector3f behind, difference;  // what is drawn from here backwards, and what lacks
    float clear, sizes;           // transmittance from the front; the sum of all derivatives' sizes
    bool counts;
  };
  struct Entry {
    Eigen::Vector2f by_shape;  // the change of alpha
    float size, off;           // of the colour's derivative by alpha; times the difference
  };

  Pixel& At(int x, int y) { return pixels_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)]; }

  void Begin(const cv::Rect& area, const TileBlend& blend, const cv::Mat& photograph) {
    entries_.clear();
    const int channels = photograph.channels();
    for (int y = 0; y < area.height; ++y) {
      const std::uint8_t* bgr = photograph.ptr<std::uint8_t>(area.y + y) + channels * area.x;
      for (int x = 0; x < area.width; ++x, bgr += channels) {
        const Vector3f drawn = blend.Color(x, y);
        At(x, y) = {drawn, Vector3f(bgr[2], bgr[1], bgr[0]) / 255.0f - drawn, 1, 0,
                    channels < 4 || bgr[3] == 255};
      }
    }
  }

  void AddPart(const TileBlend::Part& part, const float* weight, const Splat& splat) {
    const float resized = std::max(0.0f, 1 - 0.5f * kLowPass * (splat.a + splat.c));
    for (int y = part.top; y < part.bottom; ++y)
      for (int x = part.left; x < part.right; ++x, ++weight) {
        Entry& entry = entries_.emplace_back(Entry{Eigen::Vector2f::Zero(), 0, 0});
        if (!(*weight > 0)) continue;
        Pixel& pixel = At(x, y);
        const float alpha = std::min(kMostAlpha, *weight / pixel.clear);
        pixel.behind -= *weight * splat.color;
        const Vector3f by_alpha = pixel.clear * splat.color - pixel.behind / (1 - alpha);
        pixel.clear -= *weight;
        if (!pixel.counts || alpha >= kMostAlpha) continue;
        const float relative = alpha / splat.opacity;
        entry.by_shape = {relative, -2 * alpha * resized * FastLog(relative)};
        entry.size = by_alpha.norm();
        entry.off = by_alpha.dot(pixel.difference);
        pixel.sizes += entry.size * entry.by_shape.sum();
      }
  }

  std::array<std::array<Pixel, kTile>, kTile> pixels_;
  std::vector<Entry> entries_;
};

}  // namespace

SplatPicture DrawSplats(const Gaussians& gaussians, const CameraModel& camera, const Rigid3& cam_from_world) {
  const SplatTiles tiles(gaussians, camera, cam_from_world);
  SplatPicture picture{cv::Mat(camera.height, camera.width, CV_32FC3),
                       cv::Mat(camera.height, camera.width, CV_32F)};
  TileBlend blend;
  tiles.ForEachTile([&](const cv::Rect& area, const std::uint32_t* indices, std::size_t count) {
    blend.Blend(area, indices, count, tiles.splats(), false);
    for (int y = 0; y < area.height; ++y)
      for (int x = 0; x < area.width; ++x) {
        const Vector3f color = blend.Color(x, y);
        picture.srgb.at<cv::Vec3f>(area.y + y, area.x + x) = {color.z(), color.y(), color.x()};
        picture.opacity.at<float>(area.y + y, area.x + x) = 1 - blend.Transmittance(x, y);
      }
  });
  return picture;
}

SplatComparison CompareSplats(const Gaussians& gaussians, const CameraModel& camera,
                              const Rigid3& cam_from_world, const cv::Mat& photograph, bool with_shapes) {
  const SplatTiles tiles(gaussians, camera, cam_from_world);
  SplatComparison comparison;
  std::vector<SplatShare> sums(tiles.splats().size());
  TileBlend blend;
  TileShapes shapes;
  tiles.ForEachTile([&](const cv::Rect& area, const std::uint32_t* indices, std::size_t count) {
    blend.Blend(area, indices, count, tiles.splats(), true);
    AddTile(area, blend, photograph, sums, comparison);
    if (with_shapes) shapes.Add(area, blend, photograph, tiles.splats(), sums);
  });
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (!(sums[i].weight > 0)) continue;
    sums[i].gaussian = tiles.splats()[i].gaussian;
    comparison.shares.push_back(sums[i]);
  }
  return comparison;
}

}  // namespace ulf::render
