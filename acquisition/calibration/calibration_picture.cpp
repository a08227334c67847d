#include "acquisition/calibration/calibration_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/counted.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector2d;

const cv::Scalar kPaper(250, 250, 250), kInk(40, 40, 40), kFaint(222, 222, 222), kContour(205, 190, 170),
    kDarkContour(120, 60, 10), kArrow(30, 60, 200), kFrame(150, 150, 150);
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

constexpr double kSmallText = 0.38;

// Returns the box that a small text covers; `at` is the left end of its base line.
cv::Rect BoxOf(const std::string& text, cv::Point at) {
  int below = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kSmallText, 1, &below);
  return {at.x - 3, at.y - size.height - 3, size.width + 6, size.height + below + 5};
}

void WriteOnBox(cv::Mat& canvas, const std::string& text, cv::Point at, const cv::Scalar& background) {
  cv::rectangle(canvas, BoxOf(text, at), background, cv::FILLED);
  Write(canvas, text, at, kSmallText);
}

struct Contour {
  std::string text;
  std::vector<cv::Point> places;  // on the canvas
};

// Draws lines of equal value, for each level that occurs within the panel.
std::vector<Contour> DrawContours(cv::Mat& canvas, const Panel& panel, const cv::Mat& values,
                                  const std::vector<std::pair<double, std::string>>& levels,
                                  const cv::Scalar& color = kContour) {
  std::vector<Contour> contours;
  const cv::Rect inside_panel(panel.origin.x + 1, panel.origin.y + 1, values.cols - 2, values.rows - 2);
  for (const auto& [level, text] : levels) {
    Contour contour{text, {}};
    std::vector<std::vector<cv::Point>> lines;
    const cv::Mat inside = values < level;
    cv::findContours(inside, lines, cv::RETR_LIST, cv::CHAIN_APPROX_NONE, panel.origin);
    cv::drawContours(canvas, lines, -1, color, 1, cv::LINE_AA);
    for (const auto& line : lines)
      for (std::size_t i = 0; i < line.size(); i += 4)
        if (inside_panel.contains(line[i])) contour.places.push_back(line[i]);
    if (!contour.places.empty()) contours.push_back(std::move(contour));
  }
  // Removes the parts of the contours along the panel's edge.
  cv::rectangle(canvas, panel.origin, panel.origin + cv::Point(values.cols, values.rows), kPaper, 2);
  return contours;
}

// Writes each line's value on it, where it covers no other value and as little ink as possible.
void LabelContours(cv::Mat& canvas, const Panel& panel, cv::Size size, const std::vector<Contour>& contours,
                   const cv::Mat& drawn) {
  cv::Mat sum;
  cv::integral(drawn / 255, sum, CV_32S);
  const auto ink_in = [&](const cv::Rect& box) {
    return sum.at<int>(box.y, box.x) + sum.at<int>(box.br().y, box.br().x) - sum.at<int>(box.y, box.br().x) -
           sum.at<int>(box.br().y, box.x);
  };
  const cv::Rect room(panel.origin.x + 2, panel.origin.y + 2, size.width - 4, size.height - 4);
  std::vector<cv::Rect> taken;
  for (const Contour& contour : contours) {
    std::optional<cv::Point> best;
    int least = std::numeric_limits<int>::max();
    for (const cv::Point& place : contour.places) {
      const cv::Rect around = BoxOf(contour.text, place);
      const cv::Point at = place - cv::Point(around.width / 2 - 3, -around.height / 2 + 3);
      const cv::Rect box = BoxOf(contour.text, at);
      if ((box & room) != box || std::any_of(taken.begin(), taken.end(),
                                             [&](const cv::Rect& other) { return (box & other).area() > 0; }))
        continue;
      if (const int ink = ink_in(box); ink < least) {
        least = ink;
        best = at;
      }
    }
    if (!best) continue;
    taken.push_back(BoxOf(contour.text, *best));
    WriteOnBox(canvas, contour.text, *best, kPaper);
  }
}

