#include "render/scene/view_tiles.h"

#include <algorithm>
#include <array>

#include "core/base/at.h"
#include "render/proxy/depth_raster.h"

namespace ulf::render {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

// A tile is not split below the larger of these two sizes: a fixed one, and this share of the picture's
// longer side. Smaller tiles cost more than they save. Guessed.
constexpr int kViewTilerLeastTilePx = 32;
constexpr int kTilesAcross = 32;
// A tile with no more views is not split. Guessed.
constexpr std::size_t kFewViews = 4;
// Images are assumed larger or smaller by this share of their size, because the edges of distorted images are
// sampled. Guessed.
constexpr double kViewTilerMargin = 0.02;
// Views with a unit ray of smaller z are not tested by half-spaces but kept everywhere. Guessed.
constexpr double kViewTilerLeastForward = 0.1;

// Converts a linear function of a point in the camera's frame, divided by the point's depth, to a function of
// the picture's (x, y, 1, 1 / depth).
Vector4d OfPixel(const Eigen::RowVector3d& of_ray, double of_nearness, const CameraModel& camera) {
  const double x = of_ray.x() / camera.fx, y = of_ray.y() / camera.fy;
  return {x, y, of_ray.z() - x * camera.cx - y * camera.cy, of_nearness};
}

// A point is inside if all are positive.
using HalfSpaces = std::array<Vector4d, 5>;

struct Candidate {
  int view = 0;
  bool ends = false;
  bool whole = false;  // its image has all of the tile, or it cannot be tested
  HalfSpaces outer, inner;
};

// The range of 1 / depth of the triangles.
struct Extent {
  double least_nearness = 1e300, most_nearness = 0;
};

Extent ExtentOf(const Eigen::AlignedBox3f& box, const ViewTiler::Picture& picture) {
  const double nearest = kNearShare * picture.plane.offset;  // nearer triangles are not drawn
  Extent extent;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d p = picture.cam_from_world *
                       box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner)).cast<double>();
    const double nearness = 1 / std::max(p.z(), nearest);
    extent.least_nearness = std::min(extent.least_nearness, nearness);
    extent.most_nearness = std::max(extent.most_nearness, nearness);
  }
  return extent;
}

class Splitter {
 public:
  Splitter(const ViewTiler::Picture& picture, const std::optional<Extent>& triangles, int enough,
           ViewTiles& tiles)
      : picture_(picture),
        triangles_(triangles),
        enough_(enough),
        few_views_(kFewViews),
        plane_(OfPixel(picture.plane.normal.transpose(), 0, picture.camera) / picture.plane.offset),
        least_px_(std::max(kViewTilerLeastTilePx,
                           std::max(picture.camera.width, picture.camera.height) / kTilesAcross)),
        tiles_(tiles) {}

  void Split(const cv::Rect& px, const std::vector<Candidate>& all,
             std::vector<std::pair<int, bool>> candidates) {
    FindCorners(px);
    std::vector<std::pair<int, bool>> left;
    bool settled = true;
    int found = 0;
    for (auto [index, whole] : candidates) {
      const Candidate& candidate = all[At(index)];
      if (!whole && IsOutside(candidate.outer)) continue;
      whole = whole || IsInside(candidate.inner);
      left.push_back({index, whole});
      settled = settled && whole;
      found += whole && candidate.ends;
      if (found == enough_) break;
    }
    if (settled || left.size() <= few_views_ || std::max(px.width, px.height) <= least_px_) {
      const int first = static_cast<int>(tiles_.views.size());
      for (const auto& [index, whole] : left) tiles_.views.push_back(all[At(index)].view);
      tiles_.tiles.push_back({px, first, static_cast<int>(tiles_.views.size())});
      return;
    }
    const bool across = px.width > px.height;
    const int half = (across ? px.width : px.height) / 2;
    const cv::Rect a = across ? cv::Rect(px.x, px.y, half, px.height) : cv::Rect(px.x, px.y, px.width, half);
    const cv::Rect b = across ? cv::Rect(px.x + half, px.y, px.width - half, px.height)
                              : cv::Rect(px.x, px.y + half, px.width, px.height - half);
    Split(a, all, left);
    Split(b, all, left);
  }

