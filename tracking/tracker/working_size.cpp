#include "tracking/tracker/working_size.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/geometry/digest.h"

namespace ulf::tracking {

using Eigen::Vector2d;

void RequireSize(const std::string& what, const cv::Size& size, const CameraModel& camera,
                 const char* way_out) {
  if (size.width != camera.width || size.height != camera.height)
    throw Error("{} is {}x{}, the camera's intrinsics are for {}x{}; {}", what, size.width, size.height,
                camera.width, camera.height, way_out);
}

WorkingSize::WorkingSize(const CameraModel& original, int max_side_px)
    : original_(original), working_(original) {
  const int side_px = std::max(original.width, original.height);
  if (max_side_px <= 0 || side_px <= max_side_px) return;
  const auto reduced = [&](int px) {
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(px) * max_side_px / side_px)));
  };
  working_ = original.ScaledTo(reduced(original.width), reduced(original.height));
}

void WorkingSize::SetWorking(const CameraModel& working) {
  working_ = working;
  original_ = IsReduced() ? working.ScaledTo(original_.width, original_.height) : working;
}

// Averages over areas: first by a whole factor where the sizes have one, which OpenCV does ten times as fast,
// then by the rest. Linear interpolation suffices for a small remaining factor.
cv::Mat WorkingSize::Reduced(const cv::Mat& original) const {
  if (!IsReduced()) return original;
  constexpr double kLinearSuffices = 1.5;  // original pixels for one working pixel. Guessed
  const cv::Size size(working_.width, working_.height);
  int whole = std::min(original.cols / size.width, original.rows / size.height);
  while (whole > 1 && (original.cols % whole != 0 || original.rows % whole != 0)) --whole;
  cv::Mat stepped = original, working;
  if (whole > 1)
    cv::resize(original, stepped, {original.cols / whole, original.rows / whole}, 0, 0, cv::INTER_AREA);
  if (stepped.size() == size) return stepped;
  const double left = std::max(static_cast<double>(stepped.cols) / size.width,
                               static_cast<double>(stepped.rows) / size.height);
  cv::resize(stepped, working, size, 0, 0, left > kLinearSuffices ? cv::INTER_AREA : cv::INTER_LINEAR);
  return working;
}

Vector2d WorkingSize::WorkingByOriginal() const {
  return {static_cast<double>(working_.width) / original_.width,
          static_cast<double>(working_.height) / original_.height};
}

FiducialObservation WorkingSize::Reduced(const FiducialObservation& original) const {
  return IsReduced() ? Scaled(original, WorkingByOriginal()) : original;
}

Vector2d WorkingSize::ToOriginal(const Vector2d& working) const {
  return IsReduced() ? Vector2d(working.cwiseQuotient(WorkingByOriginal())) : working;
}

double WorkingSize::ToOriginal(double working_px) const {
  return IsReduced() ? working_px / WorkingByOriginal().mean() : working_px;
}

std::uint64_t WorkingSize::KeyAtWorkingSize(std::uint64_t key) const {
  if (!IsReduced()) return key;
  Digest digest;
  digest.Add(std::as_bytes(std::span(&key, 1)));
  digest.Add(static_cast<double>(working_.width));
  digest.Add(static_cast<double>(working_.height));
  return digest.Value();
}

}  // namespace ulf::tracking
