#include "core/fiducials/board_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/quantile.h"
#include "core/fiducials/aruco_calls.h"

namespace ulf {
namespace {

using Corners = std::vector<cv::Point2f>;

// Half the window in which a corner is refined, px. Smaller: noise decides; larger: other edges get in. Guessed.
constexpr int kLeastHalfWindowPx = 2, kMostHalfWindowPx = 8;

void RefineCorners(const cv::Mat& gray, double half_window_px, Corners& corners) {
  const int half = std::clamp(static_cast<int>(half_window_px), kLeastHalfWindowPx, kMostHalfWindowPx);
  cv::cornerSubPix(gray, corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 50, 1e-3});
}

void Add(int id, const cv::Point2f& corner, BoardView& view) {
  view.ids.push_back(id);
  view.img.emplace_back(corner.x + 0.5, corner.y + 0.5);
}

struct Markers {
  std::vector<Corners> corners;
  std::vector<int> ids;
};

Markers DetectMarkers(const cv::Mat& gray, const cv::Ptr<cv::aruco::Dictionary>& dictionary, bool refine) {
  const auto parameters = cv::makePtr<cv::aruco::DetectorParameters>();
  parameters->cornerRefinementMethod =
      refine ? cv::aruco::CORNER_REFINE_SUBPIX : cv::aruco::CORNER_REFINE_NONE;
  // Windows up to the size of a cell of a marker that fills the image.
  parameters->adaptiveThreshWinSizeMax = std::max(23, std::max(gray.cols, gray.rows) / 12) | 1;
  parameters->adaptiveThreshWinSizeStep = std::max(10, (parameters->adaptiveThreshWinSizeMax - 3) / 4);
  Markers markers;
  cv::aruco::detectMarkers(gray, dictionary, markers.corners, markers.ids, parameters);
  return markers;
}

BoardView DetectChessboard(const Board& board, const cv::Mat& gray) {
  const cv::Size inner(board.columns - 1, board.rows - 1);
  Corners corners;
  BoardView view;
  // The older findChessboardCorners takes seconds where a part of the board is out of sight.
  if (!cv::findChessboardCornersSB(gray, inner, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) return view;
  // The window must not reach the neighbouring corners.
  double step = 1e9;
  for (std::size_t i = 1; i < corners.size(); ++i)
    step = std::min(step, cv::norm(corners[i] - corners[i - 1]));
  RefineCorners(gray, step / 3, corners);
  for (std::size_t i = 0; i < corners.size(); ++i) Add(static_cast<int>(i), corners[i], view);
  return view;
}

// The largest window about a square's corner that does not reach the markers beside it.
double HalfWindowPx(const cv::Point2f& corner, const Markers& markers) {
  double nearest = 1e9;
  for (const Corners& marker : markers.corners)
    for (const cv::Point2f& other : marker) nearest = std::min(nearest, cv::norm(other - corner));
  return nearest / std::sqrt(2.0) - 1;
}

BoardView DetectCharuco(const Board& board, const cv::Mat& gray) {
  const auto dictionary = ArucoDictionary(DictionaryNumber(board.dictionary));
  const auto charuco = CharucoBoard({board.columns, board.rows}, static_cast<float>(board.square_mm),
                                    static_cast<float>(board.marker_mm), dictionary);
  const Markers markers = DetectMarkers(gray, dictionary, false);
  BoardView view;
  if (markers.ids.empty()) return view;
  Corners corners;
  std::vector<int> ids;
  cv::aruco::interpolateCornersCharuco(markers.corners, markers.ids, gray, charuco, corners, ids);
  // OpenCV 4.6 returns corners half a pixel off in both axes: correct them and refine once more.
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Corners one = {corners[i] - cv::Point2f(0.5f, 0.5f)};
    RefineCorners(gray, HalfWindowPx(corners[i], markers), one);
    Add(ids[i], one[0], view);
  }
  return view;
}

BoardView DetectArucoGrid(const Board& board, const cv::Mat& gray) {
  const Markers markers = DetectMarkers(gray, ArucoDictionary(DictionaryNumber(board.dictionary)), true);
  BoardView view;
  for (std::size_t i = 0; i < markers.ids.size(); ++i) {
    if (markers.ids[i] >= board.columns * board.rows) continue;  // of another sheet
    for (int k = 0; k < 4; ++k)
      Add(4 * markers.ids[i] + k, markers.corners[i][static_cast<std::size_t>(k)], view);
  }
  return view;
}

// Corners in one line or one spot have no pose.
bool SpreadsOverThePlane(const Board& board, const BoardView& view) {
  const auto points = board.Points();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const int id : view.ids) mean += points[static_cast<std::size_t>(id)].head<2>();
  mean /= static_cast<double>(view.ids.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const int id : view.ids) {
    const Eigen::Vector2d d = points[static_cast<std::size_t>(id)].head<2>() - mean;
    scatter += d * d.transpose();
  }
  constexpr double kLeastRoundness = 1e-3;  // 1/4: as far in all directions; 0: on a line; guessed
  return scatter.determinant() > kLeastRoundness * std::pow(scatter.trace(), 2);
}

}  // namespace

BoardView DetectBoard(const Board& board, const cv::Mat& gray) {
  BoardView view;
  switch (board.kind) {
    case BoardKind::kCharuco:
      view = DetectCharuco(board, gray);
      break;
    case BoardKind::kArucoGrid:
      view = DetectArucoGrid(board, gray);
      break;
    case BoardKind::kChessboard:
      view = DetectChessboard(board, gray);
      break;
  }
  if (view.ids.size() < kLeastCorners || !SpreadsOverThePlane(board, view)) return {};
  return view;
}

double EdgeBlurPx(const BoardView& view, const cv::Mat& gray) {
  Corners outline;
  for (const Eigen::Vector2d& img : view.img)
    outline.emplace_back(static_cast<float>(img.x()), static_cast<float>(img.y()));
  const cv::Rect box = cv::boundingRect(outline) & cv::Rect(0, 0, gray.cols, gray.rows);
  // Smaller boards and fainter edges (grey levels) give no measurement. Guessed.
  constexpr int kLeastSidePx = 8;
  constexpr double kLeastContrast = 8;
  if (box.width < kLeastSidePx || box.height < kLeastSidePx) return std::numeric_limits<double>::infinity();
  cv::Mat region, dx, dy, steepness;
  gray(box).convertTo(region, CV_32F);
  cv::Sobel(region, dx, CV_32F, 1, 0, 3, 1.0 / 8);  // grey levels per pixel
  cv::Sobel(region, dy, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::magnitude(dx, dy, steepness);
  const auto share_of = [](const cv::Mat& values, double share) {
    return Quantile({values.begin<float>(), values.end<float>()}, share);
  };
  const double contrast = share_of(region, 0.95) - share_of(region, 0.05);
  const double steepest = share_of(steepness, 0.98);
  if (contrast < kLeastContrast || steepest <= 0) return std::numeric_limits<double>::infinity();
  // A step blurred by a Gaussian of spread s rises by contrast / (s sqrt(2 pi)) per pixel.
  return contrast / (steepest * std::sqrt(2 * M_PI));
}

}  // namespace ulf
