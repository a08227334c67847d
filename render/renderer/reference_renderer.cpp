#include "render/renderer/reference_renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <span>

#include "core/base/at.h"
#include "core/base/available_memory.h"
#include "core/base/error.h"
#include "core/geometry/angles.h"
#include "core/geometry/pinhole.h"
#include "render/fields/image_triangulation.h"
#include "render/fields/lumigraph_field.h"
#include "render/fields/make_field.h"
#include "render/renderer/soft_pixel.h"
#include "render/scene/even_picture.h"

namespace ulf::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

cv::Vec4f LinearAt(const cv::Mat& pixels, int x, int y) {
  x = std::clamp(x, 0, pixels.cols - 1);
  y = std::clamp(y, 0, pixels.rows - 1);
  if (pixels.depth() == CV_16F) {
    const auto& p = pixels.at<cv::Vec<cv::float16_t, 4>>(y, x);
    return {p[0], p[1], p[2], p[3]};
  }
  const auto& table = LinearFromSrgb8();
  const cv::Vec3b& p = pixels.at<cv::Vec3b>(y, x);
  return {table[p[0]], table[p[1]], table[p[2]], 1};
}

// The data that all pixels of a picture share.
struct FrameSetup {
  const RenderScene& scene;
  const CameraModel& camera;
  Rigid3 world_from_cam;
  Vector3d virtual_center;
  bool show_field;
  std::vector<int> level;  // by view
  std::vector<int> views_by_distance;
};

// Returns light on the common scale of all views, and the share of it that the photograph has there.
cv::Vec4f LightOf(const FrameSetup& setup, int index, const Vector2d& img) {
  const SceneView& view = setup.scene.views[At(index)];
  if (setup.show_field) {
    const cv::Vec3f color = ViewColor(view.id);
    return {color[0], color[1], color[2], 1};
  }
  // Requested at every pixel: the store decides which levels stay in memory.
  return LightOfView(view, view.photograph->Level(setup.level[At(index)]), img);
}

// Adds a view's contribution, if its photograph has light there.
void Contribute(const FrameSetup& setup, int view, const Vector2d& img, double weight,
                std::vector<Contribution>& contributions) {
  const cv::Vec4f light = LightOf(setup, view, img);
  if (weight * light[3] > 0)
    contributions.push_back({view, weight * light[3], {light[0], light[1], light[2]}});
}

double BlendViews(const FrameSetup& setup, const FieldSample& sample, const Vector3d& point,
                  std::vector<Contribution>& contributions) {
  double total = 0;
  for (const auto& [index, weight] : sample.weights)
    if (const auto seen = setup.scene.views[At(index)].ProjectVisible(point))
      Contribute(setup, index, seen->img, weight * seen->feather, contributions);
  for (const Contribution& c : contributions) total += c.weight;
  return total;
}

// Returns the `count` nearest views that see the point and have light there.
std::vector<int> NearestThatSee(const FrameSetup& setup, const Vector3d& point, int count) {
  std::vector<int> views;
  for (const int index : setup.views_by_distance) {
    const auto seen = setup.scene.views[At(index)].ProjectVisible(point);
    if (!seen || !(LightOf(setup, index, seen->img)[3] > 0)) continue;
    views.push_back(index);
    if (static_cast<int>(views.size()) == count) break;
  }
  return views;
}

// Uses the nearest view that has the point in its image, even though the proxy hides the point from it.
void FillFromHidden(const FrameSetup& setup, const Vector3d& point,
                    std::vector<Contribution>& contributions) {
  for (const int index : setup.views_by_distance) {
    if (const auto framed = setup.scene.views[At(index)].Project(point))
      Contribute(setup, index, framed->img, 1, contributions);
    if (!contributions.empty()) return;
  }
}

// With `count` 1 it uses the first view that has light, otherwise lumigraph weights.
void Fill(const FrameSetup& setup, const Vector3d& point, int count,
          std::vector<Contribution>& contributions) {
  const std::vector<int> views = NearestThatSee(setup, point, count > 1 ? count + 1 : 1);
  if (views.empty()) return FillFromHidden(setup, point, contributions);
  std::vector<ViewWeight> weights;
  for (const int index : views)
    weights.push_back({index, count > 1 ? LumigraphPenalty(point, setup.virtual_center,
                                                           setup.scene.views[At(index)].center_in_world,
                                                           FieldOptions{}.lumigraph_resolution)
                                        : 1});
  if (count > 1) weights = LumigraphWeights(std::move(weights), At(count));
  for (const auto& [index, weight] : weights) {
    const auto seen = setup.scene.views[At(index)].ProjectVisible(point);
    if (seen) Contribute(setup, index, seen->img, weight * seen->feather, contributions);
    if (count == 1 && !contributions.empty()) return;
  }
}

