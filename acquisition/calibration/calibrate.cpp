#include "acquisition/calibration/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/counted.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// All are guessed unless a comment says otherwise.
constexpr std::size_t kLeastViews = 4;  // fewer different views give no calibration
// A view whose corners moved by less than this share of the image's width repeats another and is dropped.
constexpr double kSamePlaceShare = 0.005;
// Corners farther than so many robust standard deviations from the richest model are outliers, and at least
// so many pixels. 4.5 leaves one of 150,000 good corners out.
constexpr double kGateSigmas = 4.5, kLeastGatePx = 0.1;
// A view whose median error exceeds so many times the median of all views, and this many pixels, is dropped.
constexpr double kViewFactor = 3, kLeastViewErrorPx = 0.3;
constexpr int kOutlierRounds = 3;  // of removing outliers: each fit is better than the last
// A calibration is refused when orientations of the board are closer together than this (radians), or
// standard deviations of focal length and principal point exceed this share (of the focal length, of the
// image's width).
constexpr double kLeastOrientationSpread = Radians(6), kMostRelativeSigma = 0.05;
// Refused: focal lengths outside these multiples of the image's width; no lens is so wide or so long.
constexpr double kShortestFocal = 0.05, kLongestFocal = 50;
// Warnings are given below or above these values: principal point this share of the width off the middle; so
// few views; share of the image's cells with a corner; reach of the corners (half diagonals); tilt of the
// board (radians); standard deviation of focal length and principal point (shares as above); RMS error in
// pixels; share of outliers.
constexpr double kWarnOffCenter = 0.1;
constexpr std::size_t kWarnViews = 10;
constexpr double kWarnCells = 0.7, kWarnReach = 0.75, kWarnTilt = Radians(12), kWarnRelativeSigma = 0.005,
                 kWarnRmsPx = 1, kWarnOutliers = 0.1;

// Some evenly chosen views, which suffice for a start.
std::vector<BoardView> Subset(const std::vector<BoardView>& views) {
  constexpr std::size_t kFew = 12;  // guessed: a start needs no precision
  if (views.size() <= kFew) return views;
  std::vector<BoardView> few;
  for (std::size_t i = 0; i < kFew; ++i) few.push_back(views[i * (views.size() - 1) / (kFew - 1)]);
  return few;
}

const LensCandidate& FindCandidate(Distortion distortion, int coefficients, bool one_focal) {
  for (const LensCandidate& candidate : LensCandidates())
    if (candidate.distortion == distortion && candidate.one_focal == one_focal &&
        std::count(candidate.estimated.begin(), candidate.estimated.end(), true) == coefficients)
      return candidate;
  return LensCandidates().front();
}

double MedianErrorPx(const std::vector<Vector3d>& points, const std::vector<BoardView>& views,
                     const LensFit& fit) {
  std::vector<double> lengths;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const Vector2d& residual : Residuals(points, views[v], fit.camera, fit.cam_from_board[v]))
      lengths.push_back(residual.norm());
  return Median(std::move(lengths));
}

// Returns the better of the richest models of both families. Corners that it cannot explain are outliers.
std::optional<LensFit> RichFit(const std::vector<Vector3d>& points, const std::vector<BoardView>& views,
                               const CameraModel& start) {
  std::optional<LensFit> best;
  double best_error = std::numeric_limits<double>::infinity();
  for (const Distortion family : {Distortion::kRadialTangential, Distortion::kFisheye}) {
    const LensFit fit = FitLens(points, views, FindCandidate(family, 4, false), start,
                                {.huber_px = 1, .max_iterations = 60, .with_sigma = false});
    if (!fit.usable) continue;
    const double error = MedianErrorPx(points, views, fit);
    if (error < best_error) {
      best_error = error;
      best = fit;
    }
  }
  return best;
}

// Returns the indices of views that do not repeat another; the reports name the others.
std::vector<std::size_t> DistinctViews(const std::vector<BoardView>& views, double least_shift_px,
                                       std::vector<ViewReport>& reports) {
  std::vector<std::size_t> kept;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](std::size_t other) {
      return MeanShiftPx(views[v], views[other]) < least_shift_px;
    });
    if (same != kept.end())
      reports[v].left_out = fmt::format("the board is at the same place as in {}", views[*same].name);
    else
      kept.push_back(v);
  }
  return kept;
}

