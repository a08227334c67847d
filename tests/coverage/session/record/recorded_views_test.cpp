// Tests: coverage/session/record/recorded_views.
#include "coverage/session/record/recorded_views.h"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "core/light_field/folder/light_field_io.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/test_paths.h"

namespace ulf::test::recorded_views_test {
namespace {

using ::testing::ElementsAre;

RecordedViews AfterAnEarlierSession() {
  LightField earlier;
  earlier.cameras = {CameraModel::Pinhole(640, 480, 500)};
  for (const int id : {3, 7}) {
    View view;
    view.id = id;
    view.cam_from_world = PoseAt(id, 0);
    earlier.views.push_back(view);
  }
  return RecordedViews(earlier);
}

TEST(RecordedViews, EachIsSeenByItsOwnCamera) {
  RecordedViews views = AfterAnEarlierSession();
  views.Add({8, {}, PoseAt(20, 0)});
  const std::vector<CriterionView> seen = views.ForCriterion(CameraModel::Pinhole(640, 480, 515), 640);
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_NEAR(seen[0].fx, 500, 1e-9);
  EXPECT_NEAR(seen[1].fx, 500, 1e-9);
  EXPECT_NEAR(seen[2].fx, 515, 1e-9);
}

TEST(RecordedViews, TrackersMapMovesOnlyItsOwnViews) {
  RecordedViews views = AfterAnEarlierSession();
  views.Add({8, Anchored{0, PoseAt(20, 0)}, PoseAt(20, 0)});
  EXPECT_THAT(views.Ids(), ElementsAre(3, 7, 8));
  const Rigid3 late_from_live{Eigen::Quaterniond::Identity(), {0.01, 0, 0}};
  DriftingSource poses(late_from_live);
  EXPECT_NEAR(views.LargestMove(views.PosesNow(poses), &kSubject), 0, 1e-12);
  poses.Adjust(false);
  const std::map<int, Rigid3> now = views.PosesNow(poses);
  // One centimetre, as seen from a metre away.
  EXPECT_NEAR(views.LargestMove(now, &kSubject), 0.01, 1e-9);
  views.SetPoses(now);
  EXPECT_NEAR(views.LargestMove(now, &kSubject), 0, 1e-12);
  EXPECT_NEAR((views.views()[2].cam_from_world.OriginInSource() - PoseAt(20, 0).OriginInSource()).norm(),
              0.01, 1e-9);
  for (const std::size_t i : {0, 1})
    EXPECT_EQ(views.views()[i].cam_from_world.translation, PoseAt(views.views()[i].id, 0).translation);
}

// Lengths have doubled since the anchor was made, and the frame is found elsewhere.
class OtherLens : public DriftingSource {
 public:
  OtherLens() : DriftingSource({}) {}
  Rigid3 PoseOf(const Anchored& anchor) const override {
    Rigid3 pose = anchor.cam_from_keyframe;
    pose.translation *= 2;
    return pose * PoseAt(3, 2);
  }
  std::optional<Rigid3> PoseNow(const Track& track) const override {
    return track.lens_revision == 0 ? PoseAt(21, 1) : PoseOf(*track.anchor);
  }
};

TEST(RecordedViews, NewLensPlacesThemByTheirPoints) {
  RecordedViews views = AfterAnEarlierSession();
  Track before, after;
  after.lens_revision = 1;
  before.anchor = after.anchor = Anchored{0, PoseAt(20, 0)};
  for (const auto& [id, track] : {std::pair(8, before), {9, after}})
    views.Add({id, track.anchor, PoseAt(20, 0), std::make_shared<const Track>(track)});
  const OtherLens poses;
  views.ReestimatePoses(poses, 1e-6, &kSubject);
  EXPECT_LT(
      (views.PosesNow(poses).at(8).OriginInSource() - poses.PoseOf(*before.anchor).OriginInSource()).norm(),
      1e-9)
      << "hardly another lens";
  for (int i = 0; i < 2; ++i) {
    views.ReestimatePoses(poses, 0.05, &kSubject);
    const std::map<int, Rigid3> now = views.PosesNow(poses);
    EXPECT_LT((now.at(8).OriginInSource() - PoseAt(21, 1).OriginInSource()).norm(), 1e-9);
    EXPECT_LT(now.at(8).rotation.angularDistance(PoseAt(21, 1).rotation), 1e-7);
    EXPECT_LT((now.at(9).OriginInSource() - poses.PoseOf(*after.anchor).OriginInSource()).norm(), 1e-9);
    EXPECT_EQ(now.at(7).translation, PoseAt(7, 0).translation);
  }
}

TEST(RecordedViews, OneThatIsTakenBackIsGone) {
  RecordedViews views = AfterAnEarlierSession();
  EXPECT_TRUE(views.Remove(3));
  EXPECT_FALSE(views.Remove(3));
  EXPECT_THAT(views.Ids(), ElementsAre(7));
}

// Who follows hears of each change once, after it was made; earlier sessions' views are there before.
TEST(RecordedViews, TellsFollowersOfEveryChange) {
  struct Noted : RecordedViews::Observer {
    std::vector<std::string> changes;
    void Added(const RecordedViews::Entry& view, const Image& /*image*/) override {
      changes.push_back(fmt::format("added {}", view.id));
    }
    void Removed(const RecordedViews::Entry& view) override {
      changes.push_back(fmt::format("removed {}", view.id));
    }
    void Moved(const RecordedViews& views) override {
      changes.push_back(fmt::format("moved {}", views.size()));
    }
  } noted;
  RecordedViews views = AfterAnEarlierSession();
  const std::size_t earlier = views.size();
  views.Subscribe(noted);
  const std::uint64_t before = views.revision();
  views.Add({100, {}, Rigid3{}});
  EXPECT_EQ(views.revision(), before) << "views that were there stay as they are";
  views.SetPoses(views.Poses());
  EXPECT_NE(views.revision(), before);
  const std::uint64_t moved = views.revision();
  EXPECT_TRUE(views.Remove(100));
  EXPECT_NE(views.revision(), moved);
  EXPECT_THAT(noted.changes, ElementsAre("added 100", fmt::format("moved {}", earlier + 1), "removed 100"));
}

// The map, the journal and what was recorded are of one mind, whatever was corrected and taken back.
TEST(RecordedViews, MapAndJournalHaveTheSamePoses) {
  const ScratchFolder scratch;
  PlanarDevice device({{PoseAt(0, 0)}, {PoseAt(5, 1)}, {PoseAt(10, 0)}, {PoseAt(15, 1)}}, {});
  DriftingSource poses({Eigen::Quaterniond::Identity(), {0.02, 0, 0}});
  CaptureRequests requests;
  CaptureHooks hooks;
  hooks.requests = &requests;
  hooks.after_frame = [&](const SharedCaptureState& state) {
    if (state->frames == 2) poses.Adjust(true);
    if (state->frames == 3) requests.Push(TakeBackViews{{2}});
  };
  device.Start();
  const CaptureSummary summary =
      RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), Options(), hooks);
  const std::vector<CriterionView> on_disk = CriterionViews(ReadLightField(scratch / "lf"));
  ASSERT_EQ(on_disk.size(), 3u);
  ASSERT_EQ(summary.map->views().size(), 3u);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LT((on_disk[i].center_in_world - summary.map->views()[i].center_in_world).norm(), 1e-9) << i;
}

}  // namespace
}  // namespace ulf::test::recorded_views_test