// Scales the weights so that they sum to `sum`.
void Scale(std::span<Contribution> contributions, double sum) {
  double total = 0;
  for (const Contribution& c : contributions) total += c.weight;
  for (Contribution& c : contributions) c.weight *= sum / total;
}

// Returns the cone around a tile's rays.
std::pair<Vector3d, double> ConeOf(const CameraModel& camera, const cv::Rect& tile) {
  const Vector3d axis =
      PinholeRay(camera, Vector2d(tile.x + 0.5 * tile.width, tile.y + 0.5 * tile.height)).normalized();
  double half_angle = 0;
  for (const int x : {tile.x, tile.x + tile.width})
    for (const int y : {tile.y, tile.y + tile.height})
      half_angle = std::max(half_angle, AngleBetween(axis, PinholeRay(camera, Vector2d(x, y))));
  return {axis, half_angle};
}

}  // namespace

cv::Vec4f SampleLevel(const cv::Mat& pixels, const CameraModel& camera, const Vector2d& img) {
  const double x = img.x() * pixels.cols / camera.width - 0.5;
  const double y = img.y() * pixels.rows / camera.height - 0.5;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  const float right_share = static_cast<float>(x - left), below_share = static_cast<float>(y - top);
  const cv::Vec4f above =
      LinearAt(pixels, left, top) * (1 - right_share) + LinearAt(pixels, left + 1, top) * right_share;
  const cv::Vec4f below =
      LinearAt(pixels, left, top + 1) * (1 - right_share) + LinearAt(pixels, left + 1, top + 1) * right_share;
  const cv::Vec4f light = above * (1 - below_share) + below * below_share;
  if (!(light[3] > 0)) return {0, 0, 0, 0};
  return {light[0] / light[3], light[1] / light[3], light[2] / light[3], light[3]};
}

cv::Vec4f LightOfView(const SceneView& view, const cv::Mat& level, const Eigen::Vector2d& img) {
  const cv::Vec4f light = SampleLevel(level, view.camera, img);
  const cv::Vec3f even = OnCommonScale(view, {light[0], light[1], light[2]}, img);
  return {even[0], even[1], even[2], light[3]};
}

ReferenceRenderer::ReferenceRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options)
    : scene_(std::move(scene)), options_(options) {
  SetField(options.field);
}

void ReferenceRenderer::SetField(const FieldOptions& field) {
  options_.field = FieldThatServes(field, scene_->mesh);
  SetAperture(options_.aperture);
}

void ReferenceRenderer::SetProxy(std::shared_ptr<const Proxy> proxy) {
  scene_ = WithProxy(*scene_, std::move(proxy));
  SetAperture(options_.aperture);
}

void ReferenceRenderer::SetAperture(const std::optional<Aperture>& aperture) {
  options_.aperture = aperture;
  focused_ = aperture ? WithFocalPlane(*scene_, *aperture) : nullptr;
  field_ = options_.field.kind == FieldKind::kSoft ? nullptr
                                                   : MakeField(focused_ ? focused_ : scene_, options_.field);
  aperture_field_ = nullptr;
  if (aperture && UsesMesh(options_.field.kind))
    aperture_field_ = std::make_unique<ApertureField>(
        std::make_shared<MeshField>(scene_, options_.field.level, options_.field.rules));
}

std::unique_ptr<PlacedField> ReferenceRenderer::FieldFrom(const CameraModel& camera,
                                                          const Rigid3& cam_from_world,
                                                          const cv::Mat& depth) const {
  if (options_.field.kind == FieldKind::kSoft) return nullptr;
  if (aperture_field_) return aperture_field_->From(cam_from_world, *options_.aperture);
  if (options_.field.kind != FieldKind::kLumigraph) return field_->From(cam_from_world.OriginInSource());
  const RenderScene& scene = focused_ ? *focused_ : *scene_;
  const bool has_triangles = scene.proxy->Triangles(camera, cam_from_world) != nullptr;
  return LumigraphAtVertices(
      scene, camera, cam_from_world,
      DepthFromPicture(has_triangles ? depth : cv::Mat(), scene.proxy->Background(cam_from_world), camera),
      options_.field);
}

