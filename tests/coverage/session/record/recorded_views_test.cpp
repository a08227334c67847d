// Tests: coverage/session/record/recorded_views.
#include "coverage/session/record/recorded_views.h"

#include <gmock/gmock.h>

#include "tests/coverage/session/planar_capture.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

using ::testing::ElementsAre;

RecordedViews AfterAnEarlierSession() {
  LightField earlier;
  for (const int id : {3, 7}) {
    View view;
    view.id = id;
    view.cam_from_world = PoseAt(id, 0);
    earlier.views.push_back(view);
  }
  return RecordedViews(earlier);
}

TEST(RecordedViews, TheTrackersMapMovesThoseThatHangOnItAndNoOthers) {
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
  views.MoveTo(now);
  EXPECT_NEAR(views.LargestMove(now, &kSubject), 0, 1e-12);
  EXPECT_NEAR((views.views()[2].cam_from_world.OriginInSource() - PoseAt(20, 0).OriginInSource()).norm(),
              0.01, 1e-9);
  for (const std::size_t i : {0, 1})
    EXPECT_EQ(views.views()[i].cam_from_world.translation, PoseAt(views.views()[i].id, 0).translation);
}

TEST(RecordedViews, OneThatIsTakenBackIsGone) {
  RecordedViews views = AfterAnEarlierSession();
  EXPECT_TRUE(views.Remove(3));
  EXPECT_FALSE(views.Remove(3));
  EXPECT_THAT(views.Ids(), ElementsAre(7));
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
    if (state->frames == 3) requests.Ask(TakeBackViews{{2}});
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
}  // namespace ulf::test
