#include "core/fiducials/board_detector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/base/quantile.h"
#include "core/fiducials/aruco_calls.h"
#include "core/fiducials/marker_detector.h"

namespace ulf {
namespace {

using Corners = std::vector<cv::Point2f>;

// Half the window in which a corner is refined, px. A smaller one is noisy, a larger one includes other
// edges. Guessed.
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
  // The windows reach the size of a cell of a marker that fills the image.
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
  // The older findChessboardCorners takes seconds if a part of the board is out of sight.
  if (!cv::findChessboardCornersSB(gray, inner, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) return view;
  // The window must not reach the neighbouring corners.
  double step = 1e9;
  for (std::size_t i = 1; i < corners.size(); ++i)
    step = std::min(step, cv::norm(corners[i] - corners[i - 1]));
  RefineCorners(gray, step / 3, corners);
  for (std::size_t i = 0; i < corners.size(); ++i) Add(static_cast<int>(i), corners[i], view);
  return view;
}

// Returns the largest window about a square's corner that does not reach the markers beside it.
double HalfWindowPx(const cv::Point2f& corner, const Markers& markers) {
  double nearest = 1e9;
  for (const Corners& marker : markers.corners)
    for (const cv::Point2f& other : marker) nearest = std::min(nearest, cv::norm(other - corner));
  return nearest / std::sqrt(2.0) - 1;
}

// Returns the board that OpenCV looks for. It knows those with a dark upper left corner: one with a white
// corner is the rest of such a board without its first column.
Board DarkCornerBoard(const Board& board) {
  Board whole = board;
  if (board.white_corner) ++whole.columns;
  whole.white_corner = false;
  whole.order = {};
  whole.first_marker = 0;
  return whole;
}

// Renumbers markers for that board and removes those of other sheets.
void RenumberMarkers(const Board& board, const Board& whole, Markers& markers) {
  if (board == whole) return;
  const auto places = board.MarkerPlaces(), places_in_whole = whole.MarkerPlaces();
  Markers renumbered;
  for (std::size_t i = 0; i < markers.ids.size(); ++i) {
    const int number = markers.ids[i] - board.first_marker;
    if (number < 0 || number >= static_cast<int>(places.size())) continue;
    const Eigen::Vector2i place =
        places[static_cast<std::size_t>(number)] + Eigen::Vector2i(whole.columns - board.columns, 0);
    const auto at = std::ranges::find(places_in_whole, place);
    renumbered.ids.push_back(static_cast<int>(at - places_in_whole.begin()));
    renumbered.corners.push_back(markers.corners[i]);
  }
  markers = std::move(renumbered);
}

BoardView DetectCharuco(const Board& board, const cv::Mat& gray) {
  const auto dictionary = ArucoDictionary(DictionaryNumber(board.dictionary));
  const Board whole = DarkCornerBoard(board);
  const auto charuco = CharucoBoard({whole.columns, whole.rows}, static_cast<float>(board.square_mm),
                                    static_cast<float>(board.marker_mm), dictionary);
  Markers markers = DetectMarkers(gray, dictionary, false);
  RenumberMarkers(board, whole, markers);
  BoardView view;
  if (markers.ids.empty()) return view;
  Corners corners;
  std::vector<int> ids;
  cv::aruco::interpolateCornersCharuco(markers.corners, markers.ids, gray, charuco, corners, ids);
  // OpenCV 4.6 returns corners half a pixel off in both axes: correct them and refine once more.
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const int column = ids[i] % (whole.columns - 1) - (whole.columns - board.columns),
              row = ids[i] / (whole.columns - 1);
    if (column < 0) continue;
    Corners one = {corners[i] - cv::Point2f(0.5f, 0.5f)};
    RefineCorners(gray, HalfWindowPx(corners[i], markers), one);
    Add(row * (board.columns - 1) + column, one[0], view);
  }
  return view;
}

// A corner that moves farther is another corner: pixels, and share of the marker's side in large pictures.
// Guessed.
constexpr double kFarthestPx = 3, kFarthestShare = 0.05;

// Adds a marker's corners, refined in windows that reach neither its cells nor what lies beyond the gap.
void AddMarkerCorners(const Board& board, int number, int cells, const cv::Mat& gray,
                      const MarkerImage& marker, BoardView& view) {
  double side_px = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k) side_px = std::min(side_px, (marker[(k + 1) % 4] - marker[k]).norm());
  constexpr double kClear = 0.6;  // share of the border and the gap; guessed
  const double half_window_px =
      kClear * side_px *
      std::min(static_cast<double>(board.BorderCells()) / cells, board.gap_mm / board.marker_mm);
  // At the picture's edge a cut marker has false corners.
  const auto margin =
      static_cast<float>(std::clamp<double>(half_window_px, kLeastHalfWindowPx, kMostHalfWindowPx) + 1);
  const cv::Rect2f inside(margin, margin, static_cast<float>(gray.cols) - 2 * margin,
                          static_cast<float>(gray.rows) - 2 * margin);
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2d& corner = marker[static_cast<std::size_t>(k)];
    const cv::Point2f rough(static_cast<float>(corner.x() - 0.5), static_cast<float>(corner.y() - 0.5));
    if (!inside.contains(rough)) continue;
    Corners one = {rough};
    RefineCorners(gray, half_window_px, one);
    if (cv::norm(one[0] - rough) < std::max(kFarthestPx, kFarthestShare * side_px))
      Add(4 * number + k, one[0], view);
  }
}

