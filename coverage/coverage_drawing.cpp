#include "coverage/coverage_drawing.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "acquisition/counted.h"
#include "coverage/sphere_outline.h"

namespace ulf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const cv::Vec3f kGreen(90, 190, 70), kRed(60, 60, 225), kBlue(230, 120, 50);  // B, G, R
const cv::Scalar kWhite(255, 255, 255), kInk(45, 45, 45), kAlarm(50, 50, 230), kCamera(40, 30, 235);
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
void Dot(cv::Mat& image, const Vector2d& at, double radius, const cv::Scalar& color) {
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

void Text(cv::Mat& image, const std::string& text, const Vector2d& at, double size, const cv::Scalar& color,
          double align = 0) {
  int baseline = 0;
  const cv::Size extent = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline);
  cv::putText(image, text, {static_cast<int>(at.x() - align * extent.width), static_cast<int>(at.y())},
              cv::FONT_HERSHEY_SIMPLEX, size, color, 1, cv::LINE_AA);
}

// Turns a recorded distance into a colour, seen from the current one.
class DistanceColors {
 public:
  DistanceColors(const CoverageMap& map, double current_distance) : current_distance_(current_distance) {
    const CriterionView& camera = map.views().front();
    const auto window = DistanceWindow({.focal_px = camera.fx,
                                        .distance = map.reference_distance(),
                                        .radius = map.subject().radius,
                                        .threshold_px = map.options().threshold_px});
    // Ratios of current to recorded distance; a side without a limit takes the other's.
    if (window && window->near) nearest_ = *window->near;
    farthest_ = window && window->far ? *window->far : 1 / nearest_;
    center_ = map.subject().center_in_world;
  }
  cv::Vec3f Of(const CriterionView& recorded) const {
    const double ratio = current_distance_ / (recorded.center_in_world - center_).norm();
    const bool farther = ratio < 1;  // the recorded view is
    const double share =
        farther ? std::log(ratio) / std::log(nearest_) : std::log(ratio) / std::log(farthest_);
    const float mix = static_cast<float>(std::clamp(share, 0.0, 1.0));
    return (1 - mix) * kGreen + mix * (farther ? kRed : kBlue);
  }

 private:
  double current_distance_;
  double nearest_ = 0.9, farthest_ = 1.1;
  Vector3d center_;
};

Vector3d DirectionOf(const CoverageMap& map, const Vector3d& position_in_world) {
  return (position_in_world - map.subject().center_in_world).normalized();
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
  const double margin = std::max(4 * M_PI / 180, 0.12 * half_height);
  half_width = std::min(M_PI, half_width + margin);
  half_height = std::min(M_PI / 2, std::max(half_height + margin, 0.25 * half_width));
  const double pixels = width - 76;
  return {-half_width, half_width, -half_height, half_height,
          cv::Rect2d(52, 40, pixels, std::round(pixels * half_height / half_width))};
}

void PaintChart(cv::Mat& canvas, const Chart& chart, const CoverageMap& map, const DistanceColors& colors) {
  const cv::Vec3f outside(232, 232, 232), uncovered(196, 196, 196);
  constexpr int kSamples = 2;  // a side: smooth edges
  for (int y = 0; y < static_cast<int>(chart.area.height); ++y)
    for (int x = 0; x < static_cast<int>(chart.area.width); ++x) {
      cv::Vec3f sum(0, 0, 0);
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const double u = x + (k % kSamples + 0.5) / kSamples, v = y + (k / kSamples + 0.5) / kSamples;
        const double azimuth = chart.left + u / chart.area.width * (chart.right - chart.left);
        const double elevation = chart.top - v / chart.area.height * (chart.top - chart.bottom);
        const auto paint = map.At(map.frame()->Direction(azimuth, elevation));
        sum += !paint             ? outside
               : paint->index < 0 ? uncovered
                                  : colors.Of(map.views()[static_cast<std::size_t>(paint->index)]);
      }
      canvas.at<cv::Vec3b>(static_cast<int>(chart.area.y) + y, static_cast<int>(chart.area.x) + x) =
          sum / float{kSamples * kSamples};
    }
}

