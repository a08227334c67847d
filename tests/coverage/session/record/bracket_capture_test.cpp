// Tests: coverage/session/record/bracket_capture.
#include "coverage/session/record/bracket_capture.h"

#include <gmock/gmock.h>

#include <set>

#include "acquisition/device/device.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/capture_session.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/poses_spec.h"

namespace ulf::test::bracket_capture_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

TEST(ExposureBracketTest, IsSaidAsNumberAndStops) {
  const ExposureBracket bracket = ExposureBracket::Parse("5x1.5EV");
  EXPECT_EQ(bracket.exposures, 5);
  EXPECT_EQ(bracket.stops, 1.5);
  EXPECT_EQ(bracket.Text(), "5x1.5EV");
  EXPECT_THAT(bracket.StopsBesideOwn(), ElementsAre(-1.5, 1.5, -3, 3));
  EXPECT_THAT(ExposureBracket::Parse("2x3ev").StopsBesideOwn(), ElementsAre(-3)) << "highlights first";
  for (const char* wrong :
       {"", "3", "3x", "3x2", "x2EV", "3x2EVs", "3x2E", "1x2EV", "0x2EV", "-3x2EV", "12x2EV", "3x0EV",
        "3x-2EV", "3x9EV", "3xnanEV", "3.5x2EV", "3 x 2 EV EV", "threex2EV"})
    EXPECT_THAT([&] { ExposureBracket::Parse(wrong); }, ThrowsMessage<Refusal>(HasSubstr("3x2EV"))) << wrong;
}

TEST(AsExposedTest, BrightensAboveBlackAndClips) {
  Frame frame;
  frame.image = {.pixels = cv::Mat(4, 4, CV_16UC3, cv::Scalar::all(65535 * 0.2)),
                 .transfer = Transfer::kLinear};
  frame.exposure_s = 0.001;
  frame.black_level = 0.1;
  AsExposed(frame, 0.004, 1);
  EXPECT_EQ(frame.image.pixels.at<cv::Vec3w>(0, 0)[0], 13107) << "what is recorded stays as it is";
  EXPECT_NEAR(AsExposed(frame, 0.004, 1).image.pixels.at<cv::Vec3w>(0, 0)[0], 65535 * 0.5, 2);
  EXPECT_EQ(AsExposed(frame, 0.1, 1).image.pixels.at<cv::Vec3w>(0, 0)[0], 65535);
  frame.image = {.pixels = cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(100)), .transfer = Transfer::kSrgb};
  frame.black_level = 0;
  EXPECT_NEAR(LinearFromSrgb8()[AsExposed(frame, 0.002, 1).image.pixels.at<cv::Vec3b>(0, 0)[0]],
              2 * LinearFromSrgb8()[100], 0.005);
  frame.exposure_s = 0;
  EXPECT_EQ(AsExposed(frame, 0.002, 1).image.pixels.at<cv::Vec3b>(0, 0)[0], 100) << "not known";
}

constexpr char kUri[] =
    "sim:studio?width=320&height=240&fps=30&speed_deg_s=8&look_away=0&exposure_us=2000&format=rgb8&noise=0";

struct Bracketed {
  CaptureSummary summary;
  LightField light_field;
};

Bracketed Capture(const std::filesystem::path& dir, Device& device, PoseSource& poses, std::uint64_t frames,
                  const std::optional<Subject>& subject = {}) {
  CaptureOptions options;
  options.subject = subject;
  options.threshold_px = 12;
  options.deterministic = true;
  options.max_frames = frames;
  options.bracket = ExposureBracket::Parse("3x2EV");
  device.Start();
  CaptureHeader header;
  header.camera = *device.Camera();
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  Bracketed result;
  result.summary = RunCapture(device, *device.Camera(), poses, std::move(writer), options);
  result.light_field = ReadLightField(dir);
  return result;
}

