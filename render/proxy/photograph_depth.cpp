#include "render/proxy/photograph_depth.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/depth_raster.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/proxy_choice.h"
#include "render/proxy/shadow_map.h"

namespace ulf::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Texels of a map whose inverse depths differ by more than this share lie on different surfaces. As of
// shadow maps.
constexpr float kJumpShare = 0.1f;

// Inverse depths at the pixel centres of a pinhole camera.
struct InverseDepths {
  CameraModel camera;
  cv::Mat values;  // CV_32F; 0: unknown

  // Interpolates on a surface; across an edge it takes the nearest texel. Returns 0 outside, or if unknown.
  float At(const Vector2d& slope) const;
};

float InverseDepths::At(const Vector2d& slope) const {
  const double x = camera.fx * slope.x() + camera.cx, y = camera.fy * slope.y() + camera.cy;
  if (!camera.Contains({x, y})) return 0;
  const int left = static_cast<int>(std::floor(x - 0.5)), top = static_cast<int>(std::floor(y - 0.5));
  const auto right_share = static_cast<float>(x - 0.5 - left),
             below_share = static_cast<float>(y - 0.5 - top);
  const auto texel = [&](int column, int row) {
    return values.at<float>(std::clamp(row, 0, camera.height - 1), std::clamp(column, 0, camera.width - 1));
  };
  const float a = texel(left, top), b = texel(left + 1, top), c = texel(left, top + 1),
              d = texel(left + 1, top + 1);
  const auto [least, most] = std::minmax({a, b, c, d});
  if (least <= 0 || most - least > kJumpShare * most)
    return right_share < 0.5f ? (below_share < 0.5f ? a : c) : (below_share < 0.5f ? b : d);
  return (1 - below_share) * ((1 - right_share) * a + right_share * b) +
         below_share * ((1 - right_share) * c + right_share * d);
}

// The slopes (x / z, y / z) of the rays through pixel centres. Rays of a lens with distortion are
// interpolated between nodes that are at most a hundredth of a radian apart.
class Slopes {
 public:
  explicit Slopes(const CameraModel& camera)
      : camera_(camera), step_px_(std::clamp(static_cast<int>(camera.MeanFocalPx() / 128), 1, 8)) {
    if (camera.distortion == Distortion::kNone) return;
    rays_ = cv::Mat(camera.height / step_px_ + 2, camera.width / step_px_ + 2, CV_64FC3);
    for (int row = 0; row < rays_.rows; ++row)
      for (int column = 0; column < rays_.cols; ++column)
        rays_.at<cv::Vec3d>(row, column) = RayAt(column, row);
  }
  // Returns none for a ray that does not go forwards.
  std::optional<Vector2d> At(int x, int y) const {
    if (rays_.empty())
      return Vector2d((x + 0.5 - camera_.cx) / camera_.fx, (y + 0.5 - camera_.cy) / camera_.fy);
    const int column = x / step_px_, row = y / step_px_;
    const double u = (x % step_px_) / static_cast<double>(step_px_),
                 v = (y % step_px_) / static_cast<double>(step_px_);
    const auto node = [&](int c, int r) { return rays_.at<cv::Vec3d>(r, c); };
    cv::Vec3d ray = node(column, row);
    if (u > 0 || v > 0)
      ray = (1 - v) * ((1 - u) * ray + u * node(column + 1, row)) +
            v * ((1 - u) * node(column, row + 1) + u * node(column + 1, row + 1));
    if (!(ray[2] > 0)) return std::nullopt;
    return Vector2d(ray[0] / ray[2], ray[1] / ray[2]);
  }

 private:
  // NaN if the distortion cannot be inverted.
  cv::Vec3d RayAt(int column, int row) const {
    const auto ray = camera_.RayFromImg({step_px_ * column + 0.5, step_px_ * row + 0.5});
    return ray ? cv::Vec3d(ray->x(), ray->y(), ray->z())
               : cv::Vec3d::all(std::numeric_limits<double>::quiet_NaN());
  }

