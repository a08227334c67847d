#include "core/fiducials/marker_detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/fiducials/aruco_calls.h"
#include "core/fiducials/board.h"
#include "core/image/image.h"

namespace ulf {

namespace {

cv::Ptr<cv::aruco::DetectorParameters> Parameters(const cv::Size& size) {
  const auto parameters = cv::makePtr<cv::aruco::DetectorParameters>();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;  // RefinedBySides() does it
  // The two windows suit the cells of a small marker, and of one that fills the image.
  parameters->adaptiveThreshWinSizeMin = 7;
  parameters->adaptiveThreshWinSizeMax = std::max(23, std::max(size.width, size.height) / 16) | 1;
  parameters->adaptiveThreshWinSizeStep = parameters->adaptiveThreshWinSizeMax - 7;
  return parameters;
}

using Eigen::Vector2d;

// Interpolates linear light between pixel centres; none outside. Blur mixes light: display values would move
// every edge towards its dark side and make markers a tenth of a pixel too small.
std::optional<double> Level(const cv::Mat& gray, const Vector2d& img) {
  const double x = img.x() - 0.5, y = img.y() - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= gray.cols || y0 + 1 >= gray.rows) return std::nullopt;
  const double ax = x - x0, ay = y - y0;
  const unsigned char* row0 = gray.ptr(y0) + x0;
  const unsigned char* row1 = gray.ptr(y0 + 1) + x0;
  const std::array<float, 256>& light = LinearFromSrgb8();
  return (1 - ay) * ((1 - ax) * light[row0[0]] + ax * light[row0[1]]) +
         ay * ((1 - ax) * light[row1[0]] + ax * light[row1[1]]);
}

struct Line {
  Vector2d point, along;
};

struct Step {
  double at, across;  // px along the side and outwards from it
};

// Returns the centre of the rise along `out`, within `reach` of `from`; none if nothing rises.
std::optional<double> Rise(const cv::Mat& gray, const Vector2d& from, const Vector2d& out, double reach) {
  // Sampling distance in pixels, and the least rise in grey level (0 to 1): less is noise. Guessed.
  constexpr double kStep = 0.5, kLeastContrast = 0.005;
  double weights = 0, sum = 0;
  std::optional<double> before;
  for (double o = -reach - kStep / 2; o <= reach + kStep; o += kStep) {
    const auto level = Level(gray, from + o * out);
    if (!level) return std::nullopt;
    if (before && *level > *before) {
      weights += *level - *before;
      sum += (*level - *before) * (o - kStep / 2);
    }
    before = level;
  }
  if (weights < kLeastContrast) return std::nullopt;
  return sum / weights;
}

// Fits a line to the side from `corner` towards `other`; `out` points to the bright side.
std::optional<Line> FitSide(const cv::Mat& gray, const Vector2d& corner, const Vector2d& other,
                            const Vector2d& inside, double reach) {
  // Pixels: blur rounds the corner up to kClear; a side is straight up to kLongest under any lens; sides
  // shorter than kShortest have too few steps. These and the used share of the side are guessed.
  constexpr double kClear = 1.5, kLongest = 24, kShortest = 6, kUsedShare = 0.6;
  const double length = (other - corner).norm();
  if (length < kShortest) return std::nullopt;
  const Vector2d along = (other - corner) / length;
  Vector2d out(along.y(), -along.x());
  if (out.dot(inside - corner) > 0) out = -out;
  std::vector<Step> steps;
  for (double s = kClear; s <= std::min(kLongest, kUsedShare * length); s += 1)
    if (const auto across = Rise(gray, corner + s * along, out, reach)) steps.push_back({s, *across});
  constexpr std::size_t kLeast = 3;  // steps that determine a line
  // A step farther from the line is a scratch, a shadow or a neighbour's corner. Guessed.
  constexpr double kOutlierPx = 0.5;
  double offset = 0, slope = 0;
  for (int round = 0; round < 3; ++round) {
    if (steps.size() < kLeast) return std::nullopt;
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Vector2d right = Vector2d::Zero();
    for (const Step& step : steps) {
      const Vector2d row(1, step.at);
      normal += row * row.transpose();
      right += step.across * row;
    }
    if (normal.determinant() <= 0) return std::nullopt;
    const Vector2d line = normal.inverse() * right;
    offset = line[0];
    slope = line[1];
    const auto is_off = [&](const Step& step) {
      return std::abs(step.across - offset - slope * step.at) > kOutlierPx;
    };
    if (std::erase_if(steps, is_off) == 0) break;
  }
  return Line{corner + offset * out, (along + slope * out).normalized()};
}

std::optional<Vector2d> Meet(const Line& a, const Line& b) {
  Eigen::Matrix2d m;
  m << a.along, -b.along;
  constexpr double kLeastSine = 0.1;  // of the angle between the sides; guessed
  if (std::abs(m.determinant()) < kLeastSine) return std::nullopt;
  const Vector2d shares = m.inverse() * (b.point - a.point);
  return a.point + shares[0] * a.along;
}

// Moves each side outwards by `px` pixels.
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

// Adds the quadrilaterals among the outlines of the mask's areas, whose sides were moved inwards by
// `shrunk_px`.
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
    // The order is clockwise, with y down.
    if (cv::contourArea(corners, true) < 0) std::swap(corners[1], corners[3]);
    MarkerImage quad;
    for (std::size_t k = 0; k < 4; ++k) quad[k] = {corners[k].x + 0.5, corners[k].y + 0.5};
    // Outlines run through the middles of the outermost pixels.
    quads.push_back(GrownBy(quad, shrunk_px + 0.5));
  }
}

