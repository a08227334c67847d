#include "core/image/undistortion.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/geometry/angles.h"

namespace ulf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Largest angle of an undistorted image to its axis. Guessed: beyond it pixels are stretched by more than 4.
constexpr double kMostAngle = Radians(60);

// Returns whether interpolation at a point needs only pixels of the image.
bool HoldsPixel(const CameraModel& camera, const Vector2d& img) {
  return img.x() >= 0.5 && img.y() >= 0.5 && img.x() <= camera.width - 0.5 && img.y() <= camera.height - 0.5;
}

// Returns whether the image contains a window around the axis on the plane at distance 1.
bool HoldsWindow(const CameraModel& camera, const Vector2d& half) {
  if (half.norm() > std::tan(kMostAngle)) return false;
  const auto holds = [&](double x, double y) {
    const auto img = camera.ImgFromCam({x, y, 1});
    return img && HoldsPixel(camera, *img);
  };
  // The rim suffices, because it encloses the image of the interior.
  constexpr int kSteps = 64;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double x = half.x() * i / kSteps, y = half.y() * i / kSteps;
    if (!holds(x, -half.y()) || !holds(x, half.y()) || !holds(-half.x(), y) || !holds(half.x(), y))
      return false;
  }
  return true;
}

// Returns the largest window of that shape (height over width on the plane).
Vector2d LargestOfShape(const CameraModel& camera, double shape) {
  double fits = 0, too_large = std::tan(kMostAngle);
  while (too_large - fits > 1e-4 / camera.fx) {
    const double middle = 0.5 * (fits + too_large);
    (HoldsWindow(camera, {middle, shape * middle}) ? fits : too_large) = middle;
  }
  return {fits, shape * fits};
}

// Returns the largest window by area; the search over shapes starts at the picture's own.
Vector2d LargestWindow(const CameraModel& camera) {
  const double own = (camera.height / camera.fy) / (camera.width / camera.fx);
  double best_log = 0, reach = std::log(4.0);
  Vector2d best = LargestOfShape(camera, own);
  constexpr int kRounds = 5, kTried = 8;
  for (int round = 0; round < kRounds; ++round, reach /= 4) {
    const double around = best_log;
    for (int i = -kTried; i <= kTried; ++i) {
      const double log_shape = around + reach * i / kTried;
      const Vector2d half = LargestOfShape(camera, own * std::exp(log_shape));
      if (half.prod() <= best.prod()) continue;
      best = half;
      best_log = log_shape;
    }
  }
  return best;
}

bool CoversAllPixels(const Undistortion& undistortion) {
  const CameraModel& to = undistortion.to;
  const Vector2d half((0.5 * to.width - 0.5) / to.fx, (0.5 * to.height - 0.5) / to.fy);
  return HoldsWindow(undistortion.from, half);
}

bool IsCentredPinhole(const CameraModel& camera) {
  return camera.WithoutDistortion() == camera && camera.cx == 0.5 * camera.width &&
         camera.cy == 0.5 * camera.height;
}

// Returns the share of the source's area in the result, between the centres of the outermost pixels.
double KeptShare(const CameraModel& from, const CameraModel& to) {
  double area = 0;
  constexpr int kSteps = 200;
  Vector2d before = Vector2d::Zero(), first = Vector2d::Zero();
  for (int i = 0; i < 4 * kSteps; ++i) {
    const double along = static_cast<double>(i % kSteps) / kSteps;
    const Vector2d corner[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const Vector2d at = corner[i / kSteps] + along * (corner[(i / kSteps + 1) % 4] - corner[i / kSteps]);
    const Vector2d in_to(0.5 + at.x() * (to.width - 1), 0.5 + at.y() * (to.height - 1));
    const Vector2d in_from = *from.ImgFromCam(*to.RayFromImg(in_to));
    if (i == 0) first = in_from;
    if (i > 0) area += 0.5 * (before.x() * in_from.y() - before.y() * in_from.x());
    before = in_from;
  }
  area += 0.5 * (before.x() * first.y() - before.y() * first.x());
  return std::abs(area) / ((from.width - 1.0) * (from.height - 1.0));
}

CameraModel WithoutZeroDistortion(const CameraModel& camera) {
  const bool straight =
      camera.distortion == Distortion::kRadialTangential && camera.coefficients == std::array<double, 5>{};
  return straight ? camera.WithoutDistortion() : camera;
}

CameraModel PinholeOfWindow(const Vector2d& half, double fx, double fy) {
  CameraModel camera = CameraModel::Pinhole(static_cast<int>(std::floor(2 * half.x() * fx)) + 1,
                                            static_cast<int>(std::floor(2 * half.y() * fy)) + 1, fx);
  camera.fy = fy;
  return camera;
}

void RequireAxisInPicture(const Vector2d& half, const Undistortion& undistortion, const std::string& owner) {
  constexpr int kLeast = 16;
  const CameraModel& camera = undistortion.from;
  if (half.x() <= 0 || undistortion.to.width < kLeast || undistortion.to.height < kLeast)
    throw Error(
        "{}: its optical axis is outside its picture (principal point {:.1f} {:.1f} of {}x{}); correct the "
        "intrinsics, or export without {}",
        owner, camera.cx, camera.cy, camera.width, camera.height, Parameter("undistort"));
}

// Rounding may have moved the last pixel outside.
void Finish(const Vector2d& half, Undistortion& result) {
  while (!CoversAllPixels(result)) {
    --result.to.width;
    --result.to.height;
    result.to.cx = 0.5 * result.to.width;
    result.to.cy = 0.5 * result.to.height;
  }
  result.is_limited = half.norm() > 0.999 * std::tan(kMostAngle);
  result.kept_share = KeptShare(result.from, result.to);
}

}  // namespace

