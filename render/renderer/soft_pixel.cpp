#include "render/renderer/soft_pixel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/at.h"
#include "core/geometry/pinhole.h"
#include "render/fields/field_options.h"
#include "render/fields/lumigraph_field.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;

// Returns the pixel of a map that shows the point; none outside the map.
std::optional<cv::Point> PixelOf(const ViewDepthMap& map, const Vector3d& in_view) {
  if (!(in_view.z() > 0)) return std::nullopt;
  const double x = std::floor(map.camera.fx * in_view.x() / in_view.z() + map.camera.cx);
  const double y = std::floor(map.camera.fy * in_view.y() / in_view.z() + map.camera.cy);
  if (!(x >= 0 && y >= 0 && x < map.camera.width && y < map.camera.height)) return std::nullopt;
  return cv::Point(static_cast<int>(x), static_cast<int>(y));
}

// Returns the map's inverse depth at the point; none if unknown.
std::optional<double> InverseDepthAt(const ViewDepthMap& map, const Vector3d& in_view) {
  const auto at = PixelOf(map, in_view);
  if (!at) return std::nullopt;
  const double inverse_depth = map.InverseDepthAt(at->x, at->y);
  return inverse_depth > 0 ? std::optional(inverse_depth) : std::nullopt;
}

cv::Vec3d RootOf(const cv::Vec3d& light) {
  return {std::sqrt(std::max(0.0, light[0])), std::sqrt(std::max(0.0, light[1])),
          std::sqrt(std::max(0.0, light[2]))};
}

double SquaredDistance(const cv::Vec3d& a, const cv::Vec3d& b) {
  const cv::Vec3d difference = a - b;
  return difference.dot(difference);
}

}  // namespace

SoftPixel::SoftPixel(const RenderScene& scene, const Rigid3& cam_from_world, double width, LightOf light_of)
    : scene_(scene),
      world_from_cam_(cam_from_world.Inverse()),
      virtual_center_(cam_from_world.OriginInSource()),
      width_(width),
      light_of_(std::move(light_of)) {
  for (const SceneView& view : scene.views) view_from_cam_.push_back(view.cam_from_world * world_from_cam_);
}

SoftPixel::Choice SoftPixel::Choose(const Vector3d& point, std::span<const int> views) const {
  const Vector3d back = (virtual_center_ - point).normalized();
  const Vector3d right = back.unitOrthogonal(), up = right.cross(back);
  Choice choice;
  std::vector<Chosen>& chosen = choice.views;
  for (const int view : views) {
    const SceneView& candidate = scene_.views[At(view)];
    if (!candidate.Project(point)) continue;
    const Vector3d to_view = (candidate.center_in_world - point).normalized();
    chosen.push_back({view,
                      LumigraphPenalty(point, virtual_center_, candidate.center_in_world,
                                       FieldOptions{}.lumigraph_resolution),
                      0,
                      {to_view.dot(right), to_view.dot(up)}});
    if (chosen.size() == kSoftViews) break;
  }
  if (chosen.empty()) return choice;
  std::vector<double> penalties;
  for (const Chosen& one : chosen) penalties.push_back(one.penalty);
  std::ranges::sort(penalties);
  const double fourth =
      std::max(penalties[std::min<std::size_t>(3, penalties.size() - 1)], kLumigraphZeroPenalty);
  const double width = choice.width = width_ * fourth;
  const auto gaussian = [&](double penalty) { return std::exp(-0.5 * penalty * penalty / (width * width)); };
  // The farthest of many views fades to zero, since at the next pixel it may not be among them. If all are
  // alike they have equal weights.
  const double nothing = std::min(
      std::max(constants_.least_weight, chosen.size() == kSoftViews ? gaussian(penalties.back()) : 0),
      constants_.most_taken * gaussian(penalties.front()));
  for (Chosen& one : chosen) {
    const double own = constants_.own_share * fourth / std::max(one.penalty, kLumigraphZeroPenalty);
    one.weight = std::max(0.0, gaussian(one.penalty) - nothing) * (1 + own * own);
  }
  std::erase_if(chosen, [](const Chosen& one) { return !(one.weight > 0); });
  // The order is by penalty, which differs from pixel to pixel: by distance a view would begin or cease to
  // propose in the whole picture at once, visibly.
  std::ranges::stable_sort(chosen, {}, &Chosen::penalty);
  return choice;
}