// Returns white cells as 1, CV_8UC1, row by row; empty if the outline holds nothing with contrast.
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
  constexpr double kLeastDeviation = 5;  // grey levels, as in OpenCV's detector
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

std::vector<std::pair<int, MarkerImage>> DetectMarkers(const std::string& dictionary, const cv::Mat& gray) {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  const auto known = ArucoDictionary(DictionaryNumber(dictionary));
  cv::aruco::detectMarkers(gray, known, corners, ids, Parameters(gray.size()));
  std::vector<std::pair<int, MarkerImage>> found;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    MarkerImage img;  // OpenCV's pixel centres are integers
    for (std::size_t k = 0; k < 4; ++k) img[k] = {corners[i][k].x + 0.5, corners[i][k].y + 0.5};
    found.emplace_back(ids[i], RefinedBySides(gray, img, known->markerSize + 2));
  }
  return found;
}

MarkerImage RefinedBySides(const cv::Mat& gray, const MarkerImage& corners, int cells) {
  MarkerImage refined = corners;
  constexpr int kRounds = 2;  // profiles of the second round are centred on the lines of the first
  for (int round = 0; round < kRounds; ++round) {
    const MarkerImage from = refined;
    const Vector2d middle = 0.25 * (from[0] + from[1] + from[2] + from[3]);
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector2d &corner = from[k], &next = from[(k + 1) % 4], &last = from[(k + 3) % 4];
      const auto reach = [&](const Vector2d& across) {
        return std::clamp(0.75 * (across - corner).norm() / cells, 1.25, 4.0);
      };
      // A side's profile runs across it, as far as a cell of the other side is wide.
      const auto first = FitSide(gray, corner, next, middle, reach(last)),
                 second = FitSide(gray, corner, last, middle, reach(next));
      if (!first || !second) continue;
      const auto met = Meet(*first, *second);
      constexpr double kFar = 3;  // px; a corner that moves farther is another one; guessed
      if (met && (*met - corners[k]).norm() < kFar) refined[k] = *met;
    }
  }
  return refined;
}

std::vector<MarkerImage> DarkQuads(const cv::Mat& gray) {
  std::vector<MarkerImage> quads;
  const int size = std::max(gray.cols, gray.rows);
  // The windows are about as large as a marker, so that its border is dark as a whole; areas shrink with
  // them. Guessed.
  for (const double share : {0.04, 0.1, 0.25}) {
    const int window = std::max(15, static_cast<int>(share * size)) | 1;
    constexpr double kDarker = 5;  // grey levels below the window's mean
    cv::Mat mask;
    cv::adaptiveThreshold(gray, mask, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV, window,
                          kDarker);
    // Otherwise outlines stop at the picture's edge.
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
  // Shares of wrong cells in the border, and among those that the dictionary can correct, as in OpenCV's
  // detector.
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
