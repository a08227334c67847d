#include "render/prediction/frame_predictor.h"

#include <Eigen/LU>
#include <algorithm>
#include <exception>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "render/proxy/depth_raster.h"

namespace ulf::render {
namespace {

// A view does not see a point that lies behind the mesh by more than this share of its depth. Guessed: twice
// that of the renderer's shadow maps, because the mesh is coarser.
constexpr double kFramePredictorHiddenBehind = 0.02;
constexpr double kNearestAngle = 0.002;  // radians; a nearer view has the frame's own viewpoint. Guessed.
// Exposure factors are limited to this, and to its inverse.
constexpr double kMostGain = 8;

using Eigen::Matrix3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

Matrix3f Intrinsics(const CameraModel& camera) {
  Matrix3f k = Matrix3f::Identity();
  k(0, 0) = static_cast<float>(camera.fx);
  k(1, 1) = static_cast<float>(camera.fy);
  k(0, 2) = static_cast<float>(camera.cx);
  k(1, 2) = static_cast<float>(camera.cy);
  return k;
}

// The points of the frame's pixels in another camera.
struct Projection {
  cv::Mat x, y;           // CV_32F, for cv::remap
  cv::Mat inverse_depth;  // CV_32F; 0: behind the camera
};

Projection ProjectInto(const CameraModel& camera, const Rigid3& cam_from_world, const StereoView& frame,
                       const cv::Mat& inverse_depth) {
  const cv::Size size = inverse_depth.size();
  Projection projection{cv::Mat(size, CV_32F), cv::Mat(size, CV_32F), cv::Mat(size, CV_32F)};
  const Rigid3 cam_from_frame = cam_from_world * frame.cam_from_world.Inverse();
  const Matrix3f turn =
      Intrinsics(camera) * cam_from_frame.RotationMatrix().cast<float>() * Intrinsics(frame.camera).inverse();
  const Vector3f move = Intrinsics(camera) * cam_from_frame.translation.cast<float>();
  for (int row = 0; row < size.height; ++row) {
    const auto* inverse = inverse_depth.ptr<float>(row);
    auto *to_x = projection.x.ptr<float>(row), *to_y = projection.y.ptr<float>(row),
         *to_inverse = projection.inverse_depth.ptr<float>(row);
    const Vector3f start = turn.col(1) * (static_cast<float>(row) + 0.5f) + turn.col(2);
    for (int col = 0; col < size.width; ++col) {
      const float x = static_cast<float>(col) + 0.5f, near = inverse[col];
      // Lengths are in units of the point's depth in the frame.
      const float z = turn(2, 0) * x + start.z() + near * move.z();
      const bool in_front = z > 1e-6f;
      const float by = in_front ? 1 / z : 0;
      to_x[col] = in_front ? (turn(0, 0) * x + start.x() + near * move.x()) * by - 0.5f : -10;
      to_y[col] = in_front ? (turn(1, 0) * x + start.y() + near * move.y()) * by - 0.5f : -10;
      to_inverse[col] = near * by;
    }
  }
  return projection;
}

// Returns CV_32F: 1 where the point is in the view's image and has light there, else 0.
cv::Mat InImage(const StereoView& view, const Projection& at) {
  cv::Mat seen(at.x.size(), CV_32F);
  const auto right = static_cast<float>(view.camera.width - 1);
  const auto bottom = static_cast<float>(view.camera.height - 1);
  for (int row = 0; row < seen.rows; ++row) {
    const auto *x = at.x.ptr<float>(row), *y = at.y.ptr<float>(row);
    auto* to = seen.ptr<float>(row);
    for (int col = 0; col < seen.cols; ++col)
      to[col] = x[col] >= 0 && y[col] >= 0 && x[col] <= right && y[col] <= bottom ? 1.0f : 0.0f;
  }
  if (view.valid.empty()) return seen;
  cv::Mat valid;
  cv::remap(view.valid, valid, at.x, at.y, cv::INTER_NEAREST, cv::BORDER_CONSTANT, 0);
  seen.setTo(0, valid == 0);
  return seen;
}

// Returns CV_8U at half the frame's size: not 0 where the mesh hides the point from the view.
cv::Mat HiddenPart(const ShadowMap& map, const Rigid3& cam_from_world, const StereoView& half_frame,
                   const cv::Mat& half_inverse_depth) {
  const Projection at = ProjectInto(map.camera, cam_from_world, half_frame, half_inverse_depth);
  cv::Mat least;
  cv::remap(map.least_inverse_depth, least, at.x, at.y, cv::INTER_NEAREST, cv::BORDER_CONSTANT, 0);
  return at.inverse_depth < least;
}

// Returns the factor from `view` to the brightness of `frame`, where `seen`, by parts of the picture, whose
// sums hardly depend on misregistration.
double GainTo(const cv::Mat& frame, const cv::Mat& view, const cv::Mat& seen, double most_gain) {
  constexpr int kPart = 8, kStep = 2;    // pixels
  constexpr float kWhole = 0.9f;         // of a part must be seen
  constexpr float kLeastBrightness = 8;  // grey values
  constexpr float kPixels = (kPart / kStep) * (kPart / kStep);
  std::vector<double> ratios;
  for (int top = 0; top + kPart <= frame.rows; top += kPart)
    for (int left = 0; left + kPart <= frame.cols; left += kPart) {
      float of_frame = 0, of_view = 0, of_seen = 0;
      for (int y = top; y < top + kPart; y += kStep) {
        const auto *f = frame.ptr<float>(y), *v = view.ptr<float>(y), *s = seen.ptr<float>(y);
        for (int x = left; x < left + kPart; x += kStep) {
          of_frame += f[x] * s[x];
          of_view += v[x] * s[x];
          of_seen += s[x];
        }
      }
      if (of_seen > kWhole * kPixels && of_view > kLeastBrightness * kPixels)
        ratios.push_back(static_cast<double>(of_frame / of_view));
    }
  if (ratios.empty()) return 1;
  return std::clamp(Median(std::move(ratios)), 1 / most_gain, most_gain);
}

}  // namespace

cv::Mat Smoothed(const cv::Mat& grey) {
  cv::Mat smoothed;
  cv::GaussianBlur(grey, smoothed, {3, 3}, 0);  // OpenCV's kernel of this size is 1 2 1
  return smoothed;
}

void FramePredictor::SetGeometry(const Subject& subject, std::shared_ptr<const TriangleMesh> mesh) {
  subject_ = subject;
  if (mesh_ == mesh) return;
  mesh_ = std::move(mesh);
  for (auto& [id, entry] : views_) entry.hidden.reset();
}

void FramePredictor::AddView(int id, const Rigid3& cam_from_world, std::function<StereoView()> read) {
  views_.insert_or_assign(id,
                          Entry{cam_from_world, cam_from_world.OriginInSource(), std::move(read), {}, {}});
}

void FramePredictor::AddView(int id, const StereoView& view) {
  views_.insert_or_assign(id,
                          Entry{view.cam_from_world, view.center_in_world, nullptr, ForStorage(view), {}});
}

StereoView FramePredictor::ForStorage(StereoView view) {
  Smoothed(view.grey).convertTo(view.grey, CV_8U);  // a quarter of the memory
  return view;
}

void FramePredictor::MoveViews(const std::map<int, Rigid3>& cam_from_world) {
  for (const auto& [id, pose] : cam_from_world)
    if (const auto found = views_.find(id); found != views_.end()) {
      found->second.cam_from_world = pose;
      found->second.center_in_world = pose.OriginInSource();
      found->second.hidden.reset();
    }
}

const StereoView& FramePredictor::PictureOf(Entry& entry) {
  if (!entry.view) {
    entry.view = ForStorage(entry.read());
    entry.read = nullptr;
  }
  entry.view->cam_from_world = entry.cam_from_world;
  entry.view->center_in_world = entry.center_in_world;
  return *entry.view;
}

bool FramePredictor::CanBeRead(Entry& entry) {
  try {
    PictureOf(entry);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

std::vector<FramePredictor::Near> FramePredictor::NearestReadable(const Vector3d& center_in_world,
                                                                  std::size_t count) {
  for (;;) {
    std::vector<Near> near = NearestTo(center_in_world, count);
    const auto damaged = std::ranges::find_if(near, [](const Near& each) { return !CanBeRead(*each.entry); });
    if (damaged == near.end()) return near;
    views_.erase(damaged->id);
  }
}

std::vector<FramePredictor::Near> FramePredictor::NearestTo(const Vector3d& center_in_world,
                                                            std::size_t count) {
  std::vector<Near> near;
  near.reserve(views_.size());
  const Vector3d direction = center_in_world - subject_.center_in_world;
  for (auto& [id, entry] : views_)
    near.push_back({AngleBetween(direction, entry.center_in_world - subject_.center_in_world), id, &entry});
  const auto by_angle = [](const Near& a, const Near& b) {
    return std::pair(a.angle, a.id) < std::pair(b.angle, b.id);
  };
  count = std::min(count, near.size());
  std::ranges::partial_sort(near, near.begin() + static_cast<std::ptrdiff_t>(count), by_angle);
  near.resize(count);
  return near;
}

double FramePredictor::NearestViewAngle(const Vector3d& center_in_world) const {
  double nearest = std::numeric_limits<double>::infinity();
  const Vector3d direction = center_in_world - subject_.center_in_world;
  for (const auto& [id, entry] : views_)
    nearest = std::min(nearest, AngleBetween(direction, entry.center_in_world - subject_.center_in_world));
  return nearest;
}

double FramePredictor::OneSided(const Vector3d& center_in_world, const std::vector<Near>& near) const {
  const Vector3d direction = (center_in_world - subject_.center_in_world).normalized();
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  for (const Near& view : near) {
    const Vector3d toward = view.entry->center_in_world - subject_.center_in_world;
    const Vector3d aside = toward - toward.dot(direction) * direction;
    if (view.angle < kNearestAngle || !(aside.norm() > 0)) return 0;  // the frame's own viewpoint
    sum += aside.normalized();
    ++count;
  }
  return count > 0 ? sum.norm() / count : 1;
}

std::optional<PredictedFrame> FramePredictor::Predict(const StereoView& frame) {
  if (!mesh_ || views_.empty()) return std::nullopt;
  PredictedFrame predicted;
  predicted.inverse_depth = DrawInverseDepth(*mesh_, frame.camera, frame.cam_from_world);
  predicted.on_mesh = predicted.inverse_depth > 0;
  FillHoles(predicted.inverse_depth);
  if (cv::countNonZero(predicted.inverse_depth) == 0) return std::nullopt;  // the picture shows no mesh

  const auto blended = At(options_.views);
  const std::vector<Near> near = NearestReadable(frame.center_in_world, blended + 1);
  // Without one more view to end the weights, the last one keeps half of its own.
  const double end = near.size() > blended ? near.back().angle : 2 * near.back().angle;
  const cv::Mat smoothed = Smoothed(frame.grey);
  const cv::Size size = smoothed.size();
  StereoView half_frame;
  half_frame.camera = frame.camera.ScaledTo(std::max(1, size.width / 2), std::max(1, size.height / 2));
  half_frame.cam_from_world = frame.cam_from_world;
  cv::Mat half_inverse_depth;  // nearest: no depths between a front and its background
  cv::resize(predicted.inverse_depth, half_inverse_depth, {half_frame.camera.width, half_frame.camera.height},
             0, 0, cv::INTER_NEAREST);
  cv::Mat sum = cv::Mat::zeros(size, CV_32F), sum_of_squares = sum.clone(), weight = sum.clone();
  double weights = 0, squared_weights = 0;
  for (std::size_t i = 0; i < std::min(blended, near.size()); ++i) {
    Entry& entry = *near[i].entry;
    const double angle = std::max(near[i].angle, kNearestAngle);
    const double share = std::max(1 - near[i].angle / std::max(end, kNearestAngle), 0.0) / angle;
    if (share <= 0 && i > 0) continue;
    const StereoView& view = PictureOf(entry);
    const Projection at = ProjectInto(view.camera, view.cam_from_world, frame, predicted.inverse_depth);
    cv::Mat seen = InImage(view, at);
    if (!entry.hidden)
      entry.hidden = MakeShadowMap(*mesh_, view.camera, view.cam_from_world, kFramePredictorHiddenBehind);
    cv::Mat hidden;
    cv::resize(HiddenPart(*entry.hidden, view.cam_from_world, half_frame, half_inverse_depth), hidden, size,
               0, 0, cv::INTER_NEAREST);
    seen.setTo(0, hidden);
    cv::Mat values;
    cv::Mat grey;  // rounded values would be interpolated to whole numbers again
    view.grey.convertTo(grey, CV_32F);
    cv::remap(grey, values, at.x, at.y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    const double gain = GainTo(smoothed, values, seen, kMostGain);
    values *= gain;
    const cv::Mat part = std::max(share, 1e-6) * seen;
    const cv::Mat weighted = part.mul(values);
    sum += weighted;
    cv::accumulateProduct(weighted, values, sum_of_squares);
    weight += part;
    weights += share;
    squared_weights += share * share * gain * gain;
    predicted.views.push_back({near[i].id, values, seen, share, gain});
  }
  predicted.nearest_view_angle = near.front().angle;
  predicted.one_sided = OneSided(frame.center_in_world, near);
  predicted.valid = weight > 0;
  if (cv::countNonZero(predicted.valid) == 0) return std::nullopt;
  weight.setTo(1, predicted.valid == 0);  // where the sums are 0
  cv::divide(sum, weight, predicted.grey);
  cv::divide(sum_of_squares, weight, predicted.variance_of_views);
  predicted.variance_of_views -= predicted.grey.mul(predicted.grey);
  for (PredictedByView& view : predicted.views) view.weight = weights > 0 ? view.weight / weights : 1;
  predicted.noise_share = weights > 0 ? squared_weights / (weights * weights) : 1;
  return predicted;
}

}  // namespace ulf::render
