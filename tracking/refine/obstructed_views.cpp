#include "tracking/refine/obstructed_views.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <utility>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/geometry/triangulation.h"
#include "tracking/estimation/two_view_motion.h"
#include "tracking/features/patch_alignment.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Settled on the simulator, llff_fern, temple_ring and fox_half; reported on others
// (docs/measured/tracking.md, "Views taken through a hand").
constexpr double kAgreeSigmas = 4;          // of corners about which two neighbours agree
constexpr double kMostSearchPx = 10;        // a less certain place tells nothing
constexpr double kMostAngleDeg = 25;        // between the directions from which two views see a point
constexpr double kMostScale = 1.8;          // of a patch from view to view
constexpr int kPatchPx = 15;                // side of a compared patch
constexpr double kLeastCorrelation = 0.65;  // normalised
constexpr int kAlikeBits = 60;              // of descriptors
constexpr int kObstructionColumns = 32;     // cells of the picture; they are square
constexpr int kMostInCell = 3;              // corners of a cell that are looked for
constexpr double kBlurCells = 1.25;         // over which cells are counted together
constexpr double kLeastCount = 3;           // corners around a cell that is judged
// Shares of the usual share of confirmed corners: cells below the first are without agreement, above the
// second they agree.
constexpr double kWithoutShare = 0.4, kAgreeingShare = 0.6;
constexpr double kLeastPartShare = 0.04;  // of the picture: a smaller part may be hidden by the scene itself
constexpr double kLeastPartCorners = 10;
constexpr double kMostChance = 1e-4;  // that as few are confirmed where nothing stands before the lens
// Corners there that the view shows and a neighbour agrees with, over those that it should show: from this
// share on the scene itself hides these.
constexpr double kHidingShare = 0.25;
constexpr double kLeastAgreeingShare = 0.01;  // of the picture
constexpr int kLeastAgreeingCorners = 6;

// A corner of two views, and where it would be if one of them were off by its sigma.
struct PairCorner {
  std::array<int, 2> view{}, corner{};
  Vector3d in_world = Vector3d::Zero(), off_in_world = Vector3d::Zero();
};

std::vector<PairCorner> PlacedCornersOf(const RefineScene& scene, const UnguidedPair& pair,
                                        std::span<const double> sigma_px) {
  const RefineView &one = scene.view(pair.first), &other = scene.view(pair.second);
  const double sigma = std::hypot(sigma_px[At(pair.first)], sigma_px[At(pair.second)]) / std::sqrt(2.0);
  const double angle = sigma * std::sqrt(2.0) / scene.LensOf(one).MeanFocalPx();
  const Vector3d towards_other = one.cam_from_world * other.cam_from_world.OriginInSource();
  std::vector<PairCorner> corners;
  for (std::size_t m = 0; m < pair.matches.size(); ++m) {
    if (pair.errors_px[m] > kAgreeSigmas * sigma) continue;
    const auto [first, second, distance] = pair.matches[m];
    const Vector3d &ray = one.features[first].ray, &other_ray = other.features[second].ray;
    const Vector3d across = towards_other - towards_other.dot(ray) * ray;
    if (!(across.norm() > 0)) continue;
    const auto point = TriangulatePoint(one.cam_from_world, ray, other.cam_from_world, other_ray);
    const auto off = TriangulatePoint(one.cam_from_world, (ray - angle * across.normalized()).normalized(),
                                      other.cam_from_world, other_ray);
    if (point && off) corners.push_back({{pair.first, pair.second}, {first, second}, *point, *off});
  }
  return corners;
}

// A corner that a view should show.
struct ExpectedCorner {
  Vector2d img;
  double radius_px = 0;
  int from = 0;         // the view that shows it under the most similar angle
  int from_corner = 0;  // its corner there
  Vector3d in_world;
};

class ObstructionSearch {
 public:
  ObstructionSearch(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                    std::span<const double> sigma_px, const std::vector<bool>& takes_part)
      : scene_(scene), sigma_px_(sigma_px), takes_part_(takes_part), near_(scene.views.size()) {
    for (const UnguidedPair& pair : pairs) {
      near_[At(pair.first)].insert(pair.second);
      near_[At(pair.second)].insert(pair.first);
    }
    corners_.resize(pairs.size());
    ParallelFor(pairs.size(), [&](std::size_t p) {
      if (takes_part[At(pairs[p].first)] && takes_part[At(pairs[p].second)])
        corners_[p] = PlacedCornersOf(scene, pairs[p], sigma_px);
    });
    smooth_.resize(scene.views.size());
    ParallelFor(smooth_.size(), [&](std::size_t v) {
      if (!scene.views[v].gray.empty()) cv::GaussianBlur(scene.views[v].gray, smooth_[v], {}, 1);
    });
  }