namespace {

FrameSetup SetUp(const RenderScene& scene, const CameraModel& camera, const Rigid3& cam_from_world,
                 bool show_field) {
  FrameSetup setup{scene, camera, cam_from_world.Inverse(), cam_from_world.OriginInSource(), show_field,
                   {},    {}};
  for (const SceneView& view : scene.views)
    setup.level.push_back(PyramidLevel(view, scene, setup.virtual_center, camera.MeanFocalPx()));
  setup.views_by_distance = ViewsByDistance(scene, setup.virtual_center);
  return setup;
}

// Sets the contributions of a pixel's own views; returns the weight of those that see its point.
using OwnViews =
    std::function<double(const Vector3d& ray_in_cam, const Vector3d& point_in_world, double depth,
                         std::vector<Contribution>& contributions, double& confidence)>;

// Calls shade(x, y, contributions, total, confidence) for every pixel of a tile. The contributions' weights
// sum to one, if there are any; `total` is the weight of those of the field's own views that see the point.
template <typename Shade>
void ForEachPixelOf(const cv::Rect& tile, const FrameSetup& setup, const cv::Mat& depth,
                    const Filling& filling, const OwnViews& own_views, const Shade& shade) {
  std::vector<Contribution> contributions, others;
  for (int y = tile.y; y < tile.br().y; ++y)
    for (int x = tile.x; x < tile.br().x; ++x) {
      const Vector3d ray_in_cam = PinholeRay(setup.camera, x, y);
      const double pixel_depth = depth.at<float>(y, x);
      const Vector3d point = setup.world_from_cam * (ray_in_cam * pixel_depth);
      contributions.clear();
      double confidence = 0;
      double total = own_views(ray_in_cam, point, pixel_depth, contributions, confidence);
      if (total < kLeastWeight) {
        total = 0;
        contributions.clear();
      }
      const double own = std::min(1.0, total / filling.whole);
      others.clear();
      if (filling.views > 0 && own < 1) Fill(setup, point, filling.views, others);
      Scale(contributions, others.empty() ? 1 : own);
      Scale(others, contributions.empty() ? 1 : 1 - own);
      contributions.insert(contributions.end(), others.begin(), others.end());
      shade(x, y, contributions, total, confidence);
    }
}

template <typename Shade>
void ForEachPixelOfField(const FrameSetup& setup, const PlacedField& field, const cv::Mat& depth,
                         const Filling& filling, const Shade& shade) {
  const CameraModel& camera = setup.camera;
  constexpr int kTile = 16;  // px; the rays of a tile share the field's candidates
  FieldSample sample;
  for (int top = 0; top < camera.height; top += kTile)
    for (int left = 0; left < camera.width; left += kTile) {
      const cv::Rect tile(left, top, std::min(kTile, camera.width - left),
                          std::min(kTile, camera.height - top));
      const auto [axis_in_cam, half_angle] = ConeOf(camera, tile);
      const auto candidates = field.CandidatesInCone(setup.world_from_cam.rotation * axis_in_cam, half_angle);
      const auto own_views = [&](const Vector3d& ray_in_cam, const Vector3d& point, double /*depth*/,
                                 std::vector<Contribution>& contributions, double& confidence) {
        const Vector3d ray_in_world = setup.world_from_cam.rotation * ray_in_cam.normalized();
        field.Weights({ray_in_world, point, candidates.empty() ? nullptr : &candidates}, sample);
        confidence = sample.confidence;
        return BlendViews(setup, sample, point, contributions);
      };
      ForEachPixelOf(tile, setup, depth, filling, own_views, shade);
    }
}

// The soft field iterates over views, not over weights of a point.
template <typename Shade>
void ForEachSoftPixel(const FrameSetup& setup, const Rigid3& cam_from_world, const cv::Mat& depth,
                      const Filling& filling, double soft_width, const Shade& shade) {
  ViewTiler tiler(setup.scene.views);
  const ViewTiles views = SoftViewsOfTiles(tiler, setup.scene, setup.camera, cam_from_world);
  const SoftPixel soft(setup.scene, cam_from_world, soft_width,
                       [&](int view, const Vector2d& img) { return LightOf(setup, view, img); });
  for (const ViewTiles::Tile& tile : views.tiles) {
    const std::span<const int> of_tile =
        std::span(views.views)
            .subspan(static_cast<std::size_t>(tile.first), static_cast<std::size_t>(tile.end - tile.first));
    const auto own_views = [&](const Vector3d& ray_in_cam, const Vector3d& /*point*/, double pixel_depth,
                               std::vector<Contribution>& contributions, double& confidence) {
      confidence = 1;
      return soft.Blend(ray_in_cam, pixel_depth, of_tile, contributions);
    };
    ForEachPixelOf(tile.px, setup, depth, filling, own_views, shade);
  }
}

// A null `field` means the soft field.
template <typename Shade>
void ForEachPixel(const FrameSetup& setup, const PlacedField* field, const Rigid3& cam_from_world,
                  const cv::Mat& depth, const Filling& filling, double soft_width, const Shade& shade) {
  if (field)
    ForEachPixelOfField(setup, *field, depth, filling, shade);
  else
    ForEachSoftPixel(setup, cam_from_world, depth, filling, soft_width, shade);
}

// A layer of weights for each view that gives light to any pixel.
class WeightLayers {
 public:
  WeightLayers(const RenderScene& scene, const cv::Size& size)
      : scene_(scene), size_(size), layers_(scene.views.size()) {}
  void Add(int x, int y, const std::vector<Contribution>& contributions) {
    for (const Contribution& c : contributions) {
      cv::Mat& layer = layers_[At(c.view)];
      if (layer.empty()) layer = NewLayer();
      cv::float16_t& at = layer.at<cv::float16_t>(y, x);
      at = cv::float16_t(static_cast<float>(at) + static_cast<float>(c.weight));
    }
  }
  cv::Mat NewLayer() {
    // Encoding needs the same amount again.
    if (AvailableMemory() < 2 * sizeof(cv::float16_t) * static_cast<std::uint64_t>(size_.area()))
      throw Error(
          "the weights of single views in a picture of {}x{} do not fit into memory; render it smaller, or "
          "without weights",
          size_.width, size_.height);
    return cv::Mat::zeros(size_, CV_16F);
  }
  std::vector<ViewWeights> Take() {
    std::vector<ViewWeights> weights;
    for (std::size_t i = 0; i < layers_.size(); ++i)
      if (!layers_[i].empty()) weights.push_back({scene_.views[i].id, layers_[i]});
    return weights;
  }

