#include "coverage/operator/coverage_drawing.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <variant>
#include <vector>

#include "core/base/counted.h"
#include "core/geometry/angles.h"
#include "coverage/bound/gap_words.h"
#include "coverage/operator/overlay.h"
#include "coverage/operator/palette.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const cv::Scalar kWhite(255, 255, 255), kInk(45, 45, 45), kCamera(40, 30, 235);
const cv::Vec3f kUncovered(92, 92, 92), kOutside(232, 232, 232);
constexpr int kSubpixelBits = 4;

cv::Point Subpixel(const Vector2d& img) {
  // OpenCV draws with pixel centres at integers.
  const double scale = 1 << kSubpixelBits;
  return {static_cast<int>(std::lround((img.x() - 0.5) * scale)),
          static_cast<int>(std::lround((img.y() - 0.5) * scale))};
}

void Line(cv::Mat& image, const Vector2d& a, const Vector2d& b, const cv::Scalar& color, int thickness = 1) {
  cv::line(image, Subpixel(a), Subpixel(b), color, thickness, cv::LINE_AA, kSubpixelBits);
}

// A disc with smooth edges at any size; OpenCV's small circles are crosses.
void Disc(cv::Mat& image, const Vector2d& at, double radius, const cv::Scalar& color) {
  const cv::Vec3f paint(static_cast<float>(color[0]), static_cast<float>(color[1]),
                        static_cast<float>(color[2]));
  const cv::Rect box =
      cv::Rect(cv::Point(static_cast<int>(at.x() - radius - 1), static_cast<int>(at.y() - radius - 1)),
               cv::Point(static_cast<int>(at.x() + radius + 2), static_cast<int>(at.y() + radius + 2))) &
      cv::Rect({}, image.size());
  for (int y = box.y; y < box.br().y; ++y)
    for (int x = box.x; x < box.br().x; ++x) {
      const double distance = std::hypot(x + 0.5 - at.x(), y + 0.5 - at.y());
      const auto opacity = static_cast<float>(std::clamp(radius + 0.5 - distance, 0.0, 1.0));
      auto& pixel = image.at<cv::Vec3b>(y, x);
      pixel = cv::Vec3b((1 - opacity) * cv::Vec3f(pixel) + opacity * paint);
    }
}

// Smaller where it would not fit between `at` and the right edge.
void Text(cv::Mat& image, const std::string& text, const Vector2d& at, double size, const cv::Scalar& color,
          double align = 0) {
  constexpr int kMargin = 4;
  int baseline = 0;
  cv::Size extent = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline);
  if (const double room = image.cols - kMargin - at.x(); align == 0 && extent.width > room) {
    size *= room / extent.width;
    extent = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline);
  }
  cv::putText(image, text, {static_cast<int>(at.x() - align * extent.width), static_cast<int>(at.y())},
              cv::FONT_HERSHEY_SIMPLEX, size, color, 1, cv::LINE_AA);
}

cv::Scalar Bgr(const render::Rgba& color) { return {double(color.b), double(color.g), double(color.r)}; }

cv::Vec3f Paint(const render::Rgba& color) {
  return {static_cast<float>(color.b), static_cast<float>(color.g), static_cast<float>(color.r)};
}

Vector3d DirectionOf(const CoverageMap& map, const Vector3d& position_in_world) {
  return (position_in_world - map.subject().center_in_world).normalized();
}

void TextUpwards(cv::Mat& image, const std::string& text, const Vector2d& middle, double size,
                 const cv::Scalar& color) {
  int baseline = 0;
  const cv::Size extent = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline);
  const cv::Rect place(static_cast<int>(middle.x()) - (extent.height + baseline) / 2,
                       static_cast<int>(middle.y()) - extent.width / 2, extent.height + baseline,
                       extent.width + 1);
  if ((place & cv::Rect({}, image.size())) != place) return;
  cv::Mat lying;
  cv::rotate(image(place), lying, cv::ROTATE_90_CLOCKWISE);
  Text(lying, text, {0, static_cast<double>(extent.height)}, size, color);
  cv::rotate(lying, lying, cv::ROTATE_90_COUNTERCLOCKWISE);
  lying.copyTo(image(place));
}

// ---- the chart

struct Chart {
  double left, right, bottom, top;  // radians
  cv::Rect2d area;                  // pixels
  Vector2d ImgOf(double azimuth, double elevation) const {
    return {area.x + (azimuth - left) / (right - left) * area.width,
            area.y + (top - elevation) / (top - bottom) * area.height};
  }
};