  // Counts by cell (CV_32F each) expected corners, those of them that are confirmed, and the view's own
  // corners about which it agrees with a neighbour.
  struct Counts {
    cv::Mat expected, confirmed, own;
    double ConfirmedShare() const { return cv::sum(confirmed)[0] / std::max(1.0, cv::sum(expected)[0]); }
  };
  Counts CountIn(int view, const cv::Mat& mask) const {
    const CameraModel& lens = scene_.LensOf(scene_.view(view));
    const int rows =
        std::max(1, static_cast<int>(std::lround(1.0 * kObstructionColumns * lens.height / lens.width)));
    Counts counts{cv::Mat::zeros(rows, kObstructionColumns, CV_32F),
                  cv::Mat::zeros(rows, kObstructionColumns, CV_32F), OwnCorners(view, rows)};
    std::set<std::pair<int, int>> known;  // views and their corners
    for (const std::vector<PairCorner>& corners : corners_)
      for (const PairCorner& corner : corners) {
        if (!near_[At(view)].contains(corner.view[0]) || !near_[At(view)].contains(corner.view[1])) break;
        if (known.contains({corner.view[0], corner.corner[0]}) ||
            known.contains({corner.view[1], corner.corner[1]}))
          continue;
        const auto expected = ExpectIn(view, corner);
        if (!expected || IsMasked(mask, lens, expected->img)) continue;
        const auto row =
            static_cast<int>(CellOf(expected->img, lens, kObstructionColumns, rows)) / kObstructionColumns;
        const auto column =
            static_cast<int>(CellOf(expected->img, lens, kObstructionColumns, rows)) % kObstructionColumns;
        if (counts.expected.at<float>(row, column) >= kMostInCell) continue;
        const std::optional<bool> shows = Shows(view, *expected);
        if (!shows) continue;
        for (const int i : {0, 1}) known.insert({corner.view[At(i)], corner.corner[At(i)]});
        counts.expected.at<float>(row, column) += 1;
        counts.confirmed.at<float>(row, column) += *shows ? 1 : 0;
      }
    return counts;
  }

 private:
  cv::Mat OwnCorners(int view, int rows) const {
    cv::Mat own = cv::Mat::zeros(rows, kObstructionColumns, CV_32F);
    std::set<int> known;
    for (const std::vector<PairCorner>& corners : corners_)
      for (const PairCorner& corner : corners) {
        if (corner.view[0] != view && corner.view[1] != view) break;
        const int i = corner.corner[corner.view[0] == view ? 0 : 1];
        if (!known.insert(i).second) continue;
        const auto cell = static_cast<int>(CellOf(
            scene_.view(view).features[i].img, scene_.LensOf(scene_.view(view)), kObstructionColumns, rows));
        float& count = own.at<float>(cell / kObstructionColumns, cell % kObstructionColumns);
        count = std::min(count + 1, static_cast<float>(kMostInCell));
      }
    return own;
  }

  static bool IsMasked(const cv::Mat& mask, const CameraModel& lens, const Vector2d& img) {
    if (mask.empty()) return false;
    const int x = std::clamp(static_cast<int>(img.x() * mask.cols / lens.width), 0, mask.cols - 1),
              y = std::clamp(static_cast<int>(img.y() * mask.rows / lens.height), 0, mask.rows - 1);
    return mask.at<std::uint8_t>(y, x) == 0;
  }

  std::optional<ExpectedCorner> ExpectIn(int view, const PairCorner& corner) const {
    const RefineView& own = scene_.view(view);
    const CameraModel& lens = scene_.LensOf(own);
    const Vector3d in_cam = own.cam_from_world * corner.in_world;
    if (!(in_cam.z() > 0)) return std::nullopt;
    const auto img = lens.ImgFromCam(in_cam), off = lens.ImgFromCam(own.cam_from_world * corner.off_in_world);
    if (!img || !off) return std::nullopt;
    const double radius = 1 + kAgreeSigmas * std::hypot(sigma_px_[At(view)], (*img - *off).norm());
    const double margin = 2 + kPatchPx / 2 + radius;
    if (!(radius < kMostSearchPx) || img->x() < margin || img->y() < margin ||
        img->x() > lens.width - margin || img->y() > lens.height - margin)
      return std::nullopt;
    const Vector3d center = own.cam_from_world.OriginInSource();
    std::array<double, 2> angles{};
    for (const int i : {0, 1})
      angles[At(i)] =
          AngleBetween(corner.in_world - center,
                       corner.in_world - scene_.view(corner.view[At(i)]).cam_from_world.OriginInSource());
    const std::size_t from = angles[0] <= angles[1] ? 0 : 1;
    if (Degrees(angles[from]) > kMostAngleDeg) return std::nullopt;
    return ExpectedCorner{*img, radius, corner.view[from], corner.corner[from], corner.in_world};
  }