// Removes outlying corners and views that do not fit; `indices` are those of the views kept.
void RemoveOutliers(const std::vector<Vector3d>& points, const CameraModel& start, CalibrationResult& result,
                    std::vector<std::size_t>& indices) {
  constexpr double kRayleighMedian = 1.1774;  // sqrt(2 ln 2): median length of a 2D Gaussian of sigma 1
  for (int round = 0; round < kOutlierRounds; ++round) {
    const auto fit = RichFit(points, result.views, start);
    if (!fit) return;
    const double sigma = MedianErrorPx(points, result.views, *fit) / kRayleighMedian;
    const double gate = std::max(kLeastGatePx, kGateSigmas * sigma);
    std::vector<double> view_errors;
    std::vector<std::vector<Vector2d>> residuals;
    for (std::size_t v = 0; v < result.views.size(); ++v) {
      residuals.push_back(Residuals(points, result.views[v], fit->camera, fit->cam_from_board[v]));
      std::vector<double> lengths;
      for (const Vector2d& residual : residuals.back()) lengths.push_back(residual.norm());
      view_errors.push_back(Median(lengths));
    }
    const double usual = Median(view_errors);
    std::vector<BoardView> views;
    std::vector<std::size_t> kept_indices;
    std::size_t removed = 0;
    for (std::size_t v = 0; v < result.views.size(); ++v) {
      ViewReport& report = result.reports[indices[v]];
      if (view_errors[v] > std::max(kLeastViewErrorPx, kViewFactor * usual)) {
        report.left_out = fmt::format("its error of {:.2f} px is {:.1f} times the median of all views",
                                      view_errors[v], view_errors[v] / usual);
        ++removed;
        continue;
      }
      BoardView clean{result.views[v].name, {}, {}};
      for (std::size_t i = 0; i < residuals[v].size(); ++i) {
        if (residuals[v][i].norm() > gate) continue;
        clean.ids.push_back(result.views[v].ids[i]);
        clean.img.push_back(result.views[v].img[i]);
      }
      const std::size_t lost = result.views[v].ids.size() - clean.ids.size();
      report.outliers += lost;
      removed += lost;
      if (clean.ids.size() < kLeastCorners) {
        report.left_out = "too few corners fit";
        continue;
      }
      views.push_back(std::move(clean));
      kept_indices.push_back(indices[v]);
    }
    result.views = std::move(views);
    indices = std::move(kept_indices);
    if (removed == 0 || result.views.size() < kLeastViews) return;
  }
}

std::string TooFewViewsReason(const CalibrationResult& result, std::size_t given, std::size_t distinct,
                              std::size_t least_views) {
  if (given == 0)
    return fmt::format(
        "the board {} was not found in any image; check its kind, counts (squares, not inner corners) and "
        "dictionary, and that the images show the whole of a chessboard",
        result.board.Text());
  if (distinct == 1 && given > 1)
    return fmt::format(
        "the board is at the same place in all {} images: one view does not determine the lens; move and "
        "tilt it between images",
        given);
  if (given >= least_views)
    return fmt::format(
        "the board is at the same place in most of the {} images: {} different views, at least {} are "
        "needed; move and tilt it between images",
        given, distinct, least_views);
  return fmt::format("only {} of the board ({}), at least {} are needed; move and tilt it between images",
                     Counted(distinct, "different view"), Counted(given, "image"), least_views);
}

std::string UndeterminedReason(const CalibrationResult& result) {
  const CameraModel& camera = result.camera;
  const double spread_deg = Degrees(result.coverage.orientation_spread);
  if (result.coverage.orientation_spread < kLeastOrientationSpread)
    return fmt::format(
        "the board has nearly the same orientation in all {} views (within {:.1f} degrees): focal length and "
        "distance cannot be distinguished; tilt it to all sides, by 20 to 40 degrees",
        result.views.size(), spread_deg);
  const double focal_sigma = std::max(result.sigma[0], result.sigma[1]) / camera.MeanFocalPx();
  if (!(focal_sigma < kMostRelativeSigma))
    return fmt::format(
        "the views do not determine the focal length ({:.0f} px +- {:.0f} %; orientations within {:.0f} "
        "degrees); take more views, with the board tilted to all sides by 20 to 40 degrees",
        camera.MeanFocalPx(), 100 * focal_sigma, spread_deg);
  const double center_sigma = std::max(result.sigma[2], result.sigma[3]) / camera.width;
  if (!(center_sigma < kMostRelativeSigma))
    return fmt::format(
        "the views do not determine the principal point (+- {:.0f} % of the image's width); take more views, "
        "with the board in all parts of the image and tilted to all sides",
        100 * center_sigma);
  if (camera.MeanFocalPx() < kShortestFocal * camera.width ||
      camera.MeanFocalPx() > kLongestFocal * camera.width)
    return fmt::format(
        "no lens has a focal length of {:.0f} px for an image {} px wide; check the board's text",
        camera.MeanFocalPx(), camera.width);
  return {};
}

