// A wall of points that repeats itself, mapped, without a picture of it: what finds a lost camera among
// places that look alike. World: x along the wall, y down, z towards it.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/map/frame_locator.h"

namespace ulf::test {

// Mapped by keyframes that moved along a part of it.
class TiledWall {
 public:
  struct Options {
    double period = 0.8;      // of the image's width at the wall
    double unique_share = 0;  // of the points look like no other tile's
    unsigned seed = 1;
    double mapped = 5;            // image widths, from x = 0; the wall goes on as far on both sides
    double keyframe_step = 0.12;  // image widths
  };
  static constexpr double kDepth = 2, kWidth = kDepth * 640 / 525;  // of what an image shows
  static constexpr double kMapped = 5 * kWidth;

  explicit TiledWall(const Options& options) {
    Draw draw(options.seed);
    const double period = options.period * kWidth, mapped = options.mapped * kWidth;
    const int in_tile = static_cast<int>(300 * options.period);
    const int tiles = static_cast<int>(std::ceil(3 * mapped / period));
    for (int i = 0; i < in_tile; ++i) {
      const Eigen::Vector3d place(draw.Uniform(0, period), draw.Uniform(-0.8, 0.8),
                                  kDepth + draw.Uniform(-0.2, 0.2));
      const Descriptor look = RandomLook(draw);
      const bool unique = draw.Uniform(0, 1) < options.unique_share;
      for (int t = 0; t < tiles; ++t)
        dots_.push_back(
            {place + Eigen::Vector3d(t * period - mapped, 0, 0), unique ? RandomLook(draw) : look});
    }
    Map& map = owned_.map;
    std::vector<int> point_of(dots_.size(), -1);
    for (double x = 0.5 * kWidth; x <= mapped - 0.5 * kWidth; x += options.keyframe_step * kWidth) {
      Keyframe keyframe;
      keyframe.cam_from_world = PoseAt(x, draw);
      std::vector<int> seen;
      keyframe.features = Look(keyframe.cam_from_world, draw, &seen);
      const auto features = keyframe.features;
      const int id = map.AddKeyframe(std::move(keyframe));
      for (int i = 0; i < features->size(); ++i) {
        int& point = point_of[static_cast<std::size_t>(seen[static_cast<std::size_t>(i)])];
        if (point < 0)
          point = map.AddPoint(dots_[static_cast<std::size_t>(seen[static_cast<std::size_t>(i)])].place);
        map.AddObservation(point, {id, i, (*features)[i].img, 1});
      }
      for (const int dot : seen) map.Update(point_of[static_cast<std::size_t>(dot)]);
      index_.Add(map.keyframe(id));
    }
    for (const MapPoint& point : map.points())
      map.point(point.id).expected = map.point(point.id).found = static_cast<int>(point.observations.size());
  }

  static Rigid3 PoseAt(double x, Draw& draw) {
    const Eigen::Vector3d center(x, draw.Uniform(-0.1, 0.1), draw.Uniform(-0.1, 0.1));
    return LookAt(center, center + Eigen::Vector3d(draw.Uniform(-0.1, 0.1), 0, 2), -Eigen::Vector3d::UnitY());
  }

  std::optional<FramePose> Find(const Rigid3& cam_from_world, Draw& draw) const {
    const TrackedImage image{0, nullptr, Look(cam_from_world, draw, nullptr)};
    return FrameLocator(camera_, owned_.shared, 1000).Find(image, index_, 1);
  }

  // Told by something else where it is.
  std::optional<FramePose> FindAt(const Rigid3& cam_from_world, const Rigid3& told, Draw& draw) const {
    const TrackedImage image{0, nullptr, Look(cam_from_world, draw, nullptr)};
    return FrameLocator(camera_, owned_.shared, 1000).FindAt(image, told);
  }

 private:
  struct Dot {
    Eigen::Vector3d place;
    Descriptor look;
  };
  static Descriptor RandomLook(Draw& draw) {
    Descriptor look{};
    for (auto& word : look)
      for (int bit = 0; bit < 64; ++bit) word = word << 1 | (draw.Uniform(0, 1) < 0.5 ? 1u : 0u);
    return look;
  }
  std::shared_ptr<const FeatureSet> Look(const Rigid3& cam_from_world, Draw& draw,
                                         std::vector<int>* seen) const {
    std::vector<Feature> features;
    for (std::size_t d = 0; d < dots_.size(); ++d) {
      const Eigen::Vector3d in_cam = cam_from_world * dots_[d].place;
      if (std::abs(in_cam.x()) > in_cam.z()) continue;
      const auto img = camera_.ImgFromCam(in_cam);
      if (!img || !camera_.Contains(*img) || draw.Uniform(0, 1) < 0.2) continue;
      Descriptor look = dots_[d].look;
      for (int i = 0; i < 18; ++i) {
        const int bit = static_cast<int>(draw.Uniform(0, 255.9));
        look[static_cast<std::size_t>(bit / 64)] ^= std::uint64_t{1} << (bit % 64);
      }
      const Eigen::Vector2d measured = *img + Eigen::Vector2d(draw.Normal(0.5), draw.Normal(0.5));
      const auto ray = camera_.RayFromImg(measured);
      if (!ray) continue;
      features.push_back({measured, *ray, 0, 0, look});
      if (seen) seen->push_back(static_cast<int>(d));
    }
    return std::make_shared<const FeatureSet>(std::move(features), camera_.width, camera_.height);
  }

  CameraModel camera_ = SceneCamera();
  std::vector<Dot> dots_;
  OwnedMap owned_{Map(camera_)};
  KeyframeIndex index_{1};
};

}  // namespace ulf::test