void DrawGraticule(cv::Mat& canvas, const Chart& chart) {
  const double span_deg = (chart.right - chart.left) * 180 / M_PI;
  const double step_deg = span_deg > 200 ? 45 : span_deg > 90 ? 20 : span_deg > 25 ? 10 : 5;
  const double step = step_deg * M_PI / 180;
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
}

void DrawCapOutline(cv::Mat& canvas, const Chart& chart, const Cap& cap) {
  const double x = 0.5 * cap.width, y = 0.5 * cap.height;
  const Vector2d corners[] = {chart.ImgOf(-x, y), chart.ImgOf(x, y), chart.ImgOf(x, -y), chart.ImgOf(-x, -y)};
  for (int i = 0; i < 4; ++i) Line(canvas, corners[i], corners[(i + 1) % 4], kInk, 2);
}

void DrawLegend(cv::Mat& canvas, const Chart& chart, bool against_current) {
  const double y = chart.area.y + chart.area.height + 38;
  double x = chart.area.x;
  const auto patch = [&](const cv::Vec3f& color, const std::string& text) {
    cv::rectangle(canvas, cv::Rect(static_cast<int>(x), static_cast<int>(y) - 10, 14, 12),
                  cv::Scalar(color[0], color[1], color[2]), cv::FILLED);
    Text(canvas, text, {x + 20, y}, 0.42, kInk);
    int baseline = 0;
    x += 20 + cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, 0.42, 1, &baseline).width + 22;
  };
  const std::string against = against_current ? "than now" : "than the median";
  patch(kGreen, "recorded at the same distance");
  patch(kRed, "farther " + against);
  patch(kBlue, "nearer");
  patch(cv::Vec3f(196, 196, 196), "not covered");
  Dot(canvas, {x + 4, y - 4}, 2.5, kInk);
  Text(canvas, "recorded view", {x + 12, y}, 0.42, kInk);
  if (!against_current) return;
  Dot(canvas, {x + 120, y - 4}, 5, kCamera);
  Text(canvas, "camera", {x + 130, y}, 0.42, kInk);
}

// ---- the sphere over the live image

struct Overlay {
  cv::Mat image;
  const CameraModel& camera;
  const Rigid3& cam_from_world;
  const CoverageMap& map;
  Vector3d camera_in_world;
  Vector3d toward_camera;  // unit, from the centre
  double distance;

  // The near side of the sphere shows a direction when its surface point faces the camera.
  bool Faces(const Vector3d& direction) const {
    return direction.dot(toward_camera) > map.subject().radius / distance;
  }
  std::optional<Vector2d> ImgOf(const Vector3d& direction) const {
    return camera.ImgFromCam(cam_from_world *
                             (map.subject().center_in_world + map.subject().radius * direction));
  }
};

// The direction of the sphere's near surface point behind a pixel, if there is one.
std::optional<Vector3d> SurfaceDirection(const Overlay& overlay, const Vector2d& img) {
  const auto ray_in_cam = overlay.camera.RayFromImg(img);
  if (!ray_in_cam) return std::nullopt;
  const Vector3d ray = overlay.cam_from_world.DirectionInSource(*ray_in_cam);
  const Subject& subject = overlay.map.subject();
  const Vector3d to_center = subject.center_in_world - overlay.camera_in_world;
  const double along = ray.dot(to_center);
  const double half_squared = subject.radius * subject.radius - to_center.squaredNorm() + along * along;
  if (half_squared <= 0 || along <= 0) return std::nullopt;
  const double t = along - std::sqrt(half_squared);
  return (overlay.camera_in_world + t * ray - subject.center_in_world) / subject.radius;
}