// Draws lines along which the distortion moves points by the same distance.
std::vector<Contour> DrawDistortion(cv::Mat& canvas, const Panel& panel, const CameraModel& camera) {
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
  std::vector<std::pair<double, std::string>> levels;
  for (const double level_px : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0})
    levels.emplace_back(level_px, fmt::format("{:g} px", level_px));
  return DrawContours(canvas, panel, moved, levels);
}

double ArrowScale(const CalibrationResult& result) {
  // The RMS residual becomes a fortieth of the image's width; the factor is rounded to 1, 2 or 5.
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
  cv::drawMarker(canvas, center, kPaper, cv::MARKER_CROSS, 20, 5);
  cv::drawMarker(canvas, center, kInk, cv::MARKER_CROSS, 16, 2);
}

void DrawCoverage(cv::Mat& canvas, const Panel& panel, const CalibrationResult& result) {
  const CameraModel& camera = result.camera;
  const BoardCoverage& coverage = result.coverage;
  const int most =
      std::max(1, *std::max_element(coverage.corners_in_cell.begin(), coverage.corners_in_cell.end()));
  const auto each_cell = [&](const auto& draw) {
    for (int row = 0; row < coverage.rows; ++row)
      for (int column = 0; column < coverage.columns; ++column) {
        const int count = coverage.corners_in_cell[static_cast<std::size_t>(row * coverage.columns + column)];
        const double share = std::sqrt(static_cast<double>(count) / most);
        const cv::Scalar color = count == 0
                                     ? cv::Scalar(170, 170, 240)
                                     : cv::Scalar(250 - 90 * share, 250 - 30 * share, 250 - 120 * share);
        const double w = static_cast<double>(camera.width) / coverage.columns,
                     h = static_cast<double>(camera.height) / coverage.rows;
        draw(cv::Rect(panel.At({column * w, row * h}), panel.At({(column + 1) * w, (row + 1) * h})), color,
             count);
      }
  };
  each_cell([&](const cv::Rect& cell, const cv::Scalar& color, int) {
    cv::rectangle(canvas, cell, color, cv::FILLED);
  });
  for (const BoardView& view : result.views)
    for (const Vector2d& img : view.img) cv::circle(canvas, panel.At(img), 1, kInk, cv::FILLED, cv::LINE_AA);
  each_cell([&](const cv::Rect& cell, const cv::Scalar& color, int count) {
    WriteOnBox(canvas, std::to_string(count), cell.tl() + cv::Point(5, 14), color);
  });
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
  const std::vector<Contour> contours = DrawDistortion(canvas, left, camera);
  const cv::Mat before = canvas.clone();
  DrawResiduals(canvas, left, result, magnified);
  cv::Mat drawn;
  cv::absdiff(canvas, before, drawn);
  cv::cvtColor(drawn, drawn, cv::COLOR_BGR2GRAY);
  LabelContours(canvas, left, {width, height}, contours, drawn > 0);
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
        fmt::format("{} of {}, in {:.0f} % of the cells", Counted(result.corners, "corner"),
                    Counted(result.views.size(), "view"), 100 * result.coverage.CellShare()),
        {2 * kMargin + width, kMargin + 14});
  Write(canvas,
        fmt::format("tilts: left {:.0f}, right {:.0f}, upper {:.0f}, lower {:.0f} degrees away",
                    Degrees(result.coverage.left), Degrees(result.coverage.right),
                    Degrees(result.coverage.upper), Degrees(result.coverage.lower)),
        {2 * kMargin + width, kMargin + 14 + kTextLine});

  return canvas;
}