Chart LayOut(const CoverageMap& map, int width) {
  double half_width = 0, half_height = 0;
  if (map.options().cap) {
    half_width = 0.5 * map.options().cap->width;
    half_height = 0.5 * map.options().cap->height;
  } else {
    for (const CriterionView& view : map.views()) {
      const CapFrame::Angles angles = map.frame()->Of(DirectionOf(map, view.center_in_world));
      half_width = std::max(half_width, std::abs(angles.azimuth));
      half_height = std::max(half_height, std::abs(angles.elevation));
    }
  }
  const double margin = std::max(Radians(4), 0.12 * half_height);
  half_width = std::min(M_PI, half_width + margin);
  half_height = std::min(M_PI / 2, std::max(half_height + margin, 0.25 * half_width));
  const double pixels = width - 92;
  return {-half_width, half_width, -half_height, half_height,
          cv::Rect2d(68, 40, pixels, std::round(pixels * half_height / half_width))};
}

// What is open is what `map` counts as open: its holes, and its share, can be seen. Colours are those of
// `fine`, the same map on a finer grid.
void PaintChart(cv::Mat& canvas, const Chart& chart, const CoverageMap& map, const CoverageMap& fine,
                const DistanceColors& colors) {
  constexpr int kSamples = 2;  // a side: smooth edges
  for (int y = 0; y < static_cast<int>(chart.area.height); ++y)
    for (int x = 0; x < static_cast<int>(chart.area.width); ++x) {
      cv::Vec3f sum(0, 0, 0);
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const double u = x + (k % kSamples + 0.5) / kSamples, v = y + (k / kSamples + 0.5) / kSamples;
        const double azimuth = chart.left + u / chart.area.width * (chart.right - chart.left);
        const double elevation = chart.top - v / chart.area.height * (chart.top - chart.bottom);
        const Vector3d direction = map.frame()->Direction(azimuth, elevation);
        const auto decided = map.At(direction), finer = fine.At(direction);
        if (!decided) {
          sum += kOutside;
        } else if (decided->index < 0) {
          sum += kUncovered;
        } else {
          const int view = finer && finer->index >= 0 ? finer->index : decided->index;
          sum += Paint(colors.Of(map.views()[static_cast<std::size_t>(view)]));
        }
      }
      canvas.at<cv::Vec3b>(static_cast<int>(chart.area.y) + y, static_cast<int>(chart.area.x) + x) =
          sum / float{kSamples * kSamples};
    }
}

void DrawGraticule(cv::Mat& canvas, const Chart& chart) {
  const double span_deg = Degrees(chart.right - chart.left);
  const double step_deg = span_deg > 200 ? 45 : span_deg > 90 ? 20 : span_deg > 25 ? 10 : 5;
  const double step = Radians(step_deg);
  const cv::Scalar line(168, 168, 168);
  for (int i = static_cast<int>(std::ceil(chart.left / step)); i * step <= chart.right; ++i) {
    Line(canvas, chart.ImgOf(i * step, chart.bottom), chart.ImgOf(i * step, chart.top), line);
    Text(canvas, fmt::format("{:g}", i * step_deg), chart.ImgOf(i * step, chart.bottom) + Vector2d(0, 16),
         0.4, kInk, 0.5);
  }
  for (int i = static_cast<int>(std::ceil(chart.bottom / step)); i * step <= chart.top; ++i) {
    Line(canvas, chart.ImgOf(chart.left, i * step), chart.ImgOf(chart.right, i * step), line);
    Text(canvas, fmt::format("{:g}", i * step_deg), chart.ImgOf(chart.left, i * step) + Vector2d(-6, 4), 0.4,
         kInk, 1);
  }
  Text(canvas, "azimuth from the first view, degrees (to the right)",
       {chart.area.x + 0.5 * chart.area.width, chart.area.br().y + 34}, 0.45, kInk, 0.5);
  TextUpwards(canvas, "elevation, degrees (up)", {14, chart.area.y + 0.5 * chart.area.height}, 0.45, kInk);
}

constexpr char kDegree[] = " degrees";  // the font has no sign for it

