// Tests: tracking/refine/refine_scene, tracking/refine/track_building, tracking/refine/view_matching,
// tracking/refine/view_pairs.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <set>

#include "core/geometry/similarity3.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/mapped_wall.h"
#include "tracking/refine/track_building.h"
#include "tracking/refine/view_matching.h"

namespace ulf::pairs_and_tracks_test {
namespace {

using Eigen::Vector3d;
using test::Draw;

// Views on a grid before a cloud of points with descriptors, without images.
struct Cloud {
  RefineScene scene;
  std::vector<Vector3d> points;
  std::vector<std::vector<int>> point_of_feature;  // by view

  explicit Cloud(const std::vector<Rigid3>& poses, unsigned seed = 1) {
    Draw draw(seed);
    const CameraModel camera = test::SceneCamera();
    scene.lenses = {camera};
    std::vector<Descriptor> looks;
    for (int p = 0; p < 400; ++p) {
      points.push_back({draw.Uniform(-1, 1), draw.Uniform(-0.8, 0.8), draw.Uniform(2.5, 3.5)});
      looks.push_back(test::RandomDescriptor(draw));
    }
    for (const Rigid3& pose : poses) {
      std::vector<Feature> features;
      std::vector<int>& seen = point_of_feature.emplace_back();
      for (std::size_t p = 0; p < points.size(); ++p) {
        const auto img = camera.ImgFromCam(pose * points[p]);
        if (!img || !camera.Contains(*img)) continue;
        features.push_back({*img, *camera.RayFromImg(*img), 0, 0, test::Disturbed(looks[p], 20, draw)});
        seen.push_back(static_cast<int>(p));
      }
      RefineView& view = scene.views.emplace_back();
      view.start = view.cam_from_world = pose;
      view.features = FeatureSet(features, camera.width, camera.height);
      view.feature_rgb.assign(features.size(), {1, 2, 3});
    }
  }
};

std::vector<Rigid3> Grid() {
  std::vector<Rigid3> poses;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      poses.push_back(LookAt({0.15 * x - 0.225, 0.15 * y - 0.225, 0}, {0, 0, 3}, -Vector3d::UnitY()));
  return poses;
}

// View, column and row of 10 x 8 parts of its image that show a track.
std::set<std::array<int, 3>> CoveredParts(const RefineScene& scene) {
  std::set<std::array<int, 3>> parts;
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& seen : track.observations) {
      const CameraModel& camera = scene.LensOf(scene.view(seen.view));
      parts.insert({seen.view, static_cast<int>(seen.img.x() * 10 / camera.width),
                    static_cast<int>(seen.img.y() * 8 / camera.height)});
    }
  return parts;
}

RefineStage Unseen() {
  static const std::function<void(double, const std::string&)> nobody;
  return {nobody};
}

TEST(ViewPairs, ComparesEachViewWithNearAndFarOnes) {
  const Cloud cloud(Grid());
  const auto pairs = ChoosePairs(cloud.scene);
  std::vector<int> partners(16, 0);
  for (const auto& [first, second] : pairs) {
    EXPECT_LT(first, second);
    ++partners[static_cast<std::size_t>(first)];
    ++partners[static_cast<std::size_t>(second)];
  }
  for (int v = 0; v < 16; ++v) EXPECT_GE(partners[static_cast<std::size_t>(v)], 3) << v;
  EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
  EXPECT_LT(pairs.size(), 16u * 15 / 2) << "not every pair";
}

TEST(ViewPairs, PoseErrorsAreMeasuredInPixels) {
  Cloud cloud(Grid());
  const auto pairs = ChoosePairs(cloud.scene);
  const auto exact_px = MeasurePoseErrorPx(cloud.scene, pairs);
  ASSERT_TRUE(exact_px);
  EXPECT_LT(*exact_px, 0.01);
  Draw draw(3);
  for (RefineView& view : cloud.scene.views)
    view.cam_from_world = test::RandomPose(draw, 0.01, 0) * view.cam_from_world;
  const auto disturbed_px = MeasurePoseErrorPx(cloud.scene, pairs);
  ASSERT_TRUE(disturbed_px);
  EXPECT_GT(*disturbed_px, 1);
  EXPECT_LT(*disturbed_px, 10);
}

TEST(ViewMatching, GuidedAndUnguidedMatchesAreRight) {
  Cloud cloud(Grid());
  const auto pairs = ChoosePairs(cloud.scene);
  for (const double error_px : {0.1, 6.0}) {
    int right = 0, wrong = 0;
    for (const PairMatches& pair : MatchPairs(cloud.scene, pairs, error_px, Unseen()))
      for (const FeatureMatch& match : pair.matches)
        ++(cloud.point_of_feature[static_cast<std::size_t>(pair.first)][static_cast<std::size_t>(
               match.first)] == cloud.point_of_feature[static_cast<std::size_t>(pair.second)]
                                                      [static_cast<std::size_t>(match.second)]
               ? right
               : wrong);
    EXPECT_GT(right, 200 * static_cast<int>(pairs.size())) << error_px;
    EXPECT_LT(wrong, right / 100) << error_px;
  }
}

TEST(ViewPairs, ViewsFromOnePlaceAreRecognised) {
  std::vector<Rigid3> turned;
  for (int k = 0; k < 8; ++k)
    turned.push_back({Eigen::Quaterniond(Eigen::AngleAxisd(0.03 * k, Vector3d::UnitY())), Vector3d::Zero()});
  for (const bool one_place : {true, false}) {
    const Cloud cloud(one_place ? turned : Grid());
    std::vector<PairMatches> matched;
    for (int v = 0; v + 1 < static_cast<int>(cloud.scene.views.size()); ++v) {
      PairMatches& pair = matched.emplace_back(PairMatches{v, v + 1, {}, 0});
      const FeatureSet &a = cloud.scene.view(v).features, &b = cloud.scene.view(v + 1).features;
      for (int i = 0; i < a.size(); ++i)
        for (int j = 0; j < b.size(); ++j)
          if (cloud.point_of_feature[static_cast<std::size_t>(v)][static_cast<std::size_t>(i)] ==
              cloud.point_of_feature[static_cast<std::size_t>(v + 1)][static_cast<std::size_t>(j)])
            pair.matches.push_back({i, j, 0});
    }
    EXPECT_EQ(IsOnePlace(cloud.scene, matched, 1), one_place);
  }
}

TEST(TrackBuilding, TracksLieWhereThePointsAre) {
  Cloud cloud(Grid());
  const auto matched = MatchPairs(cloud.scene, ChoosePairs(cloud.scene), 0.1, Unseen());
  BuildTracks(matched, {.per_view = 100000}, cloud.scene);
  ASSERT_GT(cloud.scene.tracks.size(), 350u);
  int far = 0;
  for (const SceneTrack& track : cloud.scene.tracks) {
    double nearest = 1e9;
    for (const Vector3d& point : cloud.points) nearest = std::min(nearest, (point - track.position).norm());
    far += nearest > 1e-3;
    std::set<int> views;
    for (const TrackObservation& seen : track.observations) EXPECT_TRUE(views.insert(seen.view).second);
  }
  EXPECT_LT(far, 5);
  EXPECT_EQ(GroupViews(cloud.scene).count, 1);
  const std::size_t all = cloud.scene.tracks.size();
  const auto covered = CoveredParts(cloud.scene);
  BuildTracks(matched, {.per_view = 80}, cloud.scene);
  EXPECT_LT(cloud.scene.tracks.size(), all / 2) << "thinned out";
  EXPECT_EQ(CoveredParts(cloud.scene), covered) << "but evenly: no part of an image loses all its tracks";
}

TEST(TrackBuilding, AWrongObservationIsLeftOut) {
  Cloud cloud(Grid());
  SceneTrack track;
  for (int v = 0; v < 8; ++v) {
    const auto& seen = cloud.point_of_feature[static_cast<std::size_t>(v)];
    const auto found = std::find(seen.begin(), seen.end(), 7);
    if (found == seen.end()) continue;
    const int feature = static_cast<int>(found - seen.begin());
    track.observations.push_back({v, feature, cloud.scene.view(v).features[feature].img, 1});
  }
  ASSERT_GE(track.observations.size(), 5u);
  const std::size_t all = track.observations.size();
  track.observations[1].img.x() += 40;
  ASSERT_TRUE(TriangulateRobustly(cloud.scene, {}, track));
  EXPECT_EQ(track.observations.size(), all - 1);
  EXPECT_LT((track.position - cloud.points[7]).norm(), 1e-3);
}

TEST(RefineSceneTest, AlignToStartUndoesASimilarity) {
  Cloud cloud(Grid());
  BuildTracks(MatchPairs(cloud.scene, ChoosePairs(cloud.scene), 0.1, Unseen()), {}, cloud.scene);
  const Similarity3 moved{
      1.3, Eigen::AngleAxisd(0.2, Vector3d::UnitX()).toRotationMatrix(), {0.4, -0.2, 0.1}};
  for (RefineView& view : cloud.scene.views) {
    const Vector3d center = moved * view.start.OriginInSource();
    view.cam_from_world.rotation = view.start.rotation * Eigen::Quaterniond(moved.rotation).conjugate();
    view.cam_from_world.translation = -(view.cam_from_world.rotation * center);
  }
  for (SceneTrack& track : cloud.scene.tracks) track.position = moved * track.position;
  ASSERT_TRUE(AlignToStart(cloud.scene));
  for (const RefineView& view : cloud.scene.views)
    EXPECT_LT((view.cam_from_world.OriginInSource() - view.start.OriginInSource()).norm(), 1e-6);
}

}  // namespace
}  // namespace ulf::pairs_and_tracks_test