void AddWarnings(CalibrationResult& result) {
  const CameraModel& camera = result.camera;
  const BoardCoverage& coverage = result.coverage;
  const auto warn = [&](std::string_view text) { result.warnings.emplace_back(text); };
  // First warnings about a wrong result, then about an uncertain one.
  const Vector2d off(camera.cx - 0.5 * camera.width, camera.cy - 0.5 * camera.height);
  if (off.norm() > kWarnOffCenter * camera.width)
    warn(fmt::format(
        "the principal point is {:.0f} px ({:.0f} % of the width) from the image's middle, which hardly any "
        "lens has: do not use this calibration unless the images were cropped; take more views, with the "
        "board in all parts of the image and tilted to all sides",
        off.norm(), 100 * off.norm() / camera.width));
  if (result.views.size() < kWarnViews)
    warn(fmt::format("only {}: take 15 or more", Counted(result.views.size(), "view")));
  if (coverage.CellShare() < kWarnCells)
    warn(fmt::format("corners cover {:.0f} % of the image: bring the board to every part of it",
                     100 * coverage.CellShare()));
  if (coverage.reach < kWarnReach)
    warn(fmt::format(
        "no corner is farther out than {:.0f} % of the half diagonal: beyond it the distortion is "
        "extrapolated",
        100 * coverage.reach));
  std::string missing;
  for (const auto& [tilt, name] : {std::pair{coverage.left, "left"}, std::pair{coverage.right, "right"},
                                   std::pair{coverage.upper, "upper"}, std::pair{coverage.lower, "lower"}})
    if (tilt < kWarnTilt) missing += (missing.empty() ? "" : ", ") + std::string(name);
  if (!missing.empty())
    warn(fmt::format("the board was never tilted with this edge away by {:.0f} degrees: {}",
                     Degrees(kWarnTilt), missing));
  const double focal = std::max(result.sigma[0], result.sigma[1]) / camera.MeanFocalPx();
  if (focal > kWarnRelativeSigma)
    warn(fmt::format("the focal length is uncertain by {:.1f} % (+- {:.1f} px)", 100 * focal,
                     focal * camera.MeanFocalPx()));
  const double center = std::max(result.sigma[2], result.sigma[3]);
  if (center > kWarnRelativeSigma * camera.width)
    warn(fmt::format("the principal point is uncertain by +- {:.1f} px", center));
  if (result.rms_px > kWarnRmsPx)
    warn(
        fmt::format("the error of {:.2f} px is large: check that the board is flat and as its text says, and "
                    "that the images are sharp",
                    result.rms_px));
  const std::size_t all = result.corners + result.outliers;
  if (static_cast<double>(result.outliers) > kWarnOutliers * static_cast<double>(all))
    warn(fmt::format("corners that did not fit and were left out: {} of {}", result.outliers, all));
  if (result.choice.table[result.choice.chosen].folds_inside_image)
    warn("the distortion cannot be inverted in part of the image");
  if (!result.choice.table[result.choice.chosen].explains)
    warn("no lens model explains the data and is usable over the whole image; the best one was chosen");
}

}  // namespace

double MeanShiftPx(const BoardView& a, const BoardView& b) {
  double sum = 0;
  int shared = 0;
  for (std::size_t i = 0; i < a.ids.size(); ++i) {
    const auto found = std::find(b.ids.begin(), b.ids.end(), a.ids[i]);
    if (found == b.ids.end()) continue;
    sum += (a.img[i] - b.img[static_cast<std::size_t>(found - b.ids.begin())]).norm();
    ++shared;
  }
  return shared >= 4 ? sum / shared : std::numeric_limits<double>::infinity();
}

double BoardCoverage::CellShare() const {
  if (corners_in_cell.empty()) return 0;
  const auto hit = std::count_if(corners_in_cell.begin(), corners_in_cell.end(), [](int n) { return n > 0; });
  return static_cast<double>(hit) / static_cast<double>(corners_in_cell.size());
}