  // Returns none where the patch cannot be compared.
  std::optional<bool> Shows(int view, const ExpectedCorner& expected) const {
    const RefineView &own = scene_.view(view), &other = scene_.view(expected.from);
    const Feature& corner = other.features[expected.from_corner];
    const auto axes = AxesOf(scene_.LensOf(other), other.cam_from_world, expected.in_world, 0);
    Eigen::Matrix<double, 2, 3> img_by_point;
    if (!axes || !scene_.LensOf(own).ImgFromCam(own.cam_from_world * expected.in_world, &img_by_point))
      return std::nullopt;
    const Eigen::Matrix2d own_by_other = img_by_point * own.cam_from_world.RotationMatrix() * *axes;
    const double scale = std::sqrt(std::abs(own_by_other.determinant()));
    if (!(scale > 1 / kMostScale && scale < kMostScale)) return std::nullopt;
    bool is_alike = false;
    own.features.ForEachNear(expected.img, expected.radius_px, 0, kPyramidLevels - 1, [&](int i) {
      is_alike = is_alike || Distance(own.features[i].descriptor, corner.descriptor) <= kAlikeBits;
    });
    if (is_alike) return true;
    const Eigen::Matrix2d back = own_by_other.inverse();
    const Vector2d middle = corner.img - Vector2d(0.5, 0.5) - back * Vector2d::Constant(kPatchPx / 2);
    if (middle.x() < 0) return std::nullopt;
    cv::Mat patch, likeness;
    cv::warpAffine(smooth_[At(expected.from)], patch,
                   cv::Matx23d(back(0, 0), back(0, 1), middle.x(), back(1, 0), back(1, 1), middle.y()),
                   {kPatchPx, kPatchPx}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
    const int reach = static_cast<int>(std::ceil(expected.radius_px)), side = kPatchPx + 2 * reach;
    const cv::Rect window(static_cast<int>(std::floor(expected.img.x())) - side / 2,
                          static_cast<int>(std::floor(expected.img.y())) - side / 2, side, side);
    const cv::Mat& picture = smooth_[At(view)];
    if ((window & cv::Rect({}, picture.size())) != window) return std::nullopt;
    cv::matchTemplate(picture(window), patch, likeness, cv::TM_CCOEFF_NORMED);
    double most = 0;
    cv::minMaxLoc(likeness, nullptr, &most);
    return most >= kLeastCorrelation;
  }

  const RefineScene& scene_;
  const std::span<const double> sigma_px_;
  const std::vector<bool>& takes_part_;
  std::vector<std::set<int>> near_;               // by view
  std::vector<std::vector<PairCorner>> corners_;  // by pair
  std::vector<cv::Mat> smooth_;                   // by view
};

// Returns cells (CV_8U) that have enough corners, and of these whose confirmed share `passes`.
template <typename Passes>
cv::Mat CellsWhere(const ObstructionSearch::Counts& counts, const Passes& passes) {
  cv::Mat expected, confirmed, cells = cv::Mat::zeros(counts.expected.size(), CV_8U);
  cv::GaussianBlur(counts.expected, expected, {}, kBlurCells, 0, cv::BORDER_CONSTANT);
  cv::GaussianBlur(counts.confirmed, confirmed, {}, kBlurCells, 0, cv::BORDER_CONSTANT);
  const double counted_together = 4 * M_PI * kBlurCells * kBlurCells;
  for (int y = 0; y < cells.rows; ++y)
    for (int x = 0; x < cells.cols; ++x) {
      const double around = expected.at<float>(y, x);
      if (around * counted_together >= kLeastCount && passes(confirmed.at<float>(y, x) / around))
        cells.at<std::uint8_t>(y, x) = 255;
    }
  return cells;
}

double ShareOf(const cv::Mat& cells) {
  return static_cast<double>(cv::countNonZero(cells)) / static_cast<double>(cells.total());
}

double SumIn(const cv::Mat& counts, const cv::Mat& cells) {
  cv::Mat chosen = cv::Mat::zeros(counts.size(), CV_32F);
  counts.copyTo(chosen, cells);
  return cv::sum(chosen)[0];
}

// Returns the chance that at most `confirmed` of `expected` corners are, each with the chance `usual`.
double ChanceOfSoFew(double confirmed, double expected, double usual) {
  const auto of_count = [](double count) { return std::lgamma(count + 1); };
  double chance = 0;
  for (double k = 0; k <= confirmed; ++k)
    chance += std::exp(of_count(expected) - of_count(k) - of_count(expected - k) + k * std::log(usual) +
                       (expected - k) * std::log1p(-usual));
  return chance;
}

// Returns the share of the picture that large parts without agreement have.
double LargeParts(const ObstructionSearch::Counts& counts, const cv::Mat& without, double usual) {
  cv::Mat labels;
  const int parts = cv::connectedComponents(without, labels, 8, CV_32S);
  double share = 0;
  for (int i = 1; i < parts; ++i) {
    const cv::Mat part = labels == i;
    const double expected = SumIn(counts.expected, part), confirmed = SumIn(counts.confirmed, part);
    if (ShareOf(part) >= kLeastPartShare && expected >= kLeastPartCorners &&
        confirmed < kWithoutShare * usual * expected &&
        ChanceOfSoFew(confirmed, expected, usual) < kMostChance &&
        SumIn(counts.own, part) < kHidingShare * expected)
      share += ShareOf(part);
  }
  return share;
}

}  // namespace

