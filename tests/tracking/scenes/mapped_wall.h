// A map of a wall of points, made by keyframes in a row before it, without images. World: x along the wall, y
// down, z towards it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/map/map.h"

namespace ulf::test {

inline Descriptor RandomDescriptor(Draw& draw) {
  Descriptor descriptor{};
  for (auto& word : descriptor)
    for (int bit = 0; bit < 64; ++bit) word = word << 1 | (draw.Uniform(0, 1) < 0.5 ? 1u : 0u);
  return descriptor;
}

inline Descriptor Disturbed(Descriptor descriptor, int bits, Draw& draw) {
  for (int i = 0; i < bits; ++i) {
    const int bit = static_cast<int>(draw.Uniform(0, 255.9));
    descriptor[static_cast<std::size_t>(bit / 64)] ^= std::uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

// Keyframes in a row before a wall of points, each seeing those near it.
struct MappedWall {
  CameraModel camera = SceneCamera();
  Map map{camera};
  std::vector<int> points;

  explicit MappedWall(int keyframes, unsigned seed = 1) {
    Draw draw(seed);
    std::vector<Descriptor> looks;
    for (int p = 0; p < 60 * keyframes; ++p) {
      points.push_back(map.AddPoint({draw.Uniform(-1, keyframes), draw.Uniform(-1, 1), draw.Uniform(3, 4)}));
      looks.push_back(RandomDescriptor(draw));
    }
    for (int k = 0; k < keyframes; ++k) {
      Keyframe keyframe;
      keyframe.cam_from_world.translation = {-static_cast<double>(k), 0, 0};
      std::vector<Feature> features;
      std::vector<int> seen;
      for (std::size_t p = 0; p < points.size(); ++p) {
        const auto img = camera.ImgFromCam(keyframe.cam_from_world * map.point(points[p]).position);
        if (!img || !camera.Contains(*img)) continue;
        features.push_back({*img, *camera.RayFromImg(*img), 0, 0, Disturbed(looks[p], 20, draw)});
        seen.push_back(points[p]);
      }
      keyframe.features = std::make_shared<const FeatureSet>(features, camera.width, camera.height);
      const int id = map.AddKeyframe(std::move(keyframe));
      for (int i = 0; i < static_cast<int>(seen.size()); ++i)
        map.AddObservation(seen[static_cast<std::size_t>(i)],
                           {id, i, features[static_cast<std::size_t>(i)].img, 1});
    }
    for (const int point : points) map.Update(point);
  }

  // Every link exists in both directions, and the counts are right.
  void ExpectConsistent() const {
    for (const Keyframe& keyframe : map.keyframes()) {
      int count = 0;
      for (int i = 0; i < static_cast<int>(keyframe.point_of_feature.size()); ++i) {
        const int id = keyframe.point_of_feature[static_cast<std::size_t>(i)];
        if (id < 0) continue;
        ++count;
        const auto& observations = map.point(id).observations;
        EXPECT_TRUE(map.point(id).alive);
        EXPECT_EQ(
            std::count_if(observations.begin(), observations.end(),
                          [&](const Observation& o) { return o.keyframe == keyframe.id && o.feature == i; }),
            1);
      }
      EXPECT_EQ(count, keyframe.points);
    }
    for (const MapPoint& point : map.points())
      for (const Observation& o : point.observations)
        EXPECT_EQ(map.keyframe(o.keyframe).point_of_feature[static_cast<std::size_t>(o.feature)], point.id);
  }
};

}  // namespace ulf::test
