#include "core/fiducials/touching_markers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "core/fiducials/aruco_calls.h"
#include "core/fiducials/board.h"

namespace ulf {
namespace {

using Eigen::Vector2d;

// Each side is moved outwards by so many pixels.
MarkerImage GrownBy(const MarkerImage& quad, double px) {
  MarkerImage grown = quad;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector2d a = (quad[(k + 1) % 4] - quad[k]).normalized(),
                   b = (quad[(k + 3) % 4] - quad[k]).normalized();
    constexpr double kLeastSine = 0.2;  // of a corner's angle; guessed
    const double sine = std::max(kLeastSine, std::abs(a.x() * b.y() - a.y() * b.x()));
    grown[k] -= px / sine * (a + b);
  }
  return grown;
}

// Adds the quadrilaterals among the outlines of the mask's areas, whose sides were moved inwards by so many pixels.
void AddQuads(const cv::Mat& mask, double shrunk_px, std::vector<MarkerImage>& quads) {
  // Pixels, shares of the perimeter and of the square's area: smaller markers cannot be read. Guessed.
  constexpr double kShortestSidePx = 8, kStraight = 0.04, kLeastFullness = 0.2;
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  for (const auto& outline : outlines) {
    const auto length = static_cast<double>(outline.size());
    if (length < 4 * kShortestSidePx) continue;
    std::vector<cv::Point> corners;
    cv::approxPolyDP(outline, corners, kStraight * length, true);
    if (corners.size() != 4 || !cv::isContourConvex(corners)) continue;
    if (cv::contourArea(corners) < kLeastFullness * length * length / 16) continue;
    // Clockwise, with y down.
    if (cv::contourArea(corners, true) < 0) std::swap(corners[1], corners[3]);
    MarkerImage quad;
    for (std::size_t k = 0; k < 4; ++k) quad[k] = {corners[k].x + 0.5, corners[k].y + 0.5};
    // Outlines run through the middles of the outermost pixels.
    quads.push_back(GrownBy(quad, shrunk_px + 0.5));
  }
}

// White cells as 1, CV_8UC1, row by row; empty where the outline holds nothing with contrast.
cv::Mat CellsOf(const MarkerImage& quad, const cv::Mat& gray, int cells) {
  constexpr int kCellPx = 6, kMarginPx = 1;
  const auto side = static_cast<float>(cells * kCellPx);
  std::vector<cv::Point2f> from, to{{0, 0}, {side, 0}, {side, side}, {0, side}};
  for (const Vector2d& corner : quad)
    from.emplace_back(static_cast<float>(corner.x() - 0.5), static_cast<float>(corner.y() - 0.5));
  for (cv::Point2f& corner : to) corner -= cv::Point2f(0.5f, 0.5f);
  cv::Mat square, dark, light;
  cv::warpPerspective(gray, square, cv::getPerspectiveTransform(from, to), {cells * kCellPx, cells * kCellPx},
                      cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::Scalar mean, deviation;
  cv::meanStdDev(square, mean, deviation);
  constexpr double kLeastDeviation = 5;  // grey levels, as OpenCV's detector has it
  if (deviation[0] < kLeastDeviation) return {};
  cv::threshold(square, light, 0, 1, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::Mat white(cells, cells, CV_8UC1);
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      constexpr int kInsidePx = kCellPx - 2 * kMarginPx;
      const cv::Rect inside(x * kCellPx + kMarginPx, y * kCellPx + kMarginPx, kInsidePx, kInsidePx);
      white.at<std::uint8_t>(y, x) = 2 * cv::countNonZero(light(inside)) > inside.area() ? 1 : 0;
    }
  return white;
}

}  // namespace

std::vector<MarkerImage> DarkQuads(const cv::Mat& gray) {
  std::vector<MarkerImage> quads;
  const int size = std::max(gray.cols, gray.rows);
  // Windows about as large as a marker, so that its border is dark as a whole, and how far areas are shrunk. Guessed.
  for (const double share : {0.04, 0.1, 0.25}) {
    const int window = std::max(15, static_cast<int>(share * size)) | 1;
    constexpr double kDarker = 5;  // grey levels below the window's mean
    cv::Mat mask;
    cv::adaptiveThreshold(gray, mask, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV, window,
                          kDarker);
    // Outlines stop at the picture's edge otherwise.
    cv::copyMakeBorder(mask, mask, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    for (const int shrunk_px : {1, std::max(2, size / 400)}) {
      cv::Mat parted;
      cv::erode(mask, parted, cv::Mat::ones(2 * shrunk_px + 1, 2 * shrunk_px + 1, CV_8U));
      const std::size_t before = quads.size();
      AddQuads(parted, shrunk_px, quads);
      for (std::size_t i = before; i < quads.size(); ++i)
        for (Vector2d& corner : quads[i]) corner -= Vector2d(1, 1);  // the frame
    }
  }
  return quads;
}

std::vector<std::pair<int, MarkerImage>> MarkersAmong(const std::vector<MarkerImage>& quads,
                                                      const cv::Mat& gray, const std::string& dictionary,
                                                      int border_cells) {
  const auto known = ArucoDictionary(DictionaryNumber(dictionary));
  const int bits = known->markerSize, cells = bits + 2 * border_cells;
  // Wrong cells: the share of the border's, and of those that the dictionary can correct; as OpenCV's detector has
  // them.
  constexpr double kBorder = 0.1, kCorrected = 0.6;
  std::map<int, std::pair<int, MarkerImage>> best;  // wrong cells of the border and outline, by number
  for (const MarkerImage& quad : quads) {
    const cv::Mat white = CellsOf(quad, gray, cells);
    if (white.empty()) continue;
    const cv::Rect inside(border_cells, border_cells, bits, bits);
    const int wrong = cv::countNonZero(white) - cv::countNonZero(white(inside));
    if (wrong > kBorder * (cells * cells - bits * bits)) continue;
    int id = 0, rotation = 0;
    if (!known->identify(white(inside).clone(), id, rotation, kCorrected)) continue;
    MarkerImage turned = quad;
    std::rotate(turned.begin(), turned.begin() + (4 - rotation) % 4, turned.end());
    const auto [at, is_new] = best.try_emplace(id, wrong, turned);
    if (!is_new && wrong < at->second.first) at->second = {wrong, turned};
  }
  std::vector<std::pair<int, MarkerImage>> found;
  for (const auto& [id, marker] : best) found.emplace_back(id, marker.second);
  return found;
}

}  // namespace ulf
