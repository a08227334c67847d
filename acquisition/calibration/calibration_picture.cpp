#include "acquisition/calibration/calibration_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf {
namespace {

using Eigen::Vector2d;

const cv::Scalar kPaper(250, 250, 250), kInk(40, 40, 40), kFaint(222, 222, 222), kContour(205, 190, 170),
    kArrow(30, 60, 200), kFrame(150, 150, 150);
constexpr int kTextLine = 22, kMargin = 16;

void Write(cv::Mat& canvas, const std::string& text, cv::Point at, double scale = 0.5) {
  cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, kInk, 1, cv::LINE_AA);
}

struct Panel {
  cv::Point origin;
  double scale;  // panel pixels per image pixel
  cv::Point At(const Vector2d& img) const {
    return origin + cv::Point(static_cast<int>(std::lround(img.x() * scale)),
                              static_cast<int>(std::lround(img.y() * scale)));
  }
};

void DrawFrame(cv::Mat& canvas, const Panel& panel, const CameraModel& camera) {
  cv::rectangle(canvas, panel.At({0, 0}), panel.At({camera.width, camera.height}), kFrame, 1);
}

using Labels = std::vector<std::pair<std::string, cv::Point>>;  // in the panel

// How far the distortion moves a point: a line for each of a few distances.
Labels DrawDistortion(cv::Mat& canvas, const Panel& panel, const CameraModel& camera) {
  const CameraModel plain = camera.WithoutDistortion();
  const int width = static_cast<int>(camera.width * panel.scale),
            height = static_cast<int>(camera.height * panel.scale);
  cv::Mat moved(height, width, CV_32FC1, cv::Scalar(0));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vector2d img((x + 0.5) / panel.scale, (y + 0.5) / panel.scale);
      const auto ray = camera.RayFromImg(img);
      const auto straight = ray && ray->z() > 0.05 ? plain.ImgFromCam(*ray) : std::nullopt;
      moved.at<float>(y, x) = straight ? static_cast<float>((*straight - img).norm()) : 1e4f;
    }
  double largest = 0;
  cv::minMaxLoc(moved, nullptr, &largest);
  const double levels_px[] = {0.5, 1, 2, 5, 10, 20, 50, 100, 200};
  Labels labels;
  for (const double level : levels_px) {
    if (level > largest) break;
    cv::Mat inside = moved < level;
    std::vector<std::vector<cv::Point>> lines;
    cv::findContours(inside, lines, cv::RETR_LIST, cv::CHAIN_APPROX_NONE, panel.origin);
    cv::drawContours(canvas, lines, -1, kContour, 1, cv::LINE_AA);
    // The number where the contour crosses the middle row, to the right, unless another stands there.
    for (int x = static_cast<int>(camera.cx * panel.scale); x >= 0 && x + 1 < width; ++x)
      if ((moved.at<float>(height / 2, x) < level) != (moved.at<float>(height / 2, x + 1) < level)) {
        if (labels.empty() || x > labels.back().second.x + 48)
          labels.emplace_back(fmt::format("{:g} px", level), cv::Point(x, height / 2));
        break;
      }
  }
  cv::rectangle(canvas, panel.At({0, 0}), panel.At({camera.width, camera.height}), kPaper, 2);
  return labels;
}

double ArrowScale(const CalibrationResult& result) {
  // The usual residual becomes a fortieth of the image's width, rounded to 1, 2 or 5.
  const double wanted = result.camera.width / 40.0 / std::max(result.rms_px, 1e-6);
  const double decade = std::pow(10, std::floor(std::log10(wanted)));
  return decade * (wanted / decade >= 5 ? 5 : wanted / decade >= 2 ? 2 : 1);
}

void DrawResiduals(cv::Mat& canvas, const Panel& panel, const CalibrationResult& result, double magnified) {
  const auto points = result.board.Points();
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const auto residuals = Residuals(points, result.views[v], result.camera, result.cam_from_board[v]);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const Vector2d from = result.views[v].img[i] - residuals[i];
      cv::line(canvas, panel.At(from), panel.At(from + magnified * residuals[i]), kArrow, 1, cv::LINE_AA);
      cv::circle(canvas, panel.At(from), 1, kArrow, cv::FILLED, cv::LINE_AA);
    }
  }
  const cv::Point center = panel.At({result.camera.cx, result.camera.cy});
  cv::drawMarker(canvas, center, kInk, cv::MARKER_CROSS, 14, 1, cv::LINE_AA);
}