Undistortion UndistortionOf(const CameraModel& camera, const std::string& owner) {
  Undistortion result;
  result.from = camera;
  result.to = WithoutZeroDistortion(camera);
  if (IsCentredPinhole(result.to)) {
    result.is_identity = true;
    return result;
  }
  const Vector2d half = LargestWindow(camera);
  result.to = PinholeOfWindow(half, camera.fx, camera.fy);
  RequireAxisInPicture(half, result, owner);
  Finish(half, result);
  return result;
}

std::vector<Undistortion> UndistortionsToOne(const std::vector<CameraModel>& cameras,
                                             const std::vector<std::string>& owners) {
  std::vector<Undistortion> results;
  const CameraModel first = cameras.empty() ? CameraModel() : WithoutZeroDistortion(cameras.front());
  if (first.fx == first.fy && IsCentredPinhole(first) &&
      std::ranges::all_of(
          cameras, [&](const CameraModel& camera) { return WithoutZeroDistortion(camera) == first; })) {
    for (const CameraModel& camera : cameras) results.push_back({camera, first, true, false, 1});
    return results;
  }
  Vector2d half = Vector2d::Constant(std::tan(kMostAngle));
  double focal_px = 0;
  for (const CameraModel& camera : cameras) {
    half = half.cwiseMin(LargestWindow(camera));
    focal_px = std::max(focal_px, camera.MeanFocalPx());
  }
  CameraModel to = PinholeOfWindow(half, focal_px, focal_px);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    Undistortion& result = results.emplace_back();
    result.from = cameras[i];
    result.to = to;
    RequireAxisInPicture(half, result, owners[i]);
    Finish(half, result);
    to = result.to;
  }
  for (Undistortion& result : results) {
    result.to = to;
    result.kept_share = KeptShare(result.from, to);
    result.is_identity = WithoutZeroDistortion(result.from) == to;
  }
  return results;
}

UndistortionMap MapOf(const Undistortion& undistortion) {
  const CameraModel &from = undistortion.from, &to = undistortion.to;
  UndistortionMap map{cv::Mat(to.height, to.width, CV_32F), cv::Mat(to.height, to.width, CV_32F)};
  for (int v = 0; v < to.height; ++v)
    for (int u = 0; u < to.width; ++u) {
      const Vector3d ray((u + 0.5 - to.cx) / to.fx, (v + 0.5 - to.cy) / to.fy, 1);
      const Vector2d img = *from.ImgFromCam(ray);  // OpenCV's origin is the first pixel's centre
      map.x.at<float>(v, u) = static_cast<float>(img.x() - 0.5);
      map.y.at<float>(v, u) = static_cast<float>(img.y() - 0.5);
    }
  return map;
}

cv::Mat Undistorted(const UndistortionMap& map, const cv::Mat& pixels) {
  cv::Mat result;
  // OpenCV's cubic interpolation moves edges by up to a sixteenth of a pixel.
  cv::remap(pixels, result, map.x, map.y, cv::INTER_LANCZOS4, cv::BORDER_REPLICATE);
  return result;
}

cv::Mat UndistortedMask(const UndistortionMap& map, const cv::Mat& mask) {
  cv::Mat used = mask > 0, result;
  cv::remap(used, result, map.x, map.y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return result == 255;
}

}  // namespace ulf
