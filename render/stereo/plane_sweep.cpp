#include "render/stereo/plane_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "core/geometry/pinhole.h"

namespace ulf::render {
namespace {

constexpr int kAroundPx = 6;      // surroundings of a tile
constexpr int kAroundPlanes = 3;  // on either side of a chosen plane
// At half the size a pixel's best plane counts as well as the chosen one, up to this cost, if enough of its
// nine-pixel neighbourhood prefer it, too.
constexpr float kLikedCost = 0.65f;
constexpr int kLikedBy = 3;

bool IsGivenUp(const SweepOptions& options) { return options.given_up && options.given_up->load(); }

using Eigen::Matrix3f;
using Eigen::Vector3f;

struct Carrier : PlaneCarrier {
  const StereoView* neighbour;
};

constexpr float kUnseen = 4.0f;  // above any cost, which is at most 2

// Rows are processed in whole groups of pixels; no result depends on values beyond their end.
constexpr int kGroup = 8;
constexpr int WholeGroups(int pixels) { return (pixels + kGroup - 1) / kGroup * kGroup; }

// Plain arrays and windows of fixed size let the compiler process a group at a time.
template <int kRadius>
class Matcher {
 public:
  Matcher(const cv::Mat& grey, double noise)
      : width_(grey.cols), height_(grey.rows), floor_(static_cast<float>(noise * noise * kArea)) {
    cv::copyMakeBorder(grey, padded_, kRadius, kRadius, kRadius, kRadius + kGroup, cv::BORDER_REPLICATE);
    sum_ = cv::Mat(height_, WholeGroups(width_) + kGroup, CV_32F, cv::Scalar(0));
    spread_ = cv::Mat(sum_.size(), CV_32F, cv::Scalar(1));
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        float sum = 0, square = 0;
        for (int dy = 0; dy < kSide; ++dy)
          for (int dx = 0; dx < kSide; ++dx) {
            const float value = padded_.at<float>(y + dy, x + dx);
            sum += value;
            square += value * value;
          }
        sum_.at<float>(y, x) = sum;
        spread_.at<float>(y, x) = std::max(0.0f, square - sum * sum / kArea) + floor_;
      }
    const std::size_t wide = static_cast<std::size_t>(WholeGroups(width_ + 2 * kRadius) + kGroup);
    offset_.resize(wide);
    for (auto* row : {&right_share_, &lower_share_, &carried_}) row->resize(wide);
    for (auto* pairs : {&above_, &below_}) pairs->resize(2 * wide);
    for (auto& row : ring_)
      for (auto& sums : row) sums.resize(wide);
  }

  // The part of the image that is compared.
  struct Part {
    int left, right, top, bottom;  // from the first to before the last
    int width() const { return right - left; }
  };
  // Writes the costs of the part's pixels, row by row, and up to a group beyond the last. Rows and columns of
  // the window outside the image repeat its edge.
  void Match(const Carrier& carrier, float inverse_depth, const Part& part, float* costs) {
    Matrix3f h = carrier.at_infinity;
    h.col(2) += inverse_depth * carrier.per_inverse_depth;
    for (int y = part.top - kRadius; y < part.bottom + kRadius; ++y) {
      Carry(carrier.neighbour->grey, h, y, part);
      SumAlongRow(y, part);
      if (y >= part.top + kRadius)
        Compare(y - kRadius, carrier.neighbour->grey, h, part,
                costs + (y - kRadius - part.top) * part.width());
    }
  }

 private:
  static constexpr int kSide = 2 * kRadius + 1;
  static constexpr float kArea = kSide * kSide;
  using Row = std::vector<float>;

