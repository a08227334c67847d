#include "render/fields/image_triangulation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/at.h"
#include "core/geometry/pinhole.h"
#include "render/fields/ray_cone.h"
#include "render/viewpoints/delaunay.h"

namespace ulf::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Returns the viewpoints inside the image, and a grid over the image with a margin of one pixel whose number
// of points gives about as many triangles as wanted.
std::vector<Vector2d> Points(const RenderScene& scene, const CameraModel& camera,
                             const Rigid3& cam_from_world, int triangles_wanted) {
  std::vector<Vector2d> viewpoints;
  for (const SceneView& view : scene.views) {
    const auto img = camera.ImgFromCam(cam_from_world * view.center_in_world);
    if (img && camera.Contains(*img)) viewpoints.push_back(*img);
  }
  constexpr double kLeastGridPoints = 100;  // a limit for very many viewpoints; guessed
  const double grid_points =
      std::max(kLeastGridPoints, 0.5 * triangles_wanted - static_cast<double>(viewpoints.size()));
  const double step = std::sqrt(static_cast<double>(camera.width) * camera.height / grid_points);
  const int columns = std::max(2, static_cast<int>(std::lround(camera.width / step)) + 1);
  const int rows = std::max(2, static_cast<int>(std::lround(camera.height / step)) + 1);
  std::vector<Vector2d> points;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      points.emplace_back(-1 + (camera.width + 2.0) * x / (columns - 1),
                          -1 + (camera.height + 2.0) * y / (rows - 1));
  points.insert(points.end(), viewpoints.begin(), viewpoints.end());
  return points;
}

// Computes the weights at one point: a cheap ranking of all views first, then the exact penalty and the
// visibility of the best ones only.
class WeightsAtPoint {
 public:
  WeightsAtPoint(const RenderScene& scene, const Vector3d& virtual_center, const FieldOptions& options)
      : scene_(scene),
        virtual_center_(virtual_center),
        k_(static_cast<std::size_t>(options.lumigraph_k)),
        resolution_(options.lumigraph_resolution) {
    const Eigen::Index count = static_cast<Eigen::Index>(scene.views.size());
    centers_.resize(3, count);
    for (Eigen::Index i = 0; i < count; ++i)
      centers_.col(i) =
          (scene.views[static_cast<std::size_t>(i)].center_in_world - virtual_center).cast<float>();
  }

  std::vector<ViewWeight> At(const Vector3d& point) {
    const Eigen::Vector3f p = (point - virtual_center_).cast<float>();
    const float distance = p.norm();
    const auto to_view = (centers_.colwise() - p).eval();
    const Eigen::ArrayXf lengths = to_view.colwise().norm().transpose().array();
    const Eigen::ArrayXf cosines = (to_view.transpose() * (-p / distance)).array() / lengths;
    // The chord approximates the angle.
    rough_ = (2 * (1 - cosines)).max(0.0f).sqrt() +
             static_cast<float>(resolution_) * (lengths / distance - 1).max(0.0f);
    order_.resize(scene_.views.size());
    std::iota(order_.begin(), order_.end(), 0);

    std::vector<ViewWeight> best;
    const std::size_t wanted = 2 * k_ + 8;  // ranked at once: usually k + 1 of these see the point
    for (std::size_t looked_at = 0; looked_at < order_.size() && best.size() < k_ + 1;) {
      const std::size_t end = std::min(order_.size(), looked_at + wanted);
      std::partial_sort(order_.begin() + static_cast<std::ptrdiff_t>(looked_at),
                        order_.begin() + static_cast<std::ptrdiff_t>(end), order_.end(),
                        [&](int a, int b) { return rough_(a) < rough_(b); });
      for (; looked_at < end; ++looked_at) {
        const SceneView& view = scene_.views[static_cast<std::size_t>(order_[looked_at])];
        if (view.ProjectVisible(point))
          best.push_back({order_[looked_at],
                          LumigraphPenalty(point, virtual_center_, view.center_in_world, resolution_)});
      }
    }
    return LumigraphWeights(std::move(best), k_);
  }

 private:
  const RenderScene& scene_;
  Vector3d virtual_center_;
  std::size_t k_;
  double resolution_;
  Eigen::Matrix3Xf centers_;
  Eigen::ArrayXf rough_;
  std::vector<int> order_;
};

class FieldOfTriangulation : public PlacedField {
 public:
  FieldOfTriangulation(WeightedImageTriangulation image, const CameraModel& camera,
                       const Rigid3& cam_from_world)
      : image_(std::move(image)) {
    const Eigen::Matrix3d cam_from_world_r = cam_from_world.RotationMatrix();
    for (const Triangle& t : image_.triangles) {
      Eigen::Matrix3d corners;
      for (int k = 0; k < 3; ++k) corners.col(k) = PinholeRay(camera, image_.img[At(t[At(k)])]);
      cone_from_ray_.push_back(ConeFromRay(corners) * cam_from_world_r);
    }
  }

  std::vector<int> CandidatesInCone(const Vector3d& axis, double half_angle) const override {
    return ConesThatMayMeet(cone_from_ray_, axis, half_angle);
  }

  void Weights(const RayQuery& query, FieldSample& sample) const override {
    sample = {};
    const std::size_t count = query.candidates ? query.candidates->size() : cone_from_ray_.size();
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t t = query.candidates ? At((*query.candidates)[i]) : i;
      const auto barycentric = Barycentric(cone_from_ray_[t], query.ray_in_world);
      if (!barycentric) continue;
      for (int k = 0; k < 3; ++k)
        for (const auto& [view, weight] : image_.weights[At(image_.triangles[t][At(k)])])
          sample.Add(view, (*barycentric)(k)*weight);
      sample.confidence = 1;
      return;
    }
  }

 private:
  WeightedImageTriangulation image_;
  std::vector<Eigen::Matrix3d> cone_from_ray_;  // in world axes
};

}  // namespace

DepthAt DepthFromPicture(const cv::Mat& drawn, const PlaneInCamera& plane, const CameraModel& camera) {
  return [=](const Vector2d& img) -> double {
    if (!drawn.empty()) {
      const float depth = drawn.at<float>(std::clamp(static_cast<int>(img.y()), 0, drawn.rows - 1),
                                          std::clamp(static_cast<int>(img.x()), 0, drawn.cols - 1));
      if (depth > 0) return depth;
    }
    return plane.DepthOf(PinholeRay(camera, img));
  };
}

std::unique_ptr<PlacedField> LumigraphAtVertices(const RenderScene& scene, const CameraModel& camera,
                                                 const Rigid3& cam_from_world, const DepthAt& depth_at,
                                                 const FieldOptions& options) {
  return std::make_unique<FieldOfTriangulation>(
      TriangulateLumigraph(scene, camera, cam_from_world, depth_at, options), camera, cam_from_world);
}

WeightedImageTriangulation TriangulateLumigraph(const RenderScene& scene, const CameraModel& camera,
                                                const Rigid3& cam_from_world, const DepthAt& depth_at,
                                                const FieldOptions& options) {
  WeightedImageTriangulation result;
  result.img = Points(scene, camera, cam_from_world, options.lumigraph_triangles);
  result.triangles = PlanarDelaunay(result.img);
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  WeightsAtPoint weights_at(scene, cam_from_world.OriginInSource(), options);
  for (const Vector2d& img : result.img)
    result.weights.push_back(weights_at.At(world_from_cam * (PinholeRay(camera, img) * depth_at(img))));
  return result;
}

}  // namespace ulf::render