 private:
  const RenderScene& scene_;
  cv::Size size_;
  std::vector<cv::Mat> layers_;
};

}  // namespace

std::vector<ViewWeights> WeightsOfViews(const RenderScene& scene, const PlacedField* field,
                                        const CameraModel& camera, const Rigid3& cam_from_world,
                                        const cv::Mat& depth, const RenderOptions& options) {
  WeightLayers layers(scene, depth.size());
  ForEachPixel(SetUp(scene, camera, cam_from_world, false), field, cam_from_world, depth, FillingOf(options),
               options.field.soft_width,
               [&](int x, int y, const std::vector<Contribution>& contributions, double /*total*/,
                   double /*confidence*/) { layers.Add(x, y, contributions); });
  return layers.Take();
}

Rendering ReferenceRenderer::Render(const CameraModel& camera, const Rigid3& cam_from_world) {
  RequireUndistorted(camera);
  const auto start = std::chrono::steady_clock::now();
  const RenderScene& scene = focused_ ? *focused_ : *scene_;
  const cv::Mat depth = scene.proxy->Depth(camera, cam_from_world);
  Rendering picture;
  picture.linear = cv::Mat::zeros(camera.height, camera.width, CV_32FC3);
  picture.confidence = cv::Mat::zeros(camera.height, camera.width, CV_32F);
  picture.drawn = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  WeightLayers layers(scene, depth.size());
  ForEachPixel(
      SetUp(scene, camera, cam_from_world, options_.show_field),
      FieldFrom(camera, cam_from_world, depth).get(), cam_from_world, depth, FillingOf(options_),
      options_.field.soft_width,
      [&](int x, int y, const std::vector<Contribution>& contributions, double total, double confidence) {
        if (total == 0) ++(contributions.empty() ? picture.empty_px : picture.filled_px);
        if (contributions.empty()) return;
        cv::Vec3f light(0, 0, 0);
        for (const Contribution& c : contributions) light += static_cast<float>(c.weight) * c.light;
        picture.linear.at<cv::Vec3f>(y, x) = light;
        picture.confidence.at<float>(y, x) = static_cast<float>(confidence * std::min(1.0, total));
        picture.drawn.at<std::uint8_t>(y, x) = 255;
        if (options_.weights) layers.Add(x, y, contributions);
      });
  if (options_.weights) picture.weights = layers.Take();
  if (options_.depth) picture.depth = depth;
  picture.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return picture;
}

}  // namespace ulf::render