void PaintSphere(Overlay& overlay, const std::vector<Vector2d>& outline) {
  std::optional<DistanceColors> colors;
  if (!overlay.map.views().empty()) colors.emplace(overlay.map, overlay.distance);
  Vector2d low = outline[0], high = outline[0];
  for (const Vector2d& corner : outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const cv::Vec3f uncovered(150, 150, 150);
  constexpr int kSamples = 2;
  constexpr float kCoveredOpacity = 0.6f, kUncoveredOpacity = 0.35f;
  const cv::Rect box = cv::Rect(cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
                                cv::Point(static_cast<int>(high.x()) + 1, static_cast<int>(high.y()) + 1)) &
                       cv::Rect({}, overlay.image.size());
  for (int y = box.y; y < box.br().y; ++y)
    for (int x = box.x; x < box.br().x; ++x) {
      cv::Vec3f paint(0, 0, 0);
      float opacity = 0;
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const auto direction = SurfaceDirection(
            overlay, {x + (k % kSamples + 0.5) / kSamples, y + (k / kSamples + 0.5) / kSamples});
        if (!direction) continue;
        const auto cell = overlay.map.At(*direction);
        const bool covered = cell && cell->index >= 0;
        const float share = (covered ? kCoveredOpacity
                             : cell  ? kUncoveredOpacity
                                     : 0.5f * kUncoveredOpacity) /
                            float{kSamples * kSamples};
        paint += share * (covered ? colors->Of(overlay.map.views()[static_cast<std::size_t>(cell->index)])
                                  : uncovered);
        opacity += share;
      }
      auto& pixel = overlay.image.at<cv::Vec3b>(y, x);
      pixel = cv::Vec3b((1 - opacity) * cv::Vec3f(pixel) + paint);
    }
}

// A curve on the sphere: the part that faces the camera.
template <typename DirectionAt>
void DrawCurve(Overlay& overlay, const DirectionAt& direction_at, const cv::Scalar& color, int thickness) {
  constexpr int kSteps = 180;
  std::optional<Vector2d> last;
  for (int i = 0; i <= kSteps; ++i) {
    const Vector3d direction = direction_at(static_cast<double>(i) / kSteps);
    const auto img = overlay.Faces(direction) ? overlay.ImgOf(direction) : std::nullopt;
    if (img && last) Line(overlay.image, *last, *img, color, thickness);
    last = img;
  }
}

void DrawWireframe(Overlay& overlay) {
  const CapFrame frame = overlay.map.frame().value_or(
      CapFrame(overlay.toward_camera, overlay.cam_from_world.DirectionInSource(-Vector3d::UnitY())));
  cv::Mat lines = overlay.image.clone();
  Overlay wire{lines,           overlay.camera,          overlay.cam_from_world,
               overlay.map,     overlay.camera_in_world, overlay.toward_camera,
               overlay.distance};
  constexpr int kStepDeg = 10;
  for (int deg = -180; deg < 180; deg += kStepDeg)
    DrawCurve(
        wire, [&](double t) { return frame.Direction(deg * M_PI / 180, (t - 0.5) * M_PI); }, kWhite, 1);
  for (int deg = -80; deg <= 80; deg += kStepDeg)
    DrawCurve(
        wire, [&](double t) { return frame.Direction((2 * t - 1) * M_PI, deg * M_PI / 180); }, kWhite, 1);
  cv::addWeighted(wire.image, 0.5, overlay.image, 0.5, 0, overlay.image);
  if (!overlay.map.options().cap) return;
  const double x = 0.5 * overlay.map.options().cap->width, y = 0.5 * overlay.map.options().cap->height;
  for (const double side : {-1.0, 1.0}) {
    DrawCurve(
        overlay, [&](double t) { return frame.Direction(side * x, (2 * t - 1) * y); }, kWhite, 2);
    DrawCurve(
        overlay, [&](double t) { return frame.Direction((2 * t - 1) * x, side * y); }, kWhite, 2);
  }
}

}  // namespace

CoverageMap RefinedForPictures(const CoverageMap& map) {
  CoverageMapOptions options = map.options();
  options.cells_per_disc_radius = 16;
  CoverageMap refined(map.subject(), options);
  refined.SetViews(map.views());
  return refined;
}