std::vector<double> SoftPixel::Candidates(const Vector3d& ray, double inverse_depth,
                                          const std::vector<Chosen>& chosen) const {
  std::vector<double> found{inverse_depth};
  for (std::size_t n = 0; n < chosen.size() && n < kSoftProposers; ++n) {
    const SceneView& view = scene_.views[At(chosen[n].view)];
    if (!view.depth_map) continue;
    const ViewDepthMap& map = view.depth_map->Get();
    const Rigid3& view_from_cam = view_from_cam_[At(chosen[n].view)];
    double at = inverse_depth;
    bool settled = false;
    for (int step = 0; step < constants_.search_steps; ++step) {
      settled = false;
      const Vector3d in_view = view_from_cam * (ray / at);
      if (!(in_view.z() > 0)) break;
      const auto pixel = PixelOf(map, in_view);
      const double map_depth = pixel ? map.InverseDepthAt(pixel->x, pixel->y) : 0;
      if (!(map_depth > 0)) break;
      const double depth =
          (view_from_cam.Inverse() * (PinholeRay(map.camera, pixel->x, pixel->y) / map_depth)).z();
      if (!(depth > 0)) break;
      settled = std::abs(1 / depth - at) < constants_.search_end * map.step;
      at = 1 / depth;
    }
    if (settled) found.push_back(at);
  }
  if (found.size() == 1) return found;
  std::ranges::sort(found, std::greater());               // from near to far
  double step = std::numeric_limits<double>::infinity();  // of the finest map
  for (std::size_t n = 0; n < chosen.size() && n < kSoftProposers; ++n)
    step = std::min(step, scene_.views[At(chosen[n].view)].depth_map->Get().step);
  std::vector<double> candidates;
  for (const double one : found)
    if (candidates.empty() || candidates.back() - one > constants_.merged * step) candidates.push_back(one);
  return candidates;
}

// Computes weights of a local linear regression at the virtual camera's direction, with a ridge.
void SoftPixel::Balance(std::vector<Sample>& samples, double width) const {
  double sum = 0;
  Eigen::Vector2d aside = Eigen::Vector2d::Zero();
  Eigen::Matrix2d products = Eigen::Matrix2d::Zero();
  for (const Sample& s : samples) {
    sum += s.weight;
    aside += s.weight * s.aside;
    products += s.weight * s.aside * s.aside.transpose();
  }
  aside /= sum;
  const Eigen::Matrix2d covariance = products / sum - aside * aside.transpose();
  const Eigen::Vector2d slope =
      (covariance + constants_.balanced * width * width * Eigen::Matrix2d::Identity()).inverse() * aside;
  for (Sample& s : samples) s.weight *= std::max(0.0, 1 - slope.dot(s.aside - aside));
}