// Returns the numbers of the largest gaps, and a line with their places, as `ulf info` has them.
std::string NumberGaps(cv::Mat& canvas, const Chart& chart, const std::vector<CapGap>& gaps) {
  constexpr std::size_t kNumbered = 3;
  std::string line;
  for (std::size_t i = 0; i < std::min(kNumbered, gaps.size()); ++i) {
    const double azimuth = Radians(gaps[i].azimuth_deg), elevation = Radians(gaps[i].elevation_deg);
    const std::string number = fmt::format("{}", i + 1);
    // Beside it, towards the middle of the chart: a small gap is smaller than its number.
    const Vector2d img =
        chart.ImgOf(azimuth, elevation) + Vector2d(azimuth > 0 ? -14 : 14, elevation > 0 ? 14 : -14);
    Disc(canvas, img, 9, kWhite);
    Text(canvas, number, img + Vector2d(0, 5), 0.45, kInk, 0.5);
    line += fmt::format("{}{}: {:.0f}, {:.0f}", i == 0 ? "their azimuth, elevation, degrees: " : "; ", number,
                        gaps[i].azimuth_deg, gaps[i].elevation_deg);
  }
  if (gaps.size() > kNumbered) line += fmt::format("; {} smaller", gaps.size() - kNumbered);
  return line;
}

// Draws what lies over the colours: the graticule, the cap's outline and the recorded views.
void DrawLinesAndViews(cv::Mat& canvas, const Chart& chart, const CoverageMap& map) {
  DrawGraticule(canvas, chart);
  if (const auto& cap = map.options().cap) {
    const double x = 0.5 * cap->width, y = 0.5 * cap->height;
    const Vector2d corners[] = {chart.ImgOf(-x, y), chart.ImgOf(x, y), chart.ImgOf(x, -y),
                                chart.ImgOf(-x, -y)};
    for (int i = 0; i < 4; ++i) Line(canvas, corners[i], corners[(i + 1) % 4], kInk, 2);
  }
  for (const CriterionView& view : map.views()) {
    const CapFrame::Angles at = map.frame()->Of(DirectionOf(map, view.center_in_world));
    const Vector2d img = chart.ImgOf(at.azimuth, at.elevation);
    if (chart.area.contains(cv::Point2d(img.x(), img.y()))) Disc(canvas, img, 2.5, kInk);
  }
}

void DrawLegendPatch(cv::Mat& canvas, double x, double y, const cv::Scalar& color) {
  cv::rectangle(canvas, cv::Rect(static_cast<int>(x), static_cast<int>(y) - 10, 14, 12), color, cv::FILLED);
}

constexpr int kLegendAt = 58, kLine = 20;  // from the chart's lower edge, and from line to line

// Draws the legend in two lines.
void DrawLegend(cv::Mat& canvas, const Chart& chart, bool against_current) {
  double y = chart.area.br().y + kLegendAt, x = chart.area.x;
  const auto words = [&](const std::string& text, double after_mark) {
    Text(canvas, text, {x + after_mark, y}, 0.42, kInk);
    int baseline = 0;
    x += after_mark + cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, 0.42, 1, &baseline).width + 22;
  };
  const auto patch = [&](const cv::Scalar& color, const std::string& text) {
    DrawLegendPatch(canvas, x, y, color);
    words(text, 20);
  };
  const auto disc = [&](double radius, const cv::Scalar& color, const std::string& text) {
    Disc(canvas, {x + 5, y - 4}, radius, color);
    words(text, 14);
  };
  const Palette& palette = Palette::Standard();
  patch(Bgr(palette.same), "covered from the same distance");
  patch(Bgr(palette.farther), against_current ? "farther than now" : "farther than the median");
  patch(Bgr(palette.nearer), "nearer");
  x = chart.area.x, y += kLine;
  patch(kUncovered, "not covered");
  patch(kOutside, "not asked for");
  disc(2.5, kInk, "recorded view");
  if (against_current) disc(5, kCamera, "camera");
}

// ---- the sphere over the live image

// Draws shapes of one opacity on a copy, which is then laid over the image.
class ShapePainter {
 public:
  ShapePainter(cv::Mat& image, double scale) : image_(image), scale_(scale) {}
  ~ShapePainter() { LayDown(); }
  ShapePainter(const ShapePainter&) = delete;
  ShapePainter& operator=(const ShapePainter&) = delete;

