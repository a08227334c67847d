#include "render/splats/placing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "render/splats/far_sphere.h"
#include "render/splats/splat_shape.h"

namespace ulf::render {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// Steps of two maps together within which they say the same; else one sees through the other. Settled on
// Herz-Jesus-P8, fountain-P11 and temple_ring.
constexpr float kAgreeing = 0.5f;
constexpr float kLeastFacing = 0.1f;  // cosine of the angle under which a view sees a surface
constexpr float kFlatCell = 1;        // steps by which the surface may leave a cell's plane at its corners
constexpr float kFinerBy = 1.5f;      // a view that shows the cell this much larger gets Gaussians of its own
constexpr float kLeastCosine = 0.2f;  // of the angle between a ray and the surface's normal
constexpr int kRoughness = 4;         // levels of 255 by which a photograph may differ within a cell
constexpr double kAroundShare = 0.15;  // of all Gaussians, at most

// A view with what projections into it need, in single precision.
struct FastView {
  SplatView* view;
  Eigen::Matrix3f rotation;
  Vector3f translation, center;
  float fx, fy, cx, cy;

  explicit FastView(SplatView& of)
      : view(&of),
        rotation(of.cam_from_world.RotationMatrix().cast<float>()),
        translation(of.cam_from_world.translation.cast<float>()),
        center(of.cam_from_world.OriginInSource().cast<float>()),
        fx(static_cast<float>(of.camera.fx)),
        fy(static_cast<float>(of.camera.fy)),
        cx(static_cast<float>(of.camera.cx)),
        cy(static_cast<float>(of.camera.cy)) {}
  Vector3f RayAt(float x, float y) const { return {(x - cx) / fx, (y - cy) / fy, 1}; }
  Vector3f InCam(const Vector3f& point_in_world) const { return rotation * point_in_world + translation; }
  Vector3f InWorld(const Vector3f& in_cam) const { return rotation.transpose() * (in_cam - translation); }
};

// A cell, the uncertainty of 1 / depth in its view, times the squared depth, and the cell's size there.
struct SurfacePatch : SurfaceCell {
  float tolerance = 0, here_px = 0;
};

// In the order in which they are placed. The rest is for pixels that the layer before it left out, because no
// other map says the same there: it lies on the mesh.
enum class Layer { kDetail, kRestOfDetail, kGround, kRestOfGround };
constexpr std::array<Layer, 4> kLayers{Layer::kDetail, Layer::kRestOfDetail, Layer::kGround,
                                       Layer::kRestOfGround};
constexpr int kGroundLevel = 2;  // cells of 4 x 4 pixels; larger ones where the photograph is smooth
// The ground lies behind the surface by this share of its cell's size, so that it comes after the details.
constexpr float kBehind = 0.75f;

enum class Vote { kNone, kAgrees, kSeesThrough };

struct PatchReading {
  Vote vote = Vote::kNone;
  Vector3f in_cam;
  float change = 0;  // of the inverse depth there to the map's
};

PatchReading ReadPatch(const FastView& other, const SurfaceMap& surface, const SurfacePatch& patch,
                       bool gaps_are_empty) {
  PatchReading reading{Vote::kNone, other.InCam(patch.point), 0};
  const float depth = reading.in_cam.z();
  if (!(depth > 0)) return reading;
  const float slope_x = reading.in_cam.x() / depth, slope_y = reading.in_cam.y() / depth;
  const float x = other.fx * slope_x + other.cx, y = other.fy * slope_y + other.cy;
  const SplatView& view = *other.view;
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(view.camera.width) &&
        y < static_cast<float>(view.camera.height)))
    return reading;
  if (view.IsGap(static_cast<int>(x), static_cast<int>(y))) {
    if (gaps_are_empty) reading.vote = Vote::kSeesThrough;
    return reading;
  }
  const auto plane = surface.At(slope_x, slope_y);
  if (!plane) return reading;
  reading.change = plane->inverse_depth - 1 / depth;
  const float tolerance = kAgreeing * (surface.step() + patch.tolerance / (depth * depth));
  const bool faces = patch.normal.dot((other.center - patch.point).normalized()) > kLeastFacing;
  if (reading.change < -tolerance)
    reading.vote = Vote::kSeesThrough;
  else if (faces && reading.change <= tolerance)
    reading.vote = Vote::kAgrees;
  return reading;
}