  const CameraModel& camera_;
  const int step_px_;
  cv::Mat rays_;  // CV_64FC3, unit, for lenses with distortion
};

// Returns a camera of the same focal length, without distortion, that sees all that `camera` sees up to 71
// degrees from the axis.
CameraModel CoveringPinhole(const CameraModel& camera) {
  if (camera.distortion == Distortion::kNone) return camera;
  const CameraModel whole = ShadowMapCamera(camera);
  return whole.ScaledTo(static_cast<int>(std::ceil(whole.width * camera.fx / whole.fx)),
                        static_cast<int>(std::ceil(whole.height * camera.fy / whole.fy)));
}

InverseDepths FloatsOf(const ViewDepthMap& map) {
  InverseDepths floats{map.camera, {}};
  map.inverse_depth.convertTo(floats.values, CV_32F, map.unit);
  return floats;
}

std::shared_ptr<const TriangleMesh> OwnMesh(const LightField& light_field) {
  const Subject any{Vector3d::Zero(), 1};  // the mesh does not depend on it
  return ProxyFromName("mesh", any, light_field.root)->Occluder();
}

SoftProxy::Maps OwnMaps(const LightField& light_field, const std::shared_ptr<const TriangleMesh>& mesh) {
  if (!HasDepthMaps(light_field.root)) return {};
  try {
    DepthMapReading reading = ReadDepthMaps(light_field.root, light_field, mesh);
    if (reading.stale > 0)
      spdlog::warn("{} of views that are gone or have other poses now {} not used; make them again with: {}",
                   Counted(reading.stale, "depth map"), reading.stale == 1 ? "is" : "are",
                   ProxyCommand(light_field.root));
    return std::move(reading.maps);
  } catch (const Error& error) {
    spdlog::warn("{}; the mesh alone is used", error.what());
    return {};
  }
}

bool HasPoseOf(const View& view, const LightField& light_field) {
  const View* known = light_field.FindView(view.id);
  return known && known->cam_from_world.Matrix() == view.cam_from_world.Matrix();
}

// Counts what the depth maps of other views say of one place.
struct Votes {
  int agree = 0, see_through = 0;
  float Share() const {
    return agree == 0 ? 0 : static_cast<float>(agree) / static_cast<float>(agree + see_through);
  }
};

// Returns the place's vote: above 0 if the map agrees, below if it sees through it, 0 if it cannot tell.
int VoteOf(const InverseDepths& map, double step, const Vector3d& point_in_other) {
  constexpr double kTolerance = 2;  // steps, one of each of the two maps. Guessed.
  if (!(point_in_other.z() > 0)) return 0;
  const double inverse = 1 / point_in_other.z();
  const float seen = map.At(point_in_other.head<2>() * inverse);
  if (seen <= 0 || seen > inverse + kTolerance * step) return 0;
  return seen < inverse - kTolerance * step ? -1 : 1;
}

// A map of another view that votes.
struct Judge {
  Rigid3 other_from_view;
  InverseDepths map;
  double step = 0;
};

// The nearest other views that have maps.
std::vector<Judge> JudgesOf(const View& view, const LightField& light_field, const SoftProxy::Maps& maps) {
  constexpr std::size_t kJudges = 4;  // Guessed.
  std::vector<std::pair<double, const View*>> others;
  for (const View& other : light_field.views)
    if (other.id != view.id && maps.contains(other.id))
      others.emplace_back((other.CenterInWorld() - view.CenterInWorld()).norm(), &other);
  std::ranges::sort(others, {}, [](const auto& other) { return std::pair(other.first, other.second->id); });
  others.resize(std::min(others.size(), kJudges));
  std::vector<Judge> judges;
  for (const auto& [distance, other] : others) {
    const ViewDepthMap& map = maps.at(other->id)->Get();
    judges.push_back({other->cam_from_world * view.cam_from_world.Inverse(), FloatsOf(map), map.step});
  }
  return judges;
}

}  // namespace