  void operator()(const render::Polyline& line) {
    cv::Mat& layer = Layer(line.color);
    const int thickness = std::max(1, static_cast<int>(std::lround(line.width * scale_)));
    for (std::size_t i = 0; i + (line.closed ? 0 : 1) < line.img.size(); ++i)
      Line(layer, line.img[i], line.img[(i + 1) % line.img.size()], Bgr(line.color), thickness);
  }
  void operator()(const render::Polygon& polygon) { Fill(polygon.img, polygon.color, cv::LINE_AA); }
  void operator()(const render::Patch& patch) {
    Fill({patch.img.begin(), patch.img.end()}, patch.color, cv::LINE_8);
  }
  void operator()(const render::Spot& spot) {
    Disc(Layer(spot.color), spot.img, spot.radius * scale_, Bgr(spot.color));
  }
  void operator()(const render::Label&) {}  // only the display draws words

 private:
  void Fill(const std::vector<Vector2d>& img, const render::Rgba& color, int kind) {
    std::vector<cv::Point> corners;
    for (const Vector2d& corner : img) corners.push_back(Subpixel(corner));
    cv::fillConvexPoly(Layer(color), corners, Bgr(color), kind, kSubpixelBits);
  }
  cv::Mat& Layer(const render::Rgba& color) {
    if (layer_.empty() || color.a != opacity_) {
      LayDown();
      layer_ = image_.clone();
      opacity_ = color.a;
    }
    return layer_;
  }
  void LayDown() {
    if (!layer_.empty()) cv::addWeighted(layer_, opacity_ / 255.0, image_, 1 - opacity_ / 255.0, 0, image_);
    layer_.release();
  }

  cv::Mat& image_;
  double scale_;
  cv::Mat layer_;
  std::uint8_t opacity_ = 255;
};

CoverageMap OnFineGrid(const CoverageMap& map) {
  CoverageMapOptions options = map.options();
  options.cells_per_disc_radius = 16;
  CoverageMap fine(map.subject(), options, map.views());
  if (map.threshold_factor()) fine.SetThresholdFactor(map.threshold_factor());
  return fine;
}

cv::Mat NothingRecorded(int width) {
  cv::Mat empty(width / 2, width, CV_8UC3, cv::Scalar::all(250));
  Text(empty, "nothing recorded yet", {0.5 * width, 0.25 * width}, 0.6, kInk, 0.5);
  return empty;
}

}  // namespace

cv::Mat DrawCoverageMap(const CoverageMap& map, const CoverageMapPicture& picture) {
  if (!map.frame()) return NothingRecorded(picture.width);
  const Chart chart = LayOut(map, picture.width);
  const std::vector<CapGap> gaps = map.options().cap ? GapsOf(map) : std::vector<CapGap>{};
  cv::Mat canvas(static_cast<int>(chart.area.br().y) + kLegendAt + kLine * (gaps.empty() ? 1 : 3) + 16,
                 picture.width, CV_8UC3, cv::Scalar::all(250));
  std::optional<Vector3d> camera_in_world;
  if (picture.cam_from_world) camera_in_world = picture.cam_from_world->OriginInSource();
  const double distance =
      camera_in_world ? (*camera_in_world - map.subject().center_in_world).norm() : map.reference_distance();
  PaintChart(canvas, chart, map, OnFineGrid(map), DistanceColors(map, distance, Palette::Standard()));
  DrawLinesAndViews(canvas, chart, map);
  if (camera_in_world) {
    const CapFrame::Angles at = map.frame()->Of(DirectionOf(map, *camera_in_world));
    Disc(canvas, chart.ImgOf(at.azimuth, at.elevation), 6.5, kWhite);
    Disc(canvas, chart.ImgOf(at.azimuth, at.elevation), 5, kCamera);
  }
  std::string caption =
      Counted(map.views().size(), "view") +
      (map.threshold_factor() ? ", as measured"
                              : fmt::format(", within {:g} px", map.options().threshold_px));
  if (map.options().cap)
    caption = fmt::format("{:.1f} % of {:g} x {:g} degrees covered, ", 100 * map.CoveredShare(),
                          map.options().cap->Degrees().x(), map.options().cap->Degrees().y()) +
              caption;
  Text(canvas, caption, {chart.area.x, 26}, 0.55, kInk);
  DrawLegend(canvas, chart, camera_in_world.has_value());
  if (gaps.empty()) return canvas;
  const Vector2d below_legend(chart.area.x, chart.area.br().y + kLegendAt + 2 * kLine);
  Text(canvas, InWords(gaps, *map.options().cap, kDegree), below_legend, 0.42, kInk);
  Text(canvas, NumberGaps(canvas, chart, gaps), below_legend + Vector2d(0, kLine), 0.42, kInk);
  return canvas;
}