cv::Mat DrawFlatField(const FlatFieldResult& result) {
  const FlatField& flat = result.flat_field;
  const double scale = 640.0 / std::max(flat.width, flat.height);
  const int width = static_cast<int>(flat.width * scale), height = static_cast<int>(flat.height * scale);
  const int top = kMargin + 2 * kTextLine, axis = 44;
  cv::Mat canvas(top + height + kMargin + kTextLine, 2 * width + 3 * kMargin + axis, CV_8UC3, kPaper);
  const Panel left{{kMargin, top}, scale};
  cv::Mat light;
  cv::resize(flat.Light(flat.width, flat.height), light, {width, height}, 0, 0, cv::INTER_AREA);
  std::vector<cv::Mat> bgr;
  cv::split(light, bgr);
  const cv::Mat mean = (bgr[0] + bgr[1] + bgr[2]) / 3;

  cv::Mat grey;
  mean.convertTo(grey, CV_8U, 235);
  cv::cvtColor(grey, canvas({left.origin, cv::Size(width, height)}), cv::COLOR_GRAY2BGR);
  std::vector<std::pair<double, std::string>> levels;
  for (int percent = 10; percent <= 130; percent += 5)
    if (percent != 100) levels.emplace_back(0.01 * percent, fmt::format("{} %", percent));
  const auto contours = DrawContours(canvas, left, mean, levels, kDarkContour);
  LabelContours(canvas, left, {width, height}, contours, cv::Mat::zeros(canvas.size(), CV_8UC1));
  cv::rectangle(canvas, {left.origin, cv::Size(width, height)}, kFrame, 1);

  // Right: the light along the diagonal from the upper left, each channel in its colour.
  const cv::Rect plot(2 * kMargin + width + axis, top, width, height);
  double most = 0;
  cv::minMaxLoc(light.reshape(1), nullptr, &most);
  const double highest = 0.1 * std::ceil(10 * std::max(1.0, most) + 1e-6);
  const auto y_of = [&](double share) {
    return plot.br().y - static_cast<int>(std::lround(share / highest * height));
  };
  for (double share = 0; share <= highest + 1e-6; share += 0.2) {
    cv::line(canvas, {plot.x, y_of(share)}, {plot.br().x, y_of(share)}, kFaint, 1);
    Write(canvas, fmt::format("{:.0f} %", 100 * share), {plot.x - axis, y_of(share) + 4}, kSmallText);
  }
  const cv::Scalar colors[] = {{200, 90, 30}, {60, 150, 40}, {40, 50, 210}};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<cv::Point> curve;
    for (int x = 0; x < width; ++x)
      curve.emplace_back(plot.x + x, y_of(bgr[c].at<float>(x * (height - 1) / std::max(1, width - 1), x)));
    // Each curve is thinner than the one before, so that all can be seen where they agree.
    cv::polylines(canvas, curve, false, colors[c], 7 - 3 * static_cast<int>(c), cv::LINE_AA);
  }
  cv::rectangle(canvas, plot, kFrame, 1);
  Write(canvas, fmt::format("light relative to the middle, {}", Counted(result.frames, "frame")),
        {kMargin, kMargin + 14});
  Write(canvas, "model: " + result.model, {kMargin, kMargin + 14 + kTextLine});
  Write(canvas,
        fmt::format("corners B {:.1f} %, G {:.1f} %, R {:.1f} %", 100 * result.corner_bgr[0],
                    100 * result.corner_bgr[1], 100 * result.corner_bgr[2]),
        {plot.x, kMargin + 14});
  Write(canvas,
        fmt::format("residual {:.2f} %, lighting {:.1f} % over the card, {} dark spots",
                    100 * result.residual, 100 * result.gradient, result.dust),
        {plot.x, kMargin + 14 + kTextLine});
  Write(canvas, "upper left corner", {plot.x, plot.br().y + 16}, kSmallText);
  Write(canvas, "lower right corner", {plot.br().x - 110, plot.br().y + 16}, kSmallText);
  return canvas;
}

namespace {

const cv::Scalar kMissing(40, 140, 255), kDone(90, 190, 60), kBand(36, 36, 36), kLight(240, 240, 240);

void WriteLight(cv::Mat& canvas, const std::string& text, cv::Point at, double scale, int thickness = 1) {
  cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, kLight, thickness, cv::LINE_AA);
}