// Where the camera stood for each exposure is known to the simulator.
TEST(BracketCapture, GivesEachViewItsPosedExposures) {
  const ScratchFolder scratch;
  const auto device = OpenDevice(kUri);
  const auto poses = MakeTrackerSource(*device->Camera(), {.deterministic = true});
  const Bracketed captured = Capture(scratch / "lf", *device, *poses, 150);
  const LightField& light_field = captured.light_field;
  ASSERT_GE(light_field.views.size(), 4u);
  EXPECT_EQ(captured.summary.brackets.views, light_field.views.size());
  EXPECT_LE(captured.summary.brackets.incomplete, 1u) << "the last may be cut off";
  std::set<double> times;
  std::size_t complete = 0;
  for (const View& view : light_field.views) {
    complete += view.exposures.size() == 2;
    EXPECT_DOUBLE_EQ(view.exposure_s, 0.002) << "no other exposure becomes a view";
    for (const ViewExposure& exposure : view.exposures) {
      times.insert(exposure.exposure_s);
      EXPECT_GT(exposure.device_time_s, view.device_time_s);
      EXPECT_LT(exposure.device_time_s, view.device_time_s + 0.2);
      // The hand moves at 8 degrees a second round a subject at the distance 1 in its own unit: the camera's
      // way from view to exposure, over that from this view to any other in the same time, is its share.
      const double moved = RotationAngle(exposure.exposure_from_view.rotation);
      EXPECT_GT(moved, 0.05 * M_PI / 180 * (exposure.device_time_s - view.device_time_s));
      EXPECT_LT(moved, 25 * M_PI / 180 * (exposure.device_time_s - view.device_time_s));
    }
  }
  EXPECT_GE(complete + 1, light_field.views.size());
  EXPECT_THAT(times, ElementsAre(0.0005, 0.008));
  EXPECT_GT(light_field.reasons.at("bracket"), 2 * complete - 1);
  EXPECT_TRUE(captured.summary.mistakes.empty()) << "exposures that were asked for are no auto exposure";
  // Frames of other exposures are tracked like others.
  EXPECT_LE(captured.summary.brackets.between, captured.summary.brackets.exposures / 10);
}

// By the poses that the device itself tells, with which the exposures' must agree exactly.
TEST(BracketCapture, PosesAreRelativeToTheView) {
  const ScratchFolder scratch;
  const auto device = OpenDevice(kUri);
  const auto again = OpenDevice(kUri);
  const Subject subject{{0, 0, 0.07}, 0.17};
  const auto poses = MakeKnownPoseSource(*device->Camera(), subject);
  const Bracketed captured = Capture(scratch / "lf", *device, *poses, 120, subject);
  ASSERT_GE(captured.light_field.views.size(), 1u);
  const View& view = captured.light_field.views.front();
  ASSERT_EQ(view.exposures.size(), 2u);
  // The same requests at the same frames give the same frames.
  again->Start();
  std::optional<Rigid3> at_view;
  std::vector<Rigid3> at_exposures;
  for (int i = 0; i < 120 && at_exposures.size() < 2; ++i) {
    const auto frame = again->Next(std::chrono::milliseconds(0));
    ASSERT_TRUE(frame);
    if (frame->asked_stops) at_exposures.push_back(*frame->known_cam_from_world);
    if (frame->device_time_s == view.device_time_s) {
      at_view = frame->known_cam_from_world;
      ASSERT_EQ(again->RequestExposures({-2, 2}), StillRequest::kAsked);
      EXPECT_EQ(again->RequestExposures({-2, 2}), StillRequest::kBusy) << "one after the other";
    }
  }
  ASSERT_TRUE(at_view);
  ASSERT_EQ(at_exposures.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const Rigid3 expected = at_exposures[i] * at_view->Inverse();
    EXPECT_LT((view.exposures[i].exposure_from_view.translation - expected.translation).norm(), 1e-9);
    EXPECT_LT(RotationAngle(view.exposures[i].exposure_from_view.rotation * expected.rotation.conjugate()),
              1e-7);
  }
}

// A camera that takes requests and sends nothing of it.
class SilentDevice : public Device {
 public:
  DeviceInfo Info() const override { return {}; }
  bool IsLive() const override { return true; }
  void Start() override {}
  std::optional<Frame> Next(std::chrono::milliseconds) override { return std::nullopt; }
  void Stop() override {}
  DeviceState State() const override { return DeviceState::kStreaming; }
  DeviceStatistics Statistics() const override { return {}; }
  ExposureRequests TakesExposures() const override { return ExposureRequests::kSetTime; }
  StillRequest RequestExposures(const std::vector<double>&) override {
    ++asked;
    return asked < 3 ? StillRequest::kBusy : StillRequest::kAsked;
  }
  int asked = 0;
};

