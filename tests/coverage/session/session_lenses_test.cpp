// Tests: coverage/session/session_lenses.
//
// Under which lens a session goes on with a light field: the one that it has, or another that was named.
#include "coverage/session/session_lenses.h"

#include <gmock/gmock.h>

#include "acquisition/calibration/calibration_io.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::session_lenses_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

CameraModel LensOf(double focal_px) { return CameraModel::Pinhole(64, 48, focal_px); }

class CameraOfLens : public Device {
 public:
  DeviceInfo Info() const override {
    DeviceInfo info;
    info.uri = "test:camera";
    return info;
  }
  bool IsLive() const override { return true; }
  bool TakesStills() const override { return still_.has_value(); }
  std::optional<CameraModel> Camera() const override { return own_; }
  std::optional<CameraModel> StillCamera() const override { return still_; }
  std::optional<SensorWindow> Window() const override { return window_; }
  void Start() override {}
  std::optional<Frame> Next(std::chrono::milliseconds /*timeout*/) override { return std::nullopt; }
  void Stop() override {}
  DeviceState State() const override { return DeviceState::kConnected; }
  DeviceStatistics Statistics() const override { return {}; }

  std::optional<CameraModel> own_, still_;
  std::optional<SensorWindow> window_;
};

class ResumedLens : public ::testing::Test {
 protected:
  ResumedLens() {
    first_.image.pixels = cv::Mat(48, 64, CV_8UC3, cv::Scalar(10, 20, 30));
    CaptureHeader header;
    header.camera = LensOf(50);
    header.flat_field = flat_field_;
    header.window = window_;
    header.calibration_source = "file lens.json";
    LightFieldWriter writer = LightFieldWriter::Create(scratch_ / "lf", header);
    writer.AddView(first_, {});
    Calibration("same.json", LensOf(50));
    Calibration("better.json", LensOf(51.5));
  }
  void Calibration(const std::string& name, const CameraModel& camera) {
    WriteCalibration((scratch_ / name).string(), camera, "", "test");
  }
  SessionLenses Choose(LightFieldWriter* writer, const IntrinsicsArgs& args) {
    return ChooseLenses(device_, first_, args, args, writer);
  }
  IntrinsicsArgs File(const std::string& name) const {
    return {.calibration_path = (scratch_ / name).string()};
  }
  LightFieldWriter Resume() const { return LightFieldWriter::Resume(scratch_ / "lf"); }

  const FlatField flat_field_{.width = 64, .height = 48, .powers = {{2, 0, {-0.1, -0.1, -0.1}}}};
  const ScratchFolder scratch_;
  const SensorWindow window_{128, 96, 0, 0, 64, 48};
  CameraOfLens device_;
  Frame first_;
};

TEST_F(ResumedLens, WithoutANameIsThePresentOne) {
  LightFieldWriter writer = Resume();
  device_.own_ = LensOf(60);
  const SessionLenses lenses = Choose(&writer, {});
  EXPECT_EQ(lenses.live.camera, LensOf(50));
  EXPECT_EQ(lenses.recorded.flat_field, flat_field_);
  EXPECT_EQ(lenses.recorded.calibration_source, "file lens.json");
  EXPECT_FALSE(lenses.is_new);
}

TEST_F(ResumedLens, WithTheSameNumbersAddsNothing) {
  LightFieldWriter writer = Resume();
  const SessionLenses lenses = Choose(&writer, File("same.json"));
  EXPECT_FALSE(lenses.is_new);
  EXPECT_TRUE(lenses.recorded.flat_field) << "of which the file says nothing";
}

