// Tests: coverage/session/capture_session, coverage/session/record/capture_record,
// coverage/measured/error_meter.
//
// A camera that is torn away and held somewhere else in the next frame, with geometry and measured
// errors: nothing wrong is recorded or measured while nobody knows where it is, and the capture goes on
// when it is back.
#include <gmock/gmock.h>

#include "acquisition/simulator/hand.h"
#include "acquisition/simulator/simulated_device.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::jumping_camera_test {
namespace {

constexpr double kJumps_s = 6, kIsBack_s = 7.5, kEnds_s = 12;

// Goes to and fro before the studio; between the two moments it stands on the other side of the arc and
// looks at the wall.
class JumpingHand : public HandMotion {
 public:
  Rigid3 CamFromWorld(double time_s) const override {
    const bool away = time_s >= kJumps_s && time_s < kIsBack_s;
    const double angle = away ? Radians(70) : Radians(20) * std::sin(time_s);
    const Vector3d middle(0, 0, 0.1);
    const Vector3d at = middle + Vector3d(std::sin(angle), -std::cos(angle), 0.3 + 0.05 * time_s);
    return LookAt(at, away ? Vector3d(at + Vector3d(1, 0.2, 0.3)) : middle, Vector3d::UnitZ());
  }
};

TEST(JumpingCamera, NothingWrongIsRecordedOrMeasured) {
  const ScratchFolder scratch;
  const auto hand = std::make_shared<JumpingHand>();
  const auto device = OpenSimulatedDevice(DeviceUri::Parse("sim:studio?width=320&height=240&fps=15"), hand);
  device->Start();
  const CameraModel camera = *device->Camera();
  const auto poses = MakeTrackerSource(camera, {.deterministic = true, .wait_for_mapper = true});
  CaptureOptions options;
  options.deterministic = true;
  options.threshold_px = 9;
  options.geometry = true;
  options.cover = CoverGoal::Parse("both:30");
  options.max_seconds = kEnds_s;
  std::map<std::string, int> recorded, without_pose;
  int measured_away = 0, measured_before = 0;
  std::shared_ptr<const ErrorMap> errors;
  CaptureHooks hooks;
  std::optional<double> starts_s;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    if (!starts_s) starts_s = now->device_time_s;
    const double time_s = now->device_time_s - *starts_s;
    constexpr double kMargin_s = 0.1;
    const bool before = time_s<kJumps_s - kMargin_s, back = time_s> kIsBack_s + kMargin_s;
    const bool away = time_s > kJumps_s + kMargin_s && time_s < kIsBack_s - kMargin_s;
    const std::string when = before ? "before" : away ? "away" : back ? "back" : "between";
    recorded[when] += now->recorded_view.has_value();
    without_pose[when] += !now->cam_from_world;
    if (now->errors != std::exchange(errors, now->errors)) ++(away ? measured_away : measured_before);
  };
  const CaptureSummary summary =
      RunCapture(*device, camera, *poses, NewWriter(scratch / "lf", camera), options, hooks);
  EXPECT_TRUE(summary.problem.empty()) << summary.problem;
  EXPECT_GT(recorded["before"], 5);
  EXPECT_EQ(recorded["away"], 0);
  EXPECT_GT(without_pose["away"], 10) << "it is not believed to be where it cannot be";
  EXPECT_GT(recorded["back"], 0) << "the capture goes on";
  EXPECT_GT(measured_before, 5);
  EXPECT_EQ(measured_away, 0);

  // Every view stands where it was taken: distances between views are as in truth, at one scale.
  const LightField light_field = ReadLightField(scratch / "lf");
  ASSERT_GT(light_field.views.size(), 6u);
  EXPECT_EQ(light_field.views.size(), summary.recorded);
  const auto is_at = [&](const View& view) {
    return hand->CamFromWorld(view.device_time_s).OriginInSource();
  };
  const View& first = light_field.views.front();
  std::vector<double> scales;
  for (const View& view : light_field.views)
    if (const double truth = (is_at(view) - is_at(first)).norm(); truth > 0.1)
      scales.push_back((view.CenterInWorld() - first.CenterInWorld()).norm() / truth);
  ASSERT_GT(scales.size(), 4u);
  const auto [least, most] = std::ranges::minmax(scales);
  EXPECT_LT(most / least, 1.1);
  EXPECT_TRUE(summary.geometry && summary.geometry->mesh);
}

}  // namespace
}  // namespace ulf::test::jumping_camera_test