void DrawCoverage(cv::Mat& canvas, const Panel& panel, const CalibrationResult& result) {
  const CameraModel& camera = result.camera;
  const BoardCoverage& coverage = result.coverage;
  const int most =
      std::max(1, *std::max_element(coverage.corners_in_cell.begin(), coverage.corners_in_cell.end()));
  for (int row = 0; row < coverage.rows; ++row)
    for (int column = 0; column < coverage.columns; ++column) {
      const int count = coverage.corners_in_cell[static_cast<std::size_t>(row * coverage.columns + column)];
      const double share = std::sqrt(static_cast<double>(count) / most);
      const cv::Scalar color = count == 0 ? cv::Scalar(170, 170, 240)
                                          : cv::Scalar(250 - 90 * share, 250 - 30 * share, 250 - 120 * share);
      const double w = static_cast<double>(camera.width) / coverage.columns,
                   h = static_cast<double>(camera.height) / coverage.rows;
      const cv::Rect cell(panel.At({column * w, row * h}), panel.At({(column + 1) * w, (row + 1) * h}));
      cv::rectangle(canvas, cell, color, cv::FILLED);
      Write(canvas, std::to_string(count), cell.tl() + cv::Point(4, 14), 0.38);
    }
  for (const BoardView& view : result.views)
    for (const Vector2d& img : view.img) cv::circle(canvas, panel.At(img), 1, kInk, cv::FILLED, cv::LINE_AA);
}

}  // namespace

cv::Mat DrawCalibration(const CalibrationResult& result) {
  const CameraModel& camera = result.camera;
  const double scale = 640.0 / std::max(camera.width, camera.height);
  const int width = static_cast<int>(camera.width * scale), height = static_cast<int>(camera.height * scale);
  const int top = kMargin + 2 * kTextLine;
  cv::Mat canvas(top + height + kMargin, 2 * width + 3 * kMargin, CV_8UC3, kPaper);
  const Panel left{{kMargin, top}, scale}, right{{2 * kMargin + width, top}, scale};
  const double magnified = ArrowScale(result);
  const Labels labels = DrawDistortion(canvas, left, camera);
  DrawResiduals(canvas, left, result, magnified);
  for (const auto& [text, at] : labels) {
    const cv::Point from = left.origin + cv::Point(std::min(at.x, width - 46) + 3, at.y);
    cv::rectangle(canvas, from + cv::Point(-2, -11), from + cv::Point(40, 4), kPaper, cv::FILLED);
    Write(canvas, text, from, 0.38);
  }
  DrawFrame(canvas, left, camera);
  DrawCoverage(canvas, right, result);
  DrawFrame(canvas, right, camera);
  Write(canvas,
        fmt::format("residuals x {:g}, RMS {:.3f} px; {}", magnified, result.rms_px,
                    result.choice.table[result.choice.chosen].fit.candidate.name),
        {kMargin, kMargin + 14});
  Write(canvas,
        camera.distortion == Distortion::kNone ? "no distortion; cross: principal point"
                                               : "lines: distortion in pixels; cross: principal point",
        {kMargin, kMargin + 14 + kTextLine});
  Write(canvas,
        fmt::format("{} corners of {} views; {:.0f} % of the cells hold one", result.corners,
                    result.views.size(), 100 * result.coverage.CellShare()),
        {2 * kMargin + width, kMargin + 14});
  Write(canvas,
        fmt::format("tilts: left {:.0f}, right {:.0f}, upper {:.0f}, lower {:.0f} degrees away",
                    result.coverage.left * 180 / M_PI, result.coverage.right * 180 / M_PI,
                    result.coverage.upper * 180 / M_PI, result.coverage.lower * 180 / M_PI),
        {2 * kMargin + width, kMargin + 14 + kTextLine});

  return canvas;
}

}  // namespace ulf