 private:
  // Finds points whose convex hull, in (x, y, 1, 1 / depth), contains everything that the tile shows.
  void FindCorners(const cv::Rect& px) {
    const double least = 1 / picture_.plane.far_depth;
    std::array<Vector4d, 4> on_plane;
    double low = 1e300, high = 0;
    int clamped = 0;
    for (int corner = 0; corner < 4; ++corner) {
      Vector4d& p = on_plane[At(corner)];
      p = {1.0 * px.x + (corner & 1) * px.width, 1.0 * px.y + (corner >> 1) * px.height, 1, 0};
      const double nearness = plane_.dot(p);
      clamped += nearness <= least;
      p.w() = std::max(nearness, least);
      low = std::min(low, p.w());
      high = std::max(high, p.w());
    }
    corners_.assign(on_plane.begin(), on_plane.end());
    if (!triangles_ && (clamped == 0 || clamped == 4)) return;
    if (triangles_) {
      low = std::min(low, triangles_->least_nearness);
      high = std::max(high, triangles_->most_nearness);
    }
    corners_.clear();
    for (Vector4d p : on_plane)
      for (const double nearness : {low, high}) {
        p.w() = nearness;
        corners_.push_back(p);
      }
  }
  bool IsOutside(const HalfSpaces& outer) const {
    return std::ranges::any_of(outer, [&](const Vector4d& side) {
      return std::ranges::all_of(corners_, [&](const Vector4d& p) { return side.dot(p) <= 0; });
    });
  }
  bool IsInside(const HalfSpaces& inner) const {
    return std::ranges::all_of(inner, [&](const Vector4d& side) {
      return std::ranges::all_of(corners_, [&](const Vector4d& p) { return side.dot(p) > 0; });
    });
  }

  const ViewTiler::Picture& picture_;
  const std::optional<Extent>& triangles_;
  int enough_;
  std::size_t few_views_;
  Vector4d plane_;  // 1 / depth of the plane
  int least_px_;
  ViewTiles& tiles_;
  std::vector<Vector4d> corners_;
};

}  // namespace

ViewTiler::ViewTiler(const std::vector<SceneView>& views) {
  // Most views have the same camera as the previous one.
  for (std::size_t i = 0; i < views.size(); ++i)
    slopes_.push_back(i > 0 && views[i].camera == views[i - 1].camera ? slopes_.back()
                                                                      : SlopesOf(views[i].camera));
}

std::optional<ViewTiler::Slopes> ViewTiler::SlopesOf(const CameraModel& camera) const {
  constexpr int kSteps = 32;  // on each side of the image
  Eigen::AlignedBox2d box;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = 1.0 * camera.width * i / kSteps, y = 1.0 * camera.height * i / kSteps;
    for (const Vector2d& img :
         {Vector2d(x, 0), Vector2d(x, camera.height), Vector2d(0, y), Vector2d(camera.width, y)}) {
      const auto ray = camera.RayFromImg(img);
      if (!ray || ray->z() < kViewTilerLeastForward) return std::nullopt;
      box.extend(ray->head<2>() / ray->z());
    }
  }
  return Slopes{box.min(), box.max()};
}

void ViewTiler::UpdateBox(const std::shared_ptr<const TriangleMesh>& triangles) {
  if (triangles == boxed_) return;
  boxed_ = triangles;
  box_.setEmpty();
  if (triangles)
    for (const Eigen::Vector3f& vertex : triangles->vertices) box_.extend(vertex);
}

ViewTiles ViewTiler::Tile(const std::vector<SceneView>& views, std::span<const int> in_order,
                          const Picture& picture, const std::function<bool(int view)>& ends, int enough) {
  UpdateBox(picture.triangles);
  std::optional<Extent> triangles;
  if (picture.triangles && !box_.isEmpty()) triangles = ExtentOf(box_, picture);
  const Rigid3 world_from_cam = picture.cam_from_world.Inverse();
  std::vector<Candidate> all;
  all.reserve(in_order.size());
  std::vector<std::pair<int, bool>> candidates;
  for (const int view : in_order) {
    const SceneView& v = views[At(view)];
    Candidate& candidate = all.emplace_back();
    candidate.view = view;
    if (const auto& slopes = slopes_[At(view)]) {
      const Rigid3 view_from_cam = v.cam_from_world * world_from_cam;
      const Eigen::Matrix3d r = view_from_cam.RotationMatrix();
      const auto row = [&](int i) { return OfPixel(r.row(i), view_from_cam.translation[i], picture.camera); };
      const Vector4d x = row(0), y = row(1), z = row(2);
      const Vector2d margin = kViewTilerMargin * (slopes->high - slopes->low);
      const auto sides = [&](const Vector2d& low, const Vector2d& high) {
        return HalfSpaces{z, x - low.x() * z, high.x() * z - x, y - low.y() * z, high.y() * z - y};
      };
      candidate.outer = sides(slopes->low - margin, slopes->high + margin);
      candidate.inner = sides(slopes->low + margin, slopes->high - margin);
      candidate.ends = v.camera.distortion == Distortion::kNone && ends(view);
    } else {
      candidate.whole = true;
    }
    candidates.push_back({static_cast<int>(all.size()) - 1, candidate.whole});
  }
  ViewTiles tiles;
  Splitter(picture, triangles, enough, tiles)
      .Split({0, 0, picture.camera.width, picture.camera.height}, all, std::move(candidates));
  return tiles;
}

}  // namespace ulf::render