TEST_F(ResumedLens, WithOtherNumbersIsASecondCamera) {
  LightFieldWriter writer = Resume();
  const SessionLenses lenses = Choose(&writer, File("better.json"));
  ASSERT_TRUE(lenses.is_new);
  EXPECT_EQ(lenses.live.camera, LensOf(51.5));
  EXPECT_EQ(lenses.recorded.camera, LensOf(51.5));
  EXPECT_EQ(writer.Contents().cameras.size(), 1u) << "nothing is written yet";
  AddCameraInUse(lenses.recorded, writer);
  EXPECT_EQ(writer.AddView(first_, {}).camera, 1);
  EXPECT_FALSE(Choose(&writer, File("better.json")).is_new) << "the same again";
  EXPECT_TRUE(Choose(&writer, File("same.json")).is_new) << "back to the first one";
  EXPECT_TRUE(Choose(&writer, {.focal_px = 55}).is_new);
}

TEST_F(ResumedLens, ReadsAFileAlthoughItIsKnown) {
  LightFieldWriter writer = Resume();
  EXPECT_THAT([&] { Choose(&writer, File("none.json")); }, ThrowsMessage<Error>(HasSubstr("none.json")));
  WriteFileAtomically(scratch_ / "broken.json", "{\"fx\":");
  EXPECT_THAT([&] { Choose(&writer, File("broken.json")); }, ThrowsMessage<Error>(HasSubstr("broken.json")));
}

TEST_F(ResumedLens, RefusesAFocalLengthThatIsNotUsed) {
  LightFieldWriter writer = Resume();
  device_.own_ = LensOf(60);
  EXPECT_THAT([&] { Choose(&writer, {.focal_px = 55}); },
              ThrowsMessage<Refusal>(AllOf(HasSubstr("focal_px 55"), HasSubstr("leave it out"))));
  IntrinsicsArgs both = File("better.json");
  both.focal_px = 55;
  EXPECT_THAT([&] { Choose(&writer, both); }, ThrowsMessage<Refusal>(HasSubstr("focal_px 55")));
}

// `ulf refine --intrinsics` found a better one than the file that the capture was begun with.
TEST_F(ResumedLens, AFileOfALensCorrectedSinceAddsNothing) {
  {
    LightFieldWriter writer = Resume();
    writer.UpdatePoses({}, {{0, {LensOf(50.7), ""}}});
  }
  LightFieldWriter writer = Resume();
  const SessionLenses lenses = Choose(&writer, File("same.json"));
  EXPECT_FALSE(lenses.is_new);
  EXPECT_EQ(lenses.live.camera, LensOf(50.7));
  EXPECT_TRUE(Choose(&writer, File("better.json")).is_new);
}

TEST_F(ResumedLens, ForPhotographsIsTheFilesStillCamera) {
  LightFieldWriter writer = Resume();
  device_.own_ = LensOf(60);
  device_.still_ = LensOf(70);
  SessionLenses lenses = Choose(&writer, {});
  EXPECT_EQ(lenses.live.camera, LensOf(60));
  EXPECT_EQ(lenses.recorded.camera, LensOf(50));
  EXPECT_FALSE(lenses.is_new);
  UpdateCalibration((scratch_ / "better.json").string(), CameraIdentity::Of(device_.Info()), "test", "still",
                    {.camera = LensOf(52)});
  lenses = Choose(&writer, File("better.json"));
  EXPECT_EQ(lenses.live.camera, LensOf(51.5));
  EXPECT_EQ(lenses.recorded.camera, LensOf(52));
  EXPECT_TRUE(lenses.is_new);
}

TEST_F(ResumedLens, RefusesPicturesOfAnotherSizeOrPlace) {
  LightFieldWriter writer = Resume();
  device_.window_ = window_;
  EXPECT_NO_THROW(Choose(&writer, {}));
  device_.window_->x = 32;
  EXPECT_THAT([&] { Choose(&writer, {}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("64x48 at 32,0"), HasSubstr("set it back"))));
  device_.window_.reset();
  first_.image.pixels = cv::Mat(96, 128, CV_8UC3, cv::Scalar(10, 20, 30));
  for (const IntrinsicsArgs& args : {IntrinsicsArgs{}, File("better.json")})
    EXPECT_THAT([&] { Choose(&writer, args); },
                ThrowsMessage<Error>(AllOf(HasSubstr("64x48"), HasSubstr("128x96"))));
}

}  // namespace
}  // namespace ulf::test::session_lenses_test