double SoftPixel::Blend(const Vector3d& ray, double inverse_depth, const Choice& chosen,
                        std::vector<Sample>& samples, double& belief) const {
  const Vector3d point_in_world = world_from_cam_ * (ray / inverse_depth);
  double votes = 0, voters = 0;
  samples.clear();
  for (const auto& [index, penalty, weight, aside] : chosen.views) {
    const SceneView& view = scene_.views[At(index)];
    const auto framed = view.Project(point_in_world);
    if (!framed) continue;
    double seen = 1;
    if (view.depth_map) {
      const ViewDepthMap& map = view.depth_map->Get();
      const Vector3d in_view = view_from_cam_[At(index)] * (ray / inverse_depth);
      if (const auto surface = InverseDepthAt(map, in_view)) {
        const double before = (1 / in_view.z() - *surface) / map.step;  // the surface, in steps
        votes += weight * std::exp(-0.5 * before * before / (constants_.vote * constants_.vote));
        if (before > -constants_.occluded) voters += weight;
        seen = std::clamp((before + constants_.occluded) / (constants_.occluded - constants_.vote),
                          constants_.least_seen, 1.0);
      }
    } else if (view.shadow_map) {
      seen = std::max(constants_.least_seen,
                      view.shadow_map->Get().Visibility(view.cam_from_world * point_in_world));
    }
    const cv::Vec4f light = light_of_(index, framed->img);
    const double lit = weight * seen * framed->feather * light[3];
    if (!(lit > 0)) continue;
    const cv::Vec3d bgr(light[0], light[1], light[2]);
    samples.push_back({index, lit, seen, framed->feather * light[3], aside, bgr, RootOf(bgr)});
  }
  belief = voters > 0 ? votes / voters : 0;
  double most_seen = 0, lit = 0, sum = 0;
  cv::Vec3d mean_root(0, 0, 0), mean_square(0, 0, 0);
  for (const Sample& s : samples) {
    most_seen = std::max(most_seen, s.seen);
    lit += s.weight;
    sum += s.weight / s.feather;
    mean_root += s.weight * s.root;
    mean_square += s.weight * s.root.mul(s.root);
  }
  if (samples.empty()) return 0;
  mean_root /= lit;
  mean_square /= lit;
  double variance = 0;
  for (int c = 0; c < 3; ++c) variance += std::max(0.0, mean_square[c] - mean_root[c] * mean_root[c]);
  if (samples.size() > 1) belief *= std::exp(-0.5 * variance / (constants_.agreeing * constants_.agreeing));
  Balance(samples, chosen.width);
  double balanced = 0;
  cv::Vec3d mean(0, 0, 0);
  for (const Sample& s : samples) {
    balanced += s.weight;
    mean += s.weight * s.light;
  }
  mean /= balanced;
  // The samples keep the weights of the last step.
  const double squared = constants_.robust * constants_.robust;
  std::vector<double> robust(samples.size());
  for (int step = 0; step < constants_.robust_steps; ++step) {
    const cv::Vec3d root = RootOf(mean);
    cv::Vec3d light(0, 0, 0);
    double total = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      robust[i] = samples[i].weight / (1 + SquaredDistance(samples[i].root, root) / squared);
      light += robust[i] * samples[i].light;
      total += robust[i];
    }
    mean = light / total;
  }
  double total = 0;
  for (const double weight : robust) total += weight;
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].weight = robust[i] / total;
  return most_seen * lit / sum;
}

double SoftPixel::Blend(const Vector3d& ray, double depth, std::span<const int> views,
                        std::vector<Contribution>& contributions) const {
  contributions.clear();
  const Choice chosen = Choose(world_from_cam_ * (ray * depth), views);
  if (chosen.views.empty()) return 0;
  const std::vector<double> candidates = Candidates(ray, 1 / depth, chosen.views);
  // Remaining belief for farther candidates; a candidate without belief still shows if all are such.
  constexpr double kOpaque = 0.001, kLeastBelief = 1e-6;
  double left = 1, sum = 0, seen = 0;
  std::vector<Sample> samples;
  for (const double candidate : candidates) {
    double belief = 0;
    const double lit = Blend(ray, candidate, chosen, samples, belief);
    if (samples.empty()) continue;
    if (candidates.size() == 1) belief = 1;
    const double share = std::min(left, belief) + kLeastBelief;
    for (const Sample& s : samples)
      contributions.push_back(
          {s.view,
           share * s.weight,
           {static_cast<float>(s.light[0]), static_cast<float>(s.light[1]), static_cast<float>(s.light[2])}});
    sum += share;
    seen += share * lit;
    left -= std::min(left, belief);
    if (left < kOpaque) break;
  }
  if (!(sum > 0)) return 0;
  const double total = seen / sum;
  for (Contribution& c : contributions) c.weight *= total / sum;
  return total;
}

ViewTiles SoftViewsOfTiles(ViewTiler& tiler, const RenderScene& scene, const CameraModel& camera,
                           const Rigid3& cam_from_world) {
  return tiler.Tile(
      scene.views, ViewsByDistance(scene, cam_from_world.OriginInSource()),
      {camera, cam_from_world, scene.proxy->Background(cam_from_world),
       scene.proxy->Triangles(camera, cam_from_world)},
      [](int) { return true; }, kSoftViews);
}

}  // namespace ulf::render
