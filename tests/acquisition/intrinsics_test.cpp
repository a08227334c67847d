#include "acquisition/calibration/intrinsics.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/error.h"
#include "tests/support/test_paths.h"

namespace ulf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class StillDevice : public Device {
 public:
  explicit StillDevice(std::string serial, std::optional<CameraModel> own = {})
      : serial_(std::move(serial)), own_(own) {}
  DeviceInfo Info() const override {
    return {.uri = "test:1", .maker = "", .model = "", .serial = serial_, .bus = "", .problem = ""};
  }
  std::optional<CameraModel> Camera() const override { return own_; }
  bool IsLive() const override { return false; }
  void Start() override {}
  std::optional<Frame> Next(std::chrono::milliseconds) override { return std::nullopt; }
  void Stop() override {}
  DeviceState State() const override { return DeviceState::kEnded; }
  DeviceStatistics Statistics() const override { return {}; }

 private:
  std::string serial_;
  std::optional<CameraModel> own_;
};

// A user's configuration folder of this test's own.
class Intrinsics : public ::testing::Test {
 protected:
  Intrinsics() { setenv("XDG_CONFIG_HOME", scratch_.path().c_str(), 1); }
  ~Intrinsics() override { unsetenv("XDG_CONFIG_HOME"); }

  CameraModel WithFocal(double focal_px) { return CameraModel::Pinhole(640, 480, focal_px); }
  std::string WriteFile(const std::string& name, double focal_px) {
    const auto path = scratch_ / name;
    std::filesystem::create_directories(path.parent_path());
    WriteCalibration(path, WithFocal(focal_px), "S1", "a test");
    return path.string();
  }
  void Store(const std::string& serial, double focal_px) {
    std::filesystem::create_directories(StoredCalibrationPath(serial).parent_path());
    WriteCalibration(StoredCalibrationPath(serial), WithFocal(focal_px), serial, "a test");
  }
  static std::string ErrorOf(const Device& device, const IntrinsicsArgs& args, int width, int height) {
    try {
      ResolveIntrinsics(device, args, width, height);
    } catch (const Error& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  test::ScratchFolder scratch_;
};

TEST_F(Intrinsics, AreTakenInOrder) {
  const StillDevice device("S1", WithFocal(300));
  IntrinsicsArgs args{.calibration_path = WriteFile("named.json", 100), .focal_px = 400};
  Store("S1", 200);
  std::string source;
  EXPECT_DOUBLE_EQ(ResolveIntrinsics(device, args, 640, 480, &source).fx, 100);
  EXPECT_THAT(source, HasSubstr("named.json"));
  args.calibration_path.clear();
  EXPECT_DOUBLE_EQ(ResolveIntrinsics(device, args, 640, 480, &source).fx, 200);
  EXPECT_THAT(source, HasSubstr("S1"));
  std::filesystem::remove(StoredCalibrationPath("S1"));
  EXPECT_DOUBLE_EQ(ResolveIntrinsics(device, args, 640, 480, &source).fx, 300);
  EXPECT_THAT(source, HasSubstr("test:1"));
  const CameraModel from_focal = ResolveIntrinsics(StillDevice("S1"), args, 640, 480, &source);
  EXPECT_EQ(from_focal, WithFocal(400));
  EXPECT_THAT(source, HasSubstr("focal"));
}

TEST_F(Intrinsics, AreStoredBySerialOfThisDeviceOnly) {
  Store("S2", 200);
  EXPECT_DOUBLE_EQ(
      ResolveIntrinsics(StillDevice("S1"), {.calibration_path = "", .focal_px = 400}, 640, 480).fx, 400);
  // A serial is a name that others gave: it cannot leave the folder.
  EXPECT_EQ(StoredCalibrationPath("../../x").parent_path(), StoredCalibrationPath("S2").parent_path());
}

TEST_F(Intrinsics, UnknownOnesSayHowToCalibrate) {
  EXPECT_THAT(ErrorOf(StillDevice("S1"), {}, 640, 480), AllOf(HasSubstr("test:1"), HasSubstr("--calibration"),
                                                              HasSubstr("--focal-px"), HasSubstr("S1.json")));
}

TEST_F(Intrinsics, ScaleWithTheFrameButNotToAnotherShape) {
  const StillDevice device("", WithFocal(600));
  const CameraModel half = ResolveIntrinsics(device, {}, 320, 240);
  EXPECT_EQ(half, WithFocal(600).ScaledTo(320, 240));
  EXPECT_DOUBLE_EQ(half.fx, 300);
  EXPECT_THAT(ErrorOf(device, {}, 640, 360), AllOf(HasSubstr("640x480"), HasSubstr("640x360")));
}

TEST_F(Intrinsics, ABadFileIsAnErrorNotAFallback) {
  const auto path = scratch_ / "bad.json";
  std::ofstream(path) << "{";
  EXPECT_THAT(ErrorOf(StillDevice("", WithFocal(300)), {.calibration_path = path.string(), .focal_px = 400},
                      640, 480),
              HasSubstr("bad.json"));
}

TEST_F(Intrinsics, OfARealSequence) {
  ULF_NEED_TEST_DATA(kitchen, "handheld_kitchen");
  const CameraModel camera = ResolveIntrinsics(
      StillDevice(""), {.calibration_path = (kitchen / "intrinsics.txt").string(), .focal_px = {}}, 640, 480);
  EXPECT_DOUBLE_EQ(camera.fx, 527.39);
  EXPECT_DOUBLE_EQ(camera.cx, 320.5) << "the file counts from integer pixel centres";
}

}  // namespace
}  // namespace ulf