// Returns whether the tags of an AprilGrid are upside down: Kalibr's are for OpenCV, those drawn with
// OpenCV's dictionary are not. Their neighbours decide.
bool AreTurned(const std::vector<Eigen::Vector2i>& places,
               const std::vector<std::pair<int, MarkerImage>>& tags) {
  double upright = 0;
  for (std::size_t i = 1; i < tags.size(); ++i) {
    const MarkerImage &a = tags[i - 1].second, &b = tags[i].second;
    const Eigen::Vector2d right = a[1] - a[0] + a[2] - a[3], down = a[3] - a[0] + a[2] - a[1];
    const Eigen::Vector2i steps =
        places[static_cast<std::size_t>(tags[i].first)] - places[static_cast<std::size_t>(tags[i - 1].first)];
    const Eigen::Vector2d expected = steps.x() * right + steps.y() * down,
                          seen = b[0] + b[1] + b[2] + b[3] - a[0] - a[1] - a[2] - a[3];
    upright += expected.dot(seen) > 0 ? 1 : -1;
  }
  return upright <= 0;
}

BoardView DetectAprilGrid(const Board& board, const cv::Mat& gray) {
  constexpr int kCells = 10;  // of a tag's side, with its border
  auto tags = MarkersAmong(DarkQuads(gray), gray, board.dictionary, board.BorderCells());
  const auto places = board.MarkerPlaces();
  for (auto& [id, tag] : tags) id -= board.first_marker;
  std::erase_if(tags, [&](const auto& tag) {
    return tag.first < 0 || tag.first >= static_cast<int>(places.size());  // of another sheet
  });
  const bool turned = AreTurned(places, tags);
  BoardView view;
  for (auto& [number, tag] : tags) {
    if (turned) std::rotate(tag.begin(), tag.begin() + 2, tag.end());
    AddMarkerCorners(board, number, kCells, gray, tag, view);
  }
  return view;
}

BoardView DetectArucoGrid(const Board& board, const cv::Mat& gray) {
  const auto dictionary = ArucoDictionary(DictionaryNumber(board.dictionary));
  const Markers markers = DetectMarkers(gray, dictionary, true);
  const int all = board.columns * board.rows;
  BoardView view;
  std::set<int> seen;
  for (std::size_t i = 0; i < markers.ids.size(); ++i) {
    const int number = markers.ids[i] - board.first_marker;
    if (number < 0 || number >= all) continue;  // of another sheet
    seen.insert(number);
    for (int k = 0; k < 4; ++k) Add(4 * number + k, markers.corners[i][static_cast<std::size_t>(k)], view);
  }
  // If few are seen, the corners of the markers may touch squares between them.
  if (2 * static_cast<int>(seen.size()) > all) return view;
  for (const auto& [id, marker] :
       MarkersAmong(DarkQuads(gray), gray, board.dictionary, board.BorderCells())) {
    const int number = id - board.first_marker;
    if (number < 0 || number >= all || seen.contains(number)) continue;
    AddMarkerCorners(board, number, dictionary->markerSize + 2 * board.BorderCells(), gray, marker, view);
  }
  return view;
}

// Corners on a line or in one spot do not determine a pose.
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
  constexpr double kLeastRoundness = 1e-3;  // 1/4: isotropic; 0: on a line; guessed
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
    case BoardKind::kAprilGrid:
      view = DetectAprilGrid(board, gray);
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