Frame FrameAt(double time_s, std::optional<double> stops = {}) {
  Frame frame;
  frame.image = {.pixels = cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(90)), .transfer = Transfer::kLinear};
  frame.device_time_s = time_s;
  frame.exposure_s = 0.002 * std::exp2(stops.value_or(0));
  frame.asked_stops = stops;
  return frame;
}

Track TrackAt(double x) {
  Track track;
  track.state = TrackState::kTracking;
  track.cam_from_world = Rigid3{Eigen::Quaterniond::Identity(), {-x, 0, 0}};
  return track;
}

TEST(BracketCapture, LimitsWaitingAndPosesLostFrames) {
  const ScratchFolder scratch;
  const CameraModel camera = CameraModel::Pinhole(32, 24, 30);
  CaptureHeader header;
  header.camera = camera;
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", header);
  View view;
  writer.AddView(FrameAt(0), view);
  ViewSpool spool(std::move(writer), 4, false);
  SilentDevice device;
  const auto poses = MakeKnownPoseSource(camera);
  std::vector<std::string> said;
  BracketCapture bracket(device, *poses, spool, ExposureBracket::Parse("4x2EV"), {},
                         [&](const std::string& text) { said.push_back(text); });
  bracket.Begin(1, FrameAt(0), TrackAt(0));
  EXPECT_TRUE(bracket.IsRunning());
  EXPECT_TRUE(bracket.Take(FrameAt(0.1), TrackAt(0.1)));
  EXPECT_TRUE(bracket.Take(FrameAt(0.2), TrackAt(0.2)));
  EXPECT_EQ(device.asked, 3) << "a busy device is asked again, then no more";
  EXPECT_TRUE(bracket.Take(FrameAt(0.3, -2), TrackAt(0.3)));
  EXPECT_TRUE(bracket.Take(FrameAt(0.4, 2), Track{})) << "the tracker is lost in it";
  EXPECT_EQ(bracket.counts().exposures, 1u) << "it waits for a pose";
  EXPECT_TRUE(bracket.Take(FrameAt(0.6), TrackAt(0.6)));
  EXPECT_EQ(bracket.counts().exposures, 2u);
  EXPECT_TRUE(bracket.IsRunning());
  EXPECT_THAT(said, IsEmpty());
  EXPECT_TRUE(bracket.Take(FrameAt(4), TrackAt(0.6)));
  EXPECT_FALSE(bracket.IsRunning());
  EXPECT_THAT(said, ElementsAre(HasSubstr("2 of its 3 other exposures")));
  EXPECT_FALSE(bracket.Take(FrameAt(4.1), TrackAt(0.6))) << "frames may be views again";
  Frame late = FrameAt(4.2);
  late.exposure_s = 0.008;
  EXPECT_TRUE(bracket.Take(late, TrackAt(0.6))) << "but those on their way with another exposure";
  late.exposure_s = 0;
  EXPECT_TRUE(bracket.Take(late, TrackAt(0.6))) << "and those that do not tell theirs";
  late.device_time_s = 20;
  EXPECT_FALSE(bracket.Take(late, TrackAt(0.6))) << "later it is another matter";
  EXPECT_EQ(bracket.counts().incomplete, 1u);
  EXPECT_EQ(bracket.counts().between, 1u);
  spool.Finish().Close(1);
  const LightField light_field = ReadLightField(scratch / "lf");
  ASSERT_EQ(light_field.views.at(0).exposures.size(), 2u);
  const ViewExposure& lost = light_field.views[0].exposures[1];
  EXPECT_TRUE(lost.pose_is_between);
  EXPECT_NEAR(lost.exposure_from_view.translation.x(), -0.4, 1e-9) << "a third of the way from 0.3 to 0.6";
}

}  // namespace
}  // namespace ulf::test::bracket_capture_test
