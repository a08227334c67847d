// Tests: coverage/session/record/capture_record, coverage/session/record/coverage_painter,
// coverage/session/record/measured_geometry, coverage/session/capture_state.
#include "coverage/session/record/capture_record.h"

#include <gmock/gmock.h>

#include <fstream>
#include <thread>

#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/capture_state.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/slow_disk.h"
#include "tests/support/test_paths.h"

namespace ulf::test::capture_record_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

// A correction for which the disk has no room yet moves no view. If the cap counted as covered by the poses
// of before, the capture would end, and the last correction could open the cap again.
TEST(CaptureRecord, SpooledPosesDoNotCoverACap) {
  const ScratchFolder scratch;
  CaptureOptions options;
  const CaptureLens lens(kCamera);
  options.cap = Cap::FromDegrees({16, 12});
  options.spool_views = 2;
  CaptureRecord record(NewWriter(scratch / "lf"), lens, options, [](const std::string&) {});
  record.SetSubject(kSubject);
  DriftingSource poses({Eigen::Quaterniond::Identity(), {0.4, 0, 0}});
  PlanarDevice device(Sweep(16, 12, 2), {});
  device.Start();

  const auto add_until_full = [&] {
    for (int i = 0; i < 40; ++i) {
      const auto frame = device.Next(1s);
      if (!frame || !record.Add(*frame, poses.Step(*frame), std::nullopt, poses)) return true;
    }
    return false;
  };
  double share = 0;
  {
    HangingDisk disk;
    ASSERT_TRUE(add_until_full());
    ASSERT_TRUE(record.map());
    share = record.map()->CoveredShare();
    ASSERT_GT(share, 0.02);
    EXPECT_TRUE(record.IsCapCovered(share, poses)) << "nothing was corrected";
    poses.Adjust(true);
    EXPECT_FALSE(record.IsCapCovered(share, poses)) << "the correction waits for the disk";
    ASSERT_FALSE(disk.GaveUp());
  }
  bool corrected = false;
  for (int tries = 0; tries < 500 && !corrected; ++tries) {
    corrected = record.CorrectPoses(poses, false);
    if (!corrected) std::this_thread::sleep_for(10ms);
  }
  EXPECT_TRUE(corrected);
  EXPECT_LT(record.views().LargestMove(record.views().PosesNow(poses), &kSubject), 1e-9)
      << "the views have moved";
  const ClosedRecord closed = record.Close(1, {}, {});
  EXPECT_EQ(closed.problem, "");
  EXPECT_EQ(ReadLightField(scratch / "lf").views.size(), record.views().views().size()) << "nothing is lost";
}

// Whichever way views change, the map shows them as they are.
TEST(CaptureRecord, TheMapFollowsEveryChangeOfViews) {
  const ScratchFolder scratch;
  const CaptureOptions options;
  const CaptureLens lens(kCamera);
  CaptureRecord record(NewWriter(scratch / "lf"), lens, options, [](const std::string&) {});
  record.SetSubject(kSubject);
  DriftingSource poses({Eigen::Quaterniond::Identity(), {0.4, 0, 0}});
  PlanarDevice device(Sweep(16, 12, 2), {});
  device.Start();
  const auto expect_followed = [&](const char* after) {
    std::vector<Eigen::Vector3d> shown, recorded;
    for (const CriterionView& view : record.map()->views()) shown.push_back(view.center_in_world);
    for (const auto& view : record.views().views()) recorded.push_back(view.cam_from_world.OriginInSource());
    EXPECT_EQ(shown, recorded) << after;
  };
  for (int i = 0; i < 3; ++i) {
    const auto frame = device.Next(1s);
    ASSERT_TRUE(record.Add(*frame, poses.Step(*frame), std::nullopt, poses));
  }
  expect_followed("three views");
  EXPECT_EQ(record.TakeBack({record.views().Ids()[1]}), 1u);
  ASSERT_EQ(record.map()->views().size(), 2u);
  expect_followed("one taken back");
  const auto before = record.map();
  EXPECT_EQ(record.TakeBack({99}), 0u);
  EXPECT_EQ(record.map(), before) << "nothing has changed";
  poses.Adjust(true);
  ASSERT_TRUE(record.CorrectPoses(poses, false));
  EXPECT_NE(record.map(), before);
  expect_followed("corrected poses");
  const Subject moved{kSubject.center_in_world, 1.1 * kSubject.radius};
  ASSERT_TRUE(record.CorrectPoses(poses, false, moved));
  EXPECT_EQ(record.map()->subject(), moved);
  DriftingSource under_other_lens({Eigen::Quaterniond::Identity(), {0.2, 0, 0}});
  under_other_lens.Adjust(true);
  record.ReplaceLens(kCamera, under_other_lens, true, moved);
  expect_followed("another lens");
  record.Close(0, {}, {});
}

// What --no-geometry leaves of a session before.
TEST(CaptureRecord, AMeshThatDoesNotKnowNewViewsIsNamed) {
  const ScratchFolder scratch;
  LightFieldWriter writer = NewWriter(scratch / "lf");
  std::ofstream(scratch / "lf/proxy.ply") << "a mesh of views before";
  CaptureOptions options;
  const CaptureLens lens(kCamera);
  std::vector<std::string> said;
  CaptureRecord record(std::move(writer), lens, options,
                       [&](const std::string& line) { said.push_back(line); });
  record.SetSubject(kSubject);
  DriftingSource poses(Rigid3{});
  PlanarDevice device(Sweep(16, 12, 2), {});
  device.Start();
  const auto frame = device.Next(1s);
  ASSERT_TRUE(record.Add(*frame, poses.Step(*frame), std::nullopt, poses));
  EXPECT_EQ(record.Close(1, {}, {}).recorded, 1u);
  EXPECT_THAT(said, ElementsAre("proxy.ply was made without 1 view of this session; 'ulf proxy " +
                                (scratch / "lf").string() + "' makes it anew"));
}

TEST(CaptureRecord, TellsWhetherAMeshMayStillCome) {
  const ScratchFolder scratch;
  for (const bool makes_geometry : {false, true}) {
    CaptureOptions options;
    options.geometry = makes_geometry;
    const CaptureLens lens(kCamera);
    CaptureRecord record(NewWriter(scratch / (makes_geometry ? "with" : "without")), lens, options,
                         [](const std::string&) {});
    CaptureState state;
    state.mesh_may_come = record.MeshMayCome();
    state.errors_may_come = record.ErrorsMayCome();
    EXPECT_EQ(MeshInWords(state),
              makes_geometry ? "over a plane: no mesh yet" : "over a plane: no mesh is made");
    EXPECT_EQ(ErrorsInWords(state), makes_geometry ? "errors: no mesh yet" : "errors: not measured");
    record.Close(0, {}, {});
  }
}

}  // namespace
}  // namespace ulf::test::capture_record_test