  // Samples a row of this view's image from the neighbour through the plane.
  void Carry(const cv::Mat& image, const Matrix3f& h, int y, const Part& part) {
    const int wide = WholeGroups(part.width() + 2 * kRadius);
    const Vector3f start = h * Vector3f(0.5f - kRadius + static_cast<float>(part.left),
                                        static_cast<float>(std::clamp(y, 0, height_ - 1)) + 0.5f, 1.0f);
    const float x0 = start.x(), y0 = start.y(), z0 = start.z(), dx = h(0, 0), dy = h(1, 0), dz = h(2, 0);
    const float right = static_cast<float>(image.cols) - 1.001f,
                bottom = static_cast<float>(image.rows) - 1.001f;
    const int stride = static_cast<int>(image.step1());
    int* __restrict offset = offset_.data();
    float* __restrict right_share = right_share_.data();
    float* __restrict lower_share = lower_share_.data();
    for (int x = 0; x < wide; ++x) {
      const float t = static_cast<float>(x);
      const float z = z0 + t * dz;
      const float per_z = 1.0f / (z > 1e-6f ? z : 1e-6f);
      right_share[x] = (x0 + t * dx) * per_z - 0.5f;
      lower_share[x] = (y0 + t * dy) * per_z - 0.5f;
    }
    for (int x = 0; x < wide; ++x) {
      const float u = std::min(std::max(right_share[x], 0.0f), right);
      const float v = std::min(std::max(lower_share[x], 0.0f), bottom);
      const int left = static_cast<int>(u), top = static_cast<int>(v);
      right_share[x] = u - static_cast<float>(left);
      lower_share[x] = v - static_cast<float>(top);
      offset[x] = top * stride + left;
    }
    const float* __restrict pixels = image.ptr<float>();
    const float* __restrict pixels_below = pixels + stride;
    float* __restrict carried = carried_.data();
    // The four pixels around are copied one by one; eight means at a time are computed from them.
    float* __restrict above = above_.data();
    float* __restrict below = below_.data();
    for (int x = 0; x < wide; ++x) {
      std::memcpy(above + 2 * x, pixels + offset[x], 2 * sizeof(float));
      std::memcpy(below + 2 * x, pixels_below + offset[x], 2 * sizeof(float));
    }
    for (int x = 0; x < wide; ++x) {
      const float upper = above[2 * x] + right_share[x] * (above[2 * x + 1] - above[2 * x]);
      const float lower = below[2 * x] + right_share[x] * (below[2 * x + 1] - below[2 * x]);
      carried[x] = upper + lower_share[x] * (lower - upper);
    }
  }

  void SumAlongRow(int y, const Part& part) {
    auto& row = ring_[static_cast<std::size_t>((y + kSide) % kSide)];
    const float* __restrict own = padded_.ptr<float>(std::clamp(y, 0, height_ - 1) + kRadius) + part.left;
    const float* __restrict carried = carried_.data();
    float* __restrict value = row[0].data();
    float* __restrict square = row[1].data();
    float* __restrict product = row[2].data();
    const int width = WholeGroups(part.width());
    for (int x = 0; x < width; ++x) {
      float v = 0, s = 0, p = 0;
      for (int d = 0; d < kSide; ++d) {
        const float c = carried[x + d];
        v += c;
        s += c * c;
        p += c * own[x + d];
      }
      value[x] = v;
      square[x] = s;
      product[x] = p;
    }
  }

  void Compare(int y, const cv::Mat& image, const Matrix3f& h, const Part& part,
               float* __restrict costs) const {
    std::array<const float*, kSide> values, squares, products;
    for (std::size_t i = 0; i < kSide; ++i) {
      values[i] = ring_[i][0].data();
      squares[i] = ring_[i][1].data();
      products[i] = ring_[i][2].data();
    }
    const float* __restrict own_sum = sum_.ptr<float>(y) + part.left;
    const float* __restrict own_spread = spread_.ptr<float>(y) + part.left;
    const Vector3f start =
        h * Vector3f(0.5f + static_cast<float>(part.left), static_cast<float>(y) + 0.5f, 1.0f);
    const float x0 = start.x(), y0 = start.y(), z0 = start.z(), dx = h(0, 0), dy = h(1, 0), dz = h(2, 0);
    const float right = static_cast<float>(image.cols), bottom = static_cast<float>(image.rows);
    const float floor = floor_;
    const int width = WholeGroups(part.width());
    for (int x = 0; x < width; ++x) {
      float value = 0, square = 0, product = 0;
      for (std::size_t i = 0; i < kSide; ++i) {
        value += values[i][x];
        square += squares[i][x];
        product += products[i][x];
      }
      const float covariance = product - value * own_sum[x] * (1 / kArea);
      const float variance = square - value * value * (1 / kArea);
      const float spread = (variance > 0 ? variance : 0.0f) + floor;
      const float cost = 1.0f - covariance / std::sqrt(spread * own_spread[x]);
      const float t = static_cast<float>(x);
      const float z = z0 + t * dz, u = x0 + t * dx, v = y0 + t * dy;
      const bool inside = (z > 1e-6f) & (u > 0) & (v > 0) & (u < right * z) & (v < bottom * z);
      costs[x] = inside ? cost : kUnseen;
    }
  }