// Parts without corners are tinted and framed.
void DrawParts(cv::Mat& picture, const CalibrationGuide& guide) {
  constexpr double kTint = 0.3;
  cv::Mat tinted = picture.clone();
  const auto part = [&](int index) {
    const int row = index / CalibrationGuide::kColumns, column = index % CalibrationGuide::kColumns;
    const auto x = [&](int i) { return i * picture.cols / CalibrationGuide::kColumns; };
    const auto y = [&](int i) { return i * picture.rows / CalibrationGuide::kRows; };
    return cv::Rect({x(column), y(row)}, cv::Point(x(column + 1), y(row + 1)));
  };
  const auto& cells = guide.cells();
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!cells[i]) cv::rectangle(tinted, part(static_cast<int>(i)), kMissing, cv::FILLED);
  cv::addWeighted(tinted, kTint, picture, 1 - kTint, 0, picture);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!cells[i]) cv::rectangle(picture, part(static_cast<int>(i)), kMissing, 1);
}

// A board with one edge away: that edge is the shorter one.
void DrawTilt(cv::Mat& canvas, cv::Point middle, int tilt, bool seen) {
  constexpr int kHalf = 15, kShort = 8;
  const bool sideways = tilt < 2, first = tilt % 2 == 0;  // left and upper edge come first
  std::vector<cv::Point> outline;
  for (const auto& [along, across] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const bool away = (along < 0) == first;
    const int length = away ? kShort : kHalf;
    outline.push_back(middle + (sideways ? cv::Point(along * kHalf, across * length)
                                         : cv::Point(across * length, along * kHalf)));
  }
  if (seen)
    cv::fillConvexPoly(canvas, outline, kDone, cv::LINE_AA);
  else
    cv::polylines(canvas, outline, true, kMissing, 2, cv::LINE_AA);
}

}  // namespace

cv::Mat DrawGuide(const cv::Mat& gray, const CalibrationGuide& guide, ViewVerdict verdict) {
  constexpr int kWidth = 960, kBandHeight = 96, kBar = 6;
  const double scale = static_cast<double>(kWidth) / gray.cols;
  const int height = static_cast<int>(std::lround(gray.rows * scale));
  cv::Mat canvas(height + kBandHeight, kWidth, CV_8UC3, kBand);
  cv::Mat picture = canvas(cv::Rect(0, 0, kWidth, height)), sized;
  cv::resize(gray, sized, picture.size(), 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  cv::cvtColor(sized, picture, cv::COLOR_GRAY2BGR);
  DrawParts(picture, guide);
  if (guide.last())
    for (const Vector2d& img : guide.last()->img) {
      const cv::Point at(static_cast<int>(std::lround(img.x() * scale)),
                         static_cast<int>(std::lround(img.y() * scale)));
      cv::circle(picture, at, 4, kBand, cv::FILLED, cv::LINE_AA);
      cv::circle(picture, at, 3, verdict == ViewVerdict::kTaken ? kLight : kDone, cv::FILLED, cv::LINE_AA);
    }
  if (verdict == ViewVerdict::kTaken) cv::rectangle(picture, {3, 3, kWidth - 6, height - 6}, kLight, 6);
  cv::rectangle(canvas, {0, height, kWidth, kBar}, kFrame, cv::FILLED);
  cv::rectangle(canvas, {0, height, static_cast<int>(kWidth * guide.Share()), kBar}, kDone, cv::FILLED);
  WriteLight(canvas, guide.Enough() ? "enough: it ends by itself" : guide.NextInstruction(),
             {kMargin, height + 42}, 0.8, 2);
  WriteLight(canvas,
             fmt::format("{}, {}; coloured parts of the image have not been covered yet",
                         Counted(guide.views().size(), "view"), Name(verdict)),
             {kMargin, height + 76}, 0.5);
  for (int tilt = 0; tilt < CalibrationGuide::kTilts; ++tilt)
    DrawTilt(canvas, {kWidth - 200 + 52 * tilt, height + 46}, tilt,
             guide.tilts()[static_cast<std::size_t>(tilt)]);
  WriteLight(canvas, "tilts", {kWidth - 128, height + 86}, 0.4);
  return canvas;
}

}  // namespace ulf::acquisition