BoardCoverage CoverageOf(int width, int height, const std::vector<BoardView>& views,
                         const std::vector<Rigid3>& cam_from_board) {
  BoardCoverage coverage;
  coverage.corners_in_cell.assign(static_cast<std::size_t>(coverage.columns * coverage.rows), 0);
  const Vector2d middle(0.5 * width, 0.5 * height);
  for (const BoardView& view : views)
    for (const Vector2d& img : view.img) {
      const int column =
          std::clamp(static_cast<int>(img.x() / width * coverage.columns), 0, coverage.columns - 1);
      const int row = std::clamp(static_cast<int>(img.y() / height * coverage.rows), 0, coverage.rows - 1);
      ++coverage.corners_in_cell[static_cast<std::size_t>(row * coverage.columns + column)];
      coverage.reach = std::max(coverage.reach, (img - middle).norm() / middle.norm());
    }
  std::vector<Vector3d> normals;
  for (const Rigid3& pose : cam_from_board) {
    // The board's z points away from the camera and leans to the side whose opposite edge is farther away.
    const Vector3d n = pose.rotation * Vector3d::UnitZ();
    const double across = std::atan2(n.x(), n.z()), along = std::atan2(n.y(), n.z());
    coverage.left = std::max(coverage.left, across);
    coverage.right = std::max(coverage.right, -across);
    coverage.upper = std::max(coverage.upper, along);
    coverage.lower = std::max(coverage.lower, -along);
    for (const Vector3d& other : normals)
      coverage.orientation_spread = std::max(coverage.orientation_spread, AngleBetween(n, other));
    normals.push_back(n);
  }
  return coverage;
}

std::optional<CameraModel> RoughIntrinsics(const Board& board, const std::vector<BoardView>& views, int width,
                                           int height) {
  const std::vector<Vector3d> points = board.Points();
  const std::vector<BoardView> few = Subset(views);
  std::optional<CameraModel> best;
  double best_error = std::numeric_limits<double>::infinity();
  for (const double focal_in_widths : {0.35, 0.6, 1.0, 1.8, 4.0})
    for (const Distortion family : {Distortion::kRadialTangential, Distortion::kFisheye}) {
      const LensFit fit = FitLens(points, few, FindCandidate(family, 1, true),
                                  CameraModel::Pinhole(width, height, focal_in_widths * width),
                                  {.huber_px = 2, .max_iterations = 40, .with_sigma = false});
      if (!fit.usable) continue;
      const double error = MedianErrorPx(points, few, fit);
      // For a narrow lens the families are nearly the same: the second one must be better by 2 %. Guessed.
      constexpr double kClearlyLess = 0.98;
      if (error < kClearlyLess * best_error) {
        best_error = error;
        best = fit.camera;
      }
    }
  return best;
}

CalibrationResult CalibrateFromViews(const Board& board, const std::vector<BoardView>& views, int width,
                                     int height) {
  CalibrationResult result{.board = board};
  std::vector<BoardView> seen;
  for (const BoardView& view : views) {
    result.reports.push_back(
        {view.name, view.ids.size(), 0, 0, view.ids.empty() ? "the board was not found" : ""});
    if (!view.ids.empty()) seen.push_back(view);
  }
  std::vector<std::size_t> indices = DistinctViews(views, kSamePlaceShare * width, result.reports);
  std::erase_if(indices, [&](std::size_t v) { return views[v].ids.empty(); });
  if (indices.size() < kLeastViews) {
    result.refusal = TooFewViewsReason(result, seen.size(), indices.size(), kLeastViews);
    return result;
  }
  for (const std::size_t v : indices) result.views.push_back(views[v]);
  const std::vector<Vector3d> points = board.Points();
  const auto rough = RoughIntrinsics(board, result.views, width, height);
  if (!rough) {
    result.refusal = "no lens explains these views; check the board's text and that it is flat";
    return result;
  }
  RemoveOutliers(points, *rough, result, indices);
  if (result.views.size() < kLeastViews) {
    result.refusal = TooFewViewsReason(result, seen.size(), result.views.size(), kLeastViews);
    return result;
  }
  result.choice = ChooseLens(points, result.views, *rough);
  if (result.choice.table.empty()) {
    result.refusal =
        "no lens model could be fitted to these views; check the board's text and that it is flat";
    return result;
  }
  const CandidateResult& chosen = result.choice.table[result.choice.chosen];
  result.camera = chosen.fit.camera;
  result.cam_from_board = chosen.fit.cam_from_board;
  result.rms_px = chosen.fit.RmsPx();
  result.corners = chosen.fit.corners;
  for (std::size_t i = 0; i < result.sigma.size(); ++i)
    result.sigma[i] = std::max(chosen.fit.sigma[i], chosen.spread[i]);
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    ViewReport& report = result.reports[indices[v]];
    report.corners = result.views[v].ids.size();
    double sum = 0;
    for (const Vector2d& residual :
         Residuals(points, result.views[v], result.camera, result.cam_from_board[v]))
      sum += residual.squaredNorm();
    report.rms_px = std::sqrt(sum / static_cast<double>(report.corners));
  }
  for (const ViewReport& report : result.reports) result.outliers += report.outliers;
  result.coverage = CoverageOf(width, height, result.views, result.cam_from_board);
  result.refusal = UndeterminedReason(result);
  if (result.ok()) AddWarnings(result);
  return result;
}

}  // namespace ulf::acquisition