  int width_, height_;
  float floor_;
  cv::Mat padded_, sum_, spread_;
  std::vector<int> offset_;
  Row right_share_, lower_share_, above_, below_, carried_;
  // The window's rows hold values, squares, and products with the view.
  std::array<std::array<Row, 3>, kSide> ring_;
};

constexpr int kMostKept = 16;  // half of 32 neighbours, the most of `ulf proxy`

// Computes the mean of the better half of the neighbours, without those that do not see the pixel; the
// truncation if none sees it.
void MeanOfBetterHalf(const std::vector<std::vector<float>>& costs, std::size_t pixels, float truncation,
                      float* mean) {
  constexpr std::size_t kBlock = 512;
  const std::size_t keep = static_cast<std::size_t>(KeptNeighbours(costs.size()));
  std::array<std::array<float, kBlock>, kMostKept> best;
  std::array<float, kBlock> rest;
  for (std::size_t first = 0; first < pixels; first += kBlock) {
    const std::size_t count = std::min(kBlock, pixels - first);
    const std::size_t wide = static_cast<std::size_t>(WholeGroups(static_cast<int>(count)));
    for (std::size_t k = 0; k < keep; ++k) std::fill_n(best[k].data(), wide, kUnseen);
    for (const auto& of_neighbour : costs) {
      std::copy_n(of_neighbour.data() + first, count, rest.data());
      std::fill_n(rest.data() + count, wide - count, kUnseen);
      for (std::size_t k = 0; k < keep; ++k) {
        float* __restrict kept = best[k].data();
        float* __restrict other = rest.data();
        for (std::size_t i = 0; i < wide; ++i) {
          const float a = kept[i], b = other[i];
          kept[i] = a < b ? a : b;
          other[i] = a < b ? b : a;
        }
      }
    }
    std::array<float, kBlock> sum{}, seen{};
    for (std::size_t k = 0; k < keep; ++k) {
      const float* __restrict cost = best[k].data();
      for (std::size_t i = 0; i < wide; ++i) {
        const float cut = cost[i] < truncation ? cost[i] : truncation;
        sum[i] += cost[i] < kUnseen ? cut : 0.0f;
        seen[i] += cost[i] < kUnseen ? 1.0f : 0.0f;
      }
    }
    for (std::size_t i = 0; i < count; ++i) mean[first + i] = seen[i] > 0 ? sum[i] / seen[i] : truncation;
  }
}

// Finds parts of rows whose tiles all need a plane.
template <typename Wants>
std::vector<std::pair<int, int>> RunsOf(int tiles, const Wants& wants) {
  std::vector<std::pair<int, int>> runs;  // the first tile and the one after the last
  for (int tile = 0; tile < tiles; ++tile) {
    if (!wants(tile)) continue;
    if (!runs.empty() && runs.back().second == tile)
      ++runs.back().second;
    else
      runs.emplace_back(tile, tile + 1);
  }
  return runs;
}

template <int kRadius>
CostVolume FillVolume(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                      const InverseDepthRange& range, const SweepOptions& options,
                      const PlanesOfTiles* compared) {
  using Part = typename Matcher<kRadius>::Part;
  const int width = view.grey.cols, height = view.grey.rows;
  const auto truncation = static_cast<float>(options.truncation);
  CostVolume volume(width, height, range.planes);
  std::vector<Carrier> carriers;
  for (const StereoView* neighbour : neighbours)
    carriers.push_back({MakePlaneCarrier(view, *neighbour), neighbour});
  Matcher<kRadius> matcher(view.grey, options.noise);
  // Number of rows, or tiles, whose part of the volume stays in the processor's cache while all planes are
  // written into it.
  constexpr int kTilesAbreast = 4;
  constexpr long kCacheBytes = 2'000'000;
  constexpr int kFewestRows = 8, kMostRows = 64;
  const int band = compared
                       ? compared->tile_px()
                       : std::clamp(static_cast<int>(kCacheBytes / (static_cast<long>(width) * range.planes)),
                                    kFewestRows, kMostRows);
  std::vector<std::vector<float>> costs(carriers.size(),
                                        std::vector<float>(static_cast<std::size_t>(width * band + kGroup)));
  std::vector<float> mean(static_cast<std::size_t>(width * band));
  const auto compare = [&](int plane, const Part& part) {
    const float inverse_depth = static_cast<float>(range.At(plane));
    for (std::size_t i = 0; i < carriers.size(); ++i)
      matcher.Match(carriers[i], inverse_depth, part, costs[i].data());
    const std::size_t pixels =
        static_cast<std::size_t>(part.width()) * static_cast<std::size_t>(part.bottom - part.top);
    MeanOfBetterHalf(costs, pixels, truncation, mean.data());
    const float* cost = mean.data();
    for (int y = part.top; y < part.bottom; ++y) {
      std::uint8_t* out = volume.At(part.left, y) + plane;
      for (int x = part.left; x < part.right; ++x, out += volume.stride()) *out = CostByte(*cost++);
    }
  };
  for (int first = 0, row = 0; first < height && !IsGivenUp(options); first += band, ++row) {
    const int end = std::min(height, first + band);
    if (!compared) {
      for (int plane = 0; plane < range.planes; ++plane) compare(plane, {0, width, first, end});
      continue;
    }
    for (int y = first; y < end; ++y)
      for (int x = 0; x < width; ++x) std::fill_n(volume.At(x, y), range.planes, CostByte(truncation));
    for (int column = 0; column < compared->columns(); column += kTilesAbreast) {
      const int columns = std::min(kTilesAbreast, compared->columns() - column);
      for (int plane = 0; plane < range.planes; ++plane)
        for (const auto& [from, to] :
             RunsOf(columns, [&](int i) { return compared->Has(column + i, row, plane); }))
          compare(plane, {(column + from) * band, std::min(width, (column + to) * band), first, end});
    }
  }
  return volume;
}

// Returns CV_32F.
cv::Mat ChosenPlanes(const CostVolume& volume, const StereoView& view, const SweepOptions& options) {
  return SemiGlobalMinimum(volume, view.grey,
                           {.small_step = static_cast<int>(options.small_step * kCostUnit),
                            .large_step = static_cast<int>(options.large_step * kCostUnit),
                            .edge_grey = static_cast<float>(options.edge_grey)});
}

// Returns the plane of least cost at a pixel, regardless of its neighbours.
int OwnBest(const CostVolume& volume, int x, int y) {
  const std::uint8_t* cost = volume.At(x, y);
  return static_cast<int>(std::min_element(cost, cost + volume.labels()) - cost);
}

// Returns each pixel's own best plane; -1 if even that costs too much.
cv::Mat_<int> LikedPlanes(const CostVolume& volume) {
  const int most = CostByte(kLikedCost);
  cv::Mat_<int> liked(volume.height(), volume.width(), -1);
  for (int y = 0; y < liked.rows; ++y)
    for (int x = 0; x < liked.cols; ++x)
      if (const int best = OwnBest(volume, x, y); volume.At(x, y)[best] <= most) liked(y, x) = best;
  return liked;
}

// Counts the pixels in the nine-pixel neighbourhood that prefer this pixel's plane or one beside it.
int CountLikingPlane(const cv::Mat_<int>& liked, int x, int y) {
  int count = 0;
  for (int v = std::max(0, y - 1); v <= std::min(liked.rows - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(liked.cols - 1, x + 1); ++u)
      count += liked(v, u) >= 0 && std::abs(liked(v, u) - liked(y, x)) <= 1;
  return count;
}

}  // namespace

PlaneCarrier MakePlaneCarrier(const StereoView& view, const StereoView& neighbour) {
  const Rigid3 neighbour_from_view = neighbour.cam_from_world * view.cam_from_world.Inverse();
  const Eigen::Matrix3d to = PinholeMatrix(neighbour.camera), from = PinholeMatrix(view.camera);
  return {(to * neighbour_from_view.RotationMatrix() * from.inverse()).cast<float>(),
          (to * neighbour_from_view.translation).cast<float>()};
}

int KeptNeighbours(std::size_t neighbours) {
  return std::clamp((static_cast<int>(neighbours) + 1) / 2, 1, kMostKept);
}

std::uint8_t CostByte(float cost) { return static_cast<std::uint8_t>(cost * kCostUnit + 0.5f); }

PlanesOfTiles::PlanesOfTiles(const cv::Size& image, int tile_px, int planes)
    : tile_px_(tile_px),
      columns_((image.width + tile_px - 1) / tile_px),
      rows_((image.height + tile_px - 1) / tile_px),
      planes_(planes),
      has_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) *
               static_cast<std::size_t>(planes),
           0) {}

