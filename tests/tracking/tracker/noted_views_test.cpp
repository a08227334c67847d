// Tests: tracking/map/map, tracking/tracker/tracker.
// Frames that become recorded views leave in the map what they show of its points.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/base/quantile.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/map/map.h"
#include "tracking/tracker/tracker.h"

namespace ulf::noted_views_test {
namespace {

using test::TexturedRoom;

// In pixels of the pictures as they come, whatever size they are tracked at.
TEST(NotedViews, AreSeenByThePointsThatTheyShow) {
  const TexturedRoom room{{}};
  const CameraModel camera = TexturedRoom::Camera().ScaledTo(320, 240);
  for (const int max_side_px : {0, 240}) {
    Tracker tracker(camera, {.deterministic = true, .features = 600, .max_side_px = max_side_px});
    std::map<int, Anchored> anchors;
    for (int k = 0; k < 60; ++k) {
      const Track track =
          tracker.Step(room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), camera));
      EXPECT_EQ(track.seen != nullptr, track.cam_from_world.has_value());
      if (k % 5 != 0 || !track.cam_from_world) continue;
      tracker.NoteView(k, track);
      anchors[k] = *track.anchor;
    }
    tracker.Finish();
    ASSERT_GT(anchors.size(), 5u) << max_side_px;
    std::vector<double> errors_px, lengths;
    for (const ScenePoint& point : tracker.Points()) {
      std::set<int> views;
      for (const ViewObservation& seen : point.track) {
        EXPECT_TRUE(views.insert(seen.view_id).second) << "once a view";
        const Rigid3 pose = tracker.PoseOf(anchors.at(seen.view_id));
        errors_px.push_back((*camera.ImgFromCam(pose * point.position_in_world) - seen.in_img).norm());
      }
      if (!views.empty()) lengths.push_back(static_cast<double>(views.size()));
    }
    EXPECT_GT(errors_px.size(), 150 * anchors.size()) << max_side_px;
    EXPECT_LT(Median(errors_px), 0.4) << max_side_px;
    EXPECT_LT(Quantile(errors_px, 0.95), 2) << max_side_px;
    EXPECT_GT(Quantile(lengths, 0.9), 4) << max_side_px;
  }
}

TEST(NotedViews, GoWithPointsThatAreMergedAndRemoved) {
  Map map(TexturedRoom::Camera());
  const int kept = map.AddPoint({0, 0, 3}), gone = map.AddPoint({0, 0, 3.01});
  map.AddView(kept, {1, {10, 10}});
  map.AddView(kept, {2, {11, 10}});
  map.AddView(kept, {2, {99, 99}});
  map.AddView(gone, {2, {12, 10}});
  map.AddView(gone, {3, {13, 10}});
  map.Merge(gone, kept);
  std::map<int, double> seen;
  for (const ViewObservation& o : map.point(kept).views) seen[o.view_id] = o.in_img.x();
  EXPECT_EQ(seen, (std::map<int, double>{{1, 10}, {2, 11}, {3, 13}}));
  EXPECT_TRUE(map.point(gone).views.empty());
  map.RemovePoint(kept);
  EXPECT_TRUE(map.point(kept).views.empty());
}

}  // namespace
}  // namespace ulf::noted_views_test