cv::Mat DrawErrorMap(const CoverageMap& map, const ErrorMap& errors, double goal_db,
                     const CoverageMapPicture& picture) {
  if (!map.frame()) return NothingRecorded(picture.width);
  const Chart chart = LayOut(map, picture.width);
  const ErrorSummary summary = Summarize(errors, goal_db);
  const int lines = static_cast<int>(summary.causes.size());
  cv::Mat canvas(static_cast<int>(chart.area.br().y) + kLegendAt + 16 + kLine * lines, picture.width, CV_8UC3,
                 cv::Scalar::all(250));
  cv::rectangle(canvas, cv::Rect(chart.area), cv::Scalar::all(225), cv::FILLED);
  const Palette& palette = Palette::Standard();
  const double px_per_radian = chart.area.width / (chart.right - chart.left);
  struct Letter {
    Vector2d img;
    const char* text;
  };
  std::vector<Letter> letters;
  for (const ErrorMap::Part* part : errors.Parts()) {
    const MeasuredFrame& frame = part->frame;
    if (!frame.measurable) continue;
    const CapFrame::Angles at = map.frame()->Of(frame.direction);
    const Vector2d img = chart.ImgOf(at.azimuth, at.elevation);
    if (!chart.area.contains(cv::Point2d(img.x(), img.y()))) continue;
    cv::Mat inside = canvas(cv::Rect(chart.area));  // discs at the rim are cut off
    Disc(inside, img - Vector2d(chart.area.x, chart.area.y), std::max(3.0, Radians(0.75) * px_per_radian),
         Bgr(palette.OfError(part->DbNow() - goal_db)));
    const auto covered = map.At(frame.direction);
    if (part->DbNow() < goal_db && covered && covered->index >= 0)
      letters.push_back({img, LetterOf(frame.cause)});
  }
  DrawLinesAndViews(canvas, chart, map);
  for (const Letter& letter : letters) Text(canvas, letter.text, letter.img + Vector2d(4, 4), 0.35, kInk);
  const std::string caption =
      summary.directions == 0
          ? std::string("nothing could be measured")
          : fmt::format(
                "picture quality: {} ({:.1f} dB, median of {}), {} ({:.1f} dB) in the worst tenth; {} below "
                "{:g} dB",
                QualityInWords(summary.median_db), summary.median_db,
                Counted(summary.directions, "direction"), QualityInWords(summary.worst_tenth_db),
                summary.worst_tenth_db, summary.failing, goal_db);
  Text(canvas, caption, {chart.area.x, 26}, 0.55, kInk);
  double y = chart.area.br().y + kLegendAt, x = chart.area.x;
  constexpr double kStep_db = 3;
  for (double off = -Palette::kErrorReach_db; off <= Palette::kErrorReach_db; off += kStep_db) {
    DrawLegendPatch(canvas, x, y, Bgr(palette.OfError(off)));
    Text(canvas, fmt::format("{:g} dB", goal_db + off), {x + 20, y}, 0.42, kInk);
    x += 92;
  }
  Disc(canvas, {x + 4, y - 4}, 2.5, kInk);
  Text(canvas, "recorded view", {x + 12, y}, 0.42, kInk);
  for (const auto& [cause, count] : summary.causes) {
    y += kLine;
    Text(canvas, fmt::format("{}   {} ({})", LetterOf(cause), InWords(cause), count), {chart.area.x, y}, 0.42,
         kInk);
  }
  return canvas;
}

cv::Mat DrawOverlay(const cv::Mat& live, const CameraModel& camera, const Rigid3& cam_from_world,
                    const CoverageMap& map) {
  CaptureState state;
  state.camera = camera;
  state.tracking = tracking::TrackState::kTracking;
  state.cam_from_world = cam_from_world;
  state.subject = map.subject();
  state.coverage = std::make_shared<const CoverageMap>(OnFineGrid(map));
  cv::Mat image = live.clone();
  {
    ShapePainter painter(image, std::max(1.0, camera.width / 1280.0));
    for (const render::OverlayShape& shape : MakeOverlay(state)) std::visit(painter, shape);
  }
  return image;
}

}  // namespace ulf::coverage