std::vector<ObstructedView> FindObstructedViews(const RefineScene& scene,
                                                const std::vector<UnguidedPair>& pairs,
                                                std::span<const double> sigma_px,
                                                const std::vector<bool>& takes_part,
                                                const std::function<cv::Mat(int view)>& read_mask) {
  const ObstructionSearch search(scene, pairs, sigma_px, takes_part);
  std::vector<ObstructionSearch::Counts> counts(scene.views.size());
  ParallelFor(counts.size(), [&](std::size_t v) {
    const int view = static_cast<int>(v);
    if (takes_part[v]) counts[v] = search.CountIn(view, read_mask ? read_mask(view) : cv::Mat());
  });
  std::vector<double> shares;
  for (const ObstructionSearch::Counts& each : counts)
    if (!each.expected.empty() && cv::sum(each.expected)[0] >= kLeastPartCorners)
      shares.push_back(each.ConfirmedShare());
  std::vector<ObstructedView> obstructed;
  if (shares.empty()) return obstructed;
  constexpr double kMostUsual = 0.95;  // some corners are missed by chance
  const double usual = std::min(kMostUsual, Median(std::move(shares)));
  for (std::size_t v = 0; v < counts.size(); ++v) {
    if (counts[v].expected.empty()) continue;
    const cv::Mat without =
        CellsWhere(counts[v], [&](double share) { return share < kWithoutShare * usual; });
    const cv::Mat agreeing =
        CellsWhere(counts[v], [&](double share) { return share > kAgreeingShare * usual; });
    const ObstructedView found{static_cast<int>(v), LargeParts(counts[v], without, usual), ShareOf(agreeing)};
    spdlog::debug(
        "{}: {} corners expected, {:.2f} confirmed (usually {:.2f}); {:.3f} without agreement "
        "({:.3f} in large parts), {:.3f} agree",
        scene.views[v].name, cv::sum(counts[v].expected)[0], counts[v].ConfirmedShare(), usual,
        ShareOf(without), found.without_share, found.agreeing_share);
    if (found.without_share > 0 && found.agreeing_share >= kLeastAgreeingShare &&
        SumIn(counts[v].confirmed, agreeing) >= kLeastAgreeingCorners)
      obstructed.push_back(found);
  }
  return obstructed;
}

std::vector<Finding> FindingsOf(std::span<const ObstructedView> obstructed, const std::vector<View>& views) {
  if (obstructed.empty()) return {};
  Finding found{Name(Check::kPoses), {}, {}};
  double most = 0;
  for (const ObstructedView& each : obstructed) {
    most = std::max(most, each.without_share);
    found.views[views[At(each.view)].id] = views[At(each.view)].image_path;
  }
  found.text = fmt::format(
      "something that no neighbour sees there hides up to {:.0f} % of the picture of {{views}}: a hand "
      "before "
      "the lens, or somebody who walked through",
      100 * most);
  return {std::move(found)};
}

}  // namespace ulf::tracking