// Returns the change of the image point by a span at a point.
Vector2f SpanInImage(const FastView& view, const Vector3f& in_cam, const Vector3f& span_in_world) {
  const Vector3f span = view.rotation * span_in_world;
  const float per_depth = 1 / in_cam.z();
  return {view.fx * per_depth * (span.x() - in_cam.x() * per_depth * span.z()),
          view.fy * per_depth * (span.y() - in_cam.y() * per_depth * span.z())};
}

class Placing {
 public:
  Placing(std::vector<SplatView>& views, const PlacingOptions& options) : options_(options) {
    for (SplatView& view : views) views_.emplace_back(view);
  }

  // Adds a layer, or a part of it with which there are more than `most` Gaussians.
  void Place(Layer layer, std::size_t most, Gaussians& gaussians) {
    is_rest_ = layer == Layer::kRestOfDetail || layer == Layer::kRestOfGround;
    is_detail_ = layer == Layer::kDetail || layer == Layer::kRestOfDetail;
    if (!is_rest_)
      for (const FastView& view : views_) view.view->done.setTo(0);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const std::vector<SurfacePatch> patches = PatchesOf(v);
      for (const SurfacePatch& patch : patches) gaussians.push_back(GaussianOf(patch));
      if (gaussians.size() > most) return;
      if (options_.progress) options_.progress(ShareDone(layer, v));
      ParallelFor(views_.size(), [&](std::size_t w) {
        for (const SurfacePatch& patch : patches) MarkIn(w, v, patch);
      });
    }
  }

 private:
  double ShareDone(Layer layer, std::size_t v) const {
    const double views = static_cast<double>(v) / static_cast<double>(views_.size());
    return (static_cast<double>(layer) + views) / static_cast<double>(kLayers.size());
  }
  const SurfaceMap& SurfaceOf(const FastView& view) const {
    return is_rest_ ? view.view->mesh_surface : view.view->surface;
  }

  Gaussian GaussianOf(const SurfacePatch& patch) const {
    if (is_detail_) return FlatGaussian(kDetailForm, patch);
    SurfaceCell ground = patch;
    ground.point -= kBehind * std::max(patch.across.norm(), patch.down.norm()) * patch.normal;
    return FlatGaussian(kGroundForm, ground);
  }

  // Returns the cell's piece of surface; none without depth.
  std::optional<SurfacePatch> PatchAt(const FastView& of, float x, float y, int size) const {
    const Vector3f ray = of.RayAt(x, y);
    const auto plane = SurfaceOf(of).At(ray.x(), ray.y());
    if (!plane) return std::nullopt;
    const float depth = 1 / plane->inverse_depth;
    Vector3f normal(plane->by_x, plane->by_y,
                    plane->inverse_depth - plane->by_x * ray.x() - plane->by_y * ray.y());
    normal.normalize();
    const Vector3f towards = ray.normalized();
    const float cosine = normal.dot(towards);
    if (cosine < kLeastCosine) {  // turn it towards the view
      const Vector3f aside = (normal - cosine * towards).normalized();
      normal = kLeastCosine * towards + std::sqrt(1 - kLeastCosine * kLeastCosine) * aside;
    }
    const auto along = [&](const Vector3f& step) -> Vector3f {
      return depth * static_cast<float>(size) * (step - normal.dot(step) / normal.dot(ray) * ray);
    };
    SurfacePatch patch;
    patch.point = of.InWorld(depth * ray);
    patch.across = of.rotation.transpose() * along({1 / of.fx, 0, 0});
    patch.down = of.rotation.transpose() * along({0, 1 / of.fy, 0});
    patch.normal = of.rotation.transpose() * -normal;
    patch.here_px = static_cast<float>(size);
    patch.size_px = of.view->reduced * patch.here_px;
    patch.tolerance = SurfaceOf(of).step() * depth * depth;
    return patch;
  }

  // Returns whether the depths at the corners of a square around a place lie on the plane in its middle.
  bool IsFlat(const FastView& of, float x, float y, float half) const {
    const SurfaceMap& surface = SurfaceOf(of);
    const Vector3f ray = of.RayAt(x, y);
    const auto plane = surface.At(ray.x(), ray.y());
    if (!plane) return false;
    for (const float side : {-half, half})
      for (const float below : {-half, half}) {
        const Vector3f corner = of.RayAt(x + side, y + below);
        const auto there = surface.At(corner.x(), corner.y());
        const float expected = plane->inverse_depth + plane->by_x * (corner.x() - ray.x()) +
                               plane->by_y * (corner.y() - ray.y());
        if (!there || std::abs(there->inverse_depth - expected) > kFlatCell * surface.step()) return false;
      }
    return true;
  }

  // Moves the patch to the mean of the maps that agree with it; returns false if one sees through it, or, but
  // for the rest, none agrees.
  bool Confirm(std::size_t v, SurfacePatch& patch) const {
    int agreeing = 0;
    const float depth = views_[v].InCam(patch.point).z();
    float change = 0;  // of its inverse depth in its own view
    for (std::size_t w = 0; w < views_.size(); ++w) {
      if (w == v) continue;
      const PatchReading reading =
          ReadPatch(views_[w], SurfaceOf(views_[w]), patch, !options_.has_background);
      if (reading.vote == Vote::kSeesThrough) return false;
      if (reading.vote != Vote::kAgrees) continue;
      ++agreeing;
      const float ratio = reading.in_cam.z() / depth;
      change += ratio * ratio * reading.change;
    }
    if (!is_rest_ && views_.size() > 1 && agreeing == 0) return false;
    const float scale = 1 / (1 + depth * change / static_cast<float>(agreeing + 1));
    patch.point = views_[v].center + scale * (patch.point - views_[v].center);
    patch.across *= scale;
    patch.down *= scale;
    return true;
  }

  // Appends the patches of a cell, whole or in parts.
  void Visit(std::size_t v, int x, int y, int level, std::vector<SurfacePatch>& patches) const {
    const FastView& of = views_[v];
    const SplatView& view = *of.view;
    const int size = 1 << level, width = view.camera.width, height = view.camera.height;
    int open = 0, inside = 0;
    bool has_gap = false;
    for (int row = y; row < std::min(height, y + size); ++row)
      for (int column = x; column < std::min(width, x + size); ++column) {
        ++inside;
        open += view.done.at<std::uint8_t>(row, column) == 0;
        has_gap = has_gap || view.IsGap(column, row);
      }
    if (open == 0 || (level == 0 && has_gap)) return;
    const float middle_x = static_cast<float>(x) + 0.5f * static_cast<float>(size);
    const float middle_y = static_cast<float>(y) + 0.5f * static_cast<float>(size);
    const bool is_smooth =
        level > 0 && view.roughness[At(level)].at<std::uint8_t>(y >> level, x >> level) <= kRoughness;
    if (is_detail_ && level == kGroundLevel && is_smooth) return;  // the ground shows it
    // The ground reaches as far beyond its cell again.
    const float reach = (is_detail_ ? 0.5f : 1.25f) * static_cast<float>(size);
    const bool may_be_whole =
        is_detail_ ? level < kGroundLevel && is_smooth : level <= kGroundLevel || is_smooth;
    const bool whole = level == 0 || (may_be_whole && 2 * open >= size * size && inside == size * size &&
                                      !has_gap && IsFlat(of, middle_x, middle_y, reach));
    if (!whole) {
      for (const int below : {0, size / 2})
        for (const int beside : {0, size / 2})
          if (x + beside < width && y + below < height) Visit(v, x + beside, y + below, level - 1, patches);
      return;
    }
    auto patch = PatchAt(of, middle_x, middle_y, size);
    if (!patch || !Confirm(v, *patch)) return;
    patch->bgr = view.means[At(level)].at<cv::Vec3b>(y >> level, x >> level);
    patches.push_back(*patch);
  }

  std::vector<SurfacePatch> PatchesOf(std::size_t v) const {
    const SplatView& view = *views_[v].view;
    constexpr int kLevel = kCellSizes - 1, kLargest = 1 << kLevel;
    std::vector<std::vector<SurfacePatch>> rows(At((view.camera.height + kLargest - 1) / kLargest));
    ParallelFor(rows.size(), [&](std::size_t row) {
      for (int x = 0; x < view.camera.width; x += kLargest)
        Visit(v, x, static_cast<int>(row) * kLargest, kLevel, rows[row]);
    });
    std::vector<SurfacePatch> patches;
    for (const auto& row : rows) patches.insert(patches.end(), row.begin(), row.end());
    return patches;
  }

  // Marks the pixels of view `w` that a Gaussian of view `v` shows.
  void MarkIn(std::size_t w, std::size_t v, const SurfacePatch& patch) {
    const FastView& other = views_[w];
    const PatchReading reading = ReadPatch(other, SurfaceOf(other), patch, false);
    if (w != v && reading.vote != Vote::kAgrees) return;
    const Vector2f across = SpanInImage(other, reading.in_cam, patch.across);
    const Vector2f down = SpanInImage(other, reading.in_cam, patch.down);
    if (w != v && std::max(across.norm(), down.norm()) > kFinerBy * patch.here_px) return;
    const Vector2f half = 0.5f * (across.cwiseAbs() + down.cwiseAbs());
    const Vector2f at(other.fx * reading.in_cam.x() / reading.in_cam.z() + other.cx,
                      other.fy * reading.in_cam.y() / reading.in_cam.z() + other.cy);
    const auto first = [](float from) { return std::max(0, static_cast<int>(std::lround(from))); };
    const auto end = [](float to, int most) { return std::min(most, static_cast<int>(std::lround(to))); };
    cv::Mat& done = other.view->done;
    // The pixel in the middle is marked however small the cell is here.
    const int left = std::min(first(at.x() - half.x()), static_cast<int>(at.x()));
    const int top = std::min(first(at.y() - half.y()), static_cast<int>(at.y()));
    const int right =
        std::max(end(at.x() + half.x(), done.cols), std::min(done.cols, static_cast<int>(at.x()) + 1));
    const int bottom =
        std::max(end(at.y() + half.y(), done.rows), std::min(done.rows, static_cast<int>(at.y()) + 1));
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) done.at<std::uint8_t>(y, x) = 1;
  }

  const PlacingOptions& options_;
  bool is_rest_ = false, is_detail_ = false;  // the layer that is placed
  std::vector<FastView> views_;
};

}  // namespace

PlacedGaussians PlaceGaussians(std::vector<SplatView>& views, const PlacingOptions& options) {
  constexpr double kCounted = 4;  // times as many as may be: those beyond are not even counted
  const double share = options.has_background ? 1 - kAroundShare : 1;
  const double most = share * static_cast<double>(options.most);
  const auto most_counted = static_cast<std::size_t>(kCounted * most);
  PlacedGaussians placed;
  Placing placing(views, options);
  // The ground comes last, so that `done` says what it covers.
  for (const Layer layer : kLayers)
    if (placed.gaussians.size() <= most_counted) placing.Place(layer, most_counted, placed.gaussians);
  if (const auto count = static_cast<double>(placed.gaussians.size()); count > most) {
    placed.gaussians.clear();
    placed.too_many = count / most;
    return placed;
  }
  if (options.has_background) {
    placed.around = AddFarSphere(views, options.most, placed.gaussians);
    placed.behind = AddBackdrop(views, options.most, placed.gaussians);
  }
  if (placed.gaussians.empty())
    throw Error("no Gaussian can be placed: the depth maps of the views agree nowhere");
  return placed;
}

}  // namespace ulf::render