void PlanesOfTiles::Add(int column, int row, int first_plane, int last_plane) {
  for (int plane = std::max(0, first_plane); plane <= std::min(planes_ - 1, last_plane); ++plane)
    has_[Index(column, row, plane)] = 1;
}

double PlanesOfTiles::Share() const {
  return static_cast<double>(std::ranges::count(has_, 1)) / static_cast<double>(has_.size());
}

// Returns none if all planes are compared.
static std::optional<PlanesOfTiles> PlanesToCompare(const StereoView& view,
                                                    const std::vector<const StereoView*>& neighbours,
                                                    const InverseDepthRange& range,
                                                    const SweepOptions& options) {
  if (options.coarse_from_px <= 0 || std::max(view.grey.cols, view.grey.rows) < options.coarse_from_px)
    return std::nullopt;
  return PlanesNearSurfaces(view, neighbours, range, options);
}

PlanesOfTiles PlanesNearSurfaces(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                                 const InverseDepthRange& range, const SweepOptions& options) {
  const StereoView half = HalfSize(view);
  std::vector<StereoView> half_neighbours;
  for (const StereoView* neighbour : neighbours) half_neighbours.push_back(HalfSize(*neighbour));
  std::vector<const StereoView*> pointers;
  for (const StereoView& neighbour : half_neighbours) pointers.push_back(&neighbour);
  InverseDepthRange coarse = range;
  coarse.planes = (range.planes + 1) / 2;
  const auto compared = PlanesToCompare(half, pointers, coarse, options);
  PlanesOfTiles near(view.grey.size(), options.tile_px, range.planes);
  if (IsGivenUp(options)) return near;
  const CostVolume volume = MatchingCosts(half, pointers, coarse, options, compared ? &*compared : nullptr);
  if (IsGivenUp(options)) return near;
  const cv::Mat chosen = ChosenPlanes(volume, half, options);
  const double fine_per_coarse = static_cast<double>(range.planes - 1) / (coarse.planes - 1);
  const auto add = [&](int x, int y, double plane) {  // px of the half-size image
    const int at = static_cast<int>(std::lround(plane * fine_per_coarse));
    const auto tiles = [&](int middle, int tiles_there) {
      return std::pair(std::clamp((2 * middle - kAroundPx) / options.tile_px, 0, tiles_there - 1),
                       std::clamp((2 * middle + 1 + kAroundPx) / options.tile_px, 0, tiles_there - 1));
    };
    const auto [left, right] = tiles(x, near.columns());
    const auto [top, bottom] = tiles(y, near.rows());
    for (int row = top; row <= bottom; ++row)
      for (int column = left; column <= right; ++column)
        near.Add(column, row, at - kAroundPlanes, at + kAroundPlanes);
  };
  const cv::Mat_<int> liked = LikedPlanes(volume);
  for (int y = 0; y < chosen.rows; ++y)
    for (int x = 0; x < chosen.cols; ++x) {
      add(x, y, chosen.at<float>(y, x));
      if (liked(y, x) >= 0 && CountLikingPlane(liked, x, y) >= kLikedBy) add(x, y, liked(y, x));
    }
  return near;
}