cv::Mat DrawCoverageMap(const CoverageMap& map, const CoverageMapPicture& picture) {
  if (!map.frame()) {
    cv::Mat empty(picture.width / 2, picture.width, CV_8UC3, cv::Scalar::all(250));
    Text(empty, "nothing recorded yet", {0.5 * picture.width, 0.25 * picture.width}, 0.6, kInk, 0.5);
    return empty;
  }
  const Chart chart = LayOut(map, picture.width);
  cv::Mat canvas(static_cast<int>(chart.area.br().y) + 54, picture.width, CV_8UC3, cv::Scalar::all(250));
  std::optional<Vector3d> camera_in_world;
  if (picture.cam_from_world) camera_in_world = picture.cam_from_world->OriginInSource();
  const double distance =
      camera_in_world ? (*camera_in_world - map.subject().center_in_world).norm() : map.reference_distance();
  PaintChart(canvas, chart, map, DistanceColors(map, distance));
  DrawGraticule(canvas, chart);
  if (map.options().cap) DrawCapOutline(canvas, chart, *map.options().cap);
  for (const CriterionView& view : map.views()) {
    const CapFrame::Angles at = map.frame()->Of(DirectionOf(map, view.center_in_world));
    const Vector2d img = chart.ImgOf(at.azimuth, at.elevation);
    if (chart.area.contains(cv::Point2d(img.x(), img.y()))) Dot(canvas, img, 2.5, kInk);
  }
  if (camera_in_world) {
    const CapFrame::Angles at = map.frame()->Of(DirectionOf(map, *camera_in_world));
    Dot(canvas, chart.ImgOf(at.azimuth, at.elevation), 6.5, kWhite);
    Dot(canvas, chart.ImgOf(at.azimuth, at.elevation), 5, kCamera);
  }
  std::string caption = picture.caption;
  if (caption.empty()) {
    caption =
        fmt::format("{}, within {:g} px", Counted(map.views().size(), "view"), map.options().threshold_px);
    if (map.options().cap) caption = fmt::format("{:.1f} % covered, ", 100 * map.CoveredShare()) + caption;
  }
  Text(canvas, caption, {chart.area.x, 26}, 0.55, kInk);
  DrawLegend(canvas, chart, camera_in_world.has_value());
  return canvas;
}

cv::Mat DrawOverlay(const cv::Mat& live, const CameraModel& camera, const Rigid3& cam_from_world,
                    const CoverageMap& map, double rectangle_share) {
  Overlay overlay{.image = live.clone(),
                  .camera = camera,
                  .cam_from_world = cam_from_world,
                  .map = map,
                  .camera_in_world = cam_from_world.OriginInSource(),
                  .toward_camera = Vector3d::Zero(),
                  .distance = 0};
  const Vector3d offset = overlay.camera_in_world - map.subject().center_in_world;
  overlay.distance = offset.norm();
  const double scale = std::max(1.0, camera.width / 640.0);
  const SafetyRectangle rectangle = SafetyRectangle::Of(camera, rectangle_share);
  const auto outline = SphereOutline(camera, cam_from_world, map.subject(), 128);
  if (outline) {
    overlay.toward_camera = offset / overlay.distance;
    PaintSphere(overlay, *outline);
    DrawWireframe(overlay);
    for (std::size_t i = 0; i < outline->size(); ++i)
      Line(overlay.image, (*outline)[i], (*outline)[(i + 1) % outline->size()], kWhite, 1);
    for (const CriterionView& view : map.views()) {
      const Vector3d direction = DirectionOf(map, view.center_in_world);
      if (!overlay.Faces(direction)) continue;
      if (const auto img = overlay.ImgOf(direction)) Dot(overlay.image, *img, 1.2 * scale, kInk);
    }
    if (const auto img = overlay.ImgOf(overlay.toward_camera)) {
      Dot(overlay.image, *img, 4 * scale, kWhite);
      Dot(overlay.image, *img, 3 * scale, kCamera);
    }
  }
  const bool held = outline && rectangle.Holds(*outline);
  cv::rectangle(overlay.image, Subpixel(rectangle.low), Subpixel(rectangle.high), held ? kWhite : kAlarm,
                held ? 2 : 3, cv::LINE_AA, kSubpixelBits);
  return overlay.image;
}

}  // namespace ulf