PhotographDepths::PhotographDepths(const LightField& light_field)
    : light_field_(light_field), mesh_(OwnMesh(light_field)), maps_(OwnMaps(light_field, mesh_)) {}

PhotographDepths::PhotographDepths(const LightField& light_field, std::shared_ptr<const TriangleMesh> mesh,
                                   SoftProxy::Maps maps)
    : light_field_(light_field), mesh_(std::move(mesh)), maps_(std::move(maps)) {}

PhotographDepth PhotographDepths::Of(const View& view, const CameraModel& camera) const {
  const CameraModel covering = CoveringPinhole(camera);
  const InverseDepths of_mesh{covering, DrawInverseDepth(*mesh_, covering, view.cam_from_world)};
  const auto found = maps_.find(view.id);
  const bool has_own = found != maps_.end() && HasPoseOf(view, light_field_);
  const InverseDepths own = has_own ? FloatsOf(found->second->Get()) : InverseDepths{};
  const std::vector<Judge> judges = JudgesOf(view, light_field_, maps_);
  const Slopes slopes(camera);
  PhotographDepth pixels{cv::Mat::zeros(camera.height, camera.width, CV_32F), {}};
  if (HasConfidence()) pixels.confidence = cv::Mat::zeros(camera.height, camera.width, CV_32F);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const std::optional<Vector2d> slope = slopes.At(x, y);
      const float drawn = slope ? of_mesh.At(*slope) : 0;
      if (drawn <= 0) continue;
      const float measured = own.values.empty() ? 0 : own.At(*slope);
      const double depth = 1.0 / (measured > 0 ? measured : drawn);
      pixels.depth.at<float>(y, x) = static_cast<float>(depth);
      Votes votes;
      for (const Judge& judge : judges) {
        const int vote =
            VoteOf(judge.map, judge.step, judge.other_from_view * (depth * slope->homogeneous()));
        votes.agree += vote > 0;
        votes.see_through += vote < 0;
      }
      if (HasConfidence()) pixels.confidence.at<float>(y, x) = votes.Share();
    }
  return pixels;
}

double UnitForSixteenBits(const PhotographDepths& depths, const LightField& light_field) {
  constexpr std::size_t kMostViews = 24;
  constexpr int kLongestPx = 96;
  constexpr double kReserve = 1.25;    // for what the small pictures do not show. Guessed.
  constexpr double kLeastSteps = 250;  // of the nearest: half a step is a fifth of a per cent
  constexpr double kMillimetre = 1e-3, kMost = std::numeric_limits<std::uint16_t>::max();
  std::vector<double> known;
  const std::size_t step = (light_field.views.size() + kMostViews - 1) / kMostViews;
  for (std::size_t i = 0; i < light_field.views.size(); i += std::max<std::size_t>(step, 1)) {
    const View& view = light_field.views[i];
    const CameraModel& camera = light_field.CameraOf(view);
    const double share = std::min(1.0, double{kLongestPx} / std::max(camera.width, camera.height));
    const cv::Mat depth = depths
                              .Of(view, camera.ScaledTo(std::max(1, static_cast<int>(share * camera.width)),
                                                        std::max(1, static_cast<int>(share * camera.height))))
                              .depth;
    for (const float value : cv::Mat_<float>(depth))
      if (value > 0) known.push_back(value);
  }
  if (known.empty()) return kMillimetre;
  const double farthest = kReserve * Quantile(known, 0.999), nearest = Quantile(known, 0.01);
  if (farthest <= kMost * kMillimetre && nearest >= kLeastSteps * kMillimetre) return kMillimetre;
  return std::pow(10, std::ceil(std::log10(farthest / kMost)));
}

}  // namespace ulf::render