CostVolume MatchingCosts(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                         const InverseDepthRange& range, const SweepOptions& options,
                         const PlanesOfTiles* compared) {
  return options.window_radius_px <= 1   ? FillVolume<1>(view, neighbours, range, options, compared)
         : options.window_radius_px == 2 ? FillVolume<2>(view, neighbours, range, options, compared)
                                         : FillVolume<3>(view, neighbours, range, options, compared);
}

DepthMap SweepPlanes(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                     const InverseDepthRange& range, const SweepOptions& options) {
  const auto compared = PlanesToCompare(view, neighbours, range, options);
  if (IsGivenUp(options)) return {};
  const CostVolume volume = MatchingCosts(view, neighbours, range, options, compared ? &*compared : nullptr);
  if (IsGivenUp(options)) return {};
  return DepthOfLeastCost(volume, view, range, options);
}

DepthMap DepthOfLeastCost(const CostVolume& volume, const StereoView& view, const InverseDepthRange& range,
                          const SweepOptions& options) {
  const cv::Mat plane = ChosenPlanes(volume, view, options);
  DepthMap map{cv::Mat::zeros(view.grey.size(), CV_32F), cv::Mat::zeros(view.grey.size(), CV_32F)};
  for (int y = 0; y < view.grey.rows; ++y)
    for (int x = 0; x < view.grey.cols; ++x) {
      if (!view.valid.empty() && view.valid.at<std::uint8_t>(y, x) == 0) continue;
      const float at = plane.at<float>(y, x);
      // A least cost at the end of the range is no minimum: it may be lower beyond.
      if (at < 0.5f || at > static_cast<float>(range.planes) - 1.5f) continue;
      map.depth.at<float>(y, x) = static_cast<float>(1 / range.At(at));
      map.agreement.at<float>(y, x) = 1 - static_cast<float>(volume.At(x, y)[std::lround(at)]) / kCostUnit;
    }
  return map;
}

}  // namespace ulf::render
