// Tests: acquisition/calibration/intrinsics, core/geometry/sensor_window.
#include "acquisition/calibration/intrinsics.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/calibration/calibration_formats.h"
#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device/frame_recording.h"
#include "acquisition/opening/open_device.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::intrinsics_test {
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

TEST_F(Intrinsics, AreTakenByPrecedence) {
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

TEST_F(Intrinsics, AFocalLengthThatNoLensHasIsRefused) {
  for (const double focal_px : {5.0, 50000.0})
    EXPECT_THAT(ErrorOf(StillDevice("S1"), {.calibration_path = "", .focal_px = focal_px}, 640, 480),
                AllOf(HasSubstr("no lens"), HasSubstr("640x480")));
}

TEST_F(Intrinsics, AreStoredBySerialOfThisDeviceOnly) {
  Store("S2", 200);
  EXPECT_DOUBLE_EQ(
      ResolveIntrinsics(StillDevice("S1"), {.calibration_path = "", .focal_px = 400}, 640, 480).fx, 400);
  // A serial is a name that others gave: it cannot leave the folder.
  EXPECT_EQ(StoredCalibrationPath("../../x").parent_path(), StoredCalibrationPath("S2").parent_path());
}

TEST_F(Intrinsics, UnknownOnesSayHowToCalibrate) {
  EXPECT_THAT(ErrorOf(StillDevice("S1"), {}, 640, 480),
              AllOf(HasSubstr("test:1"), HasSubstr("calibration FILE"), HasSubstr("focal_px F"),
                    HasSubstr("S1.json")));
}

TEST_F(Intrinsics, ScaleWithTheFrameButNotToAnotherShape) {
  const StillDevice device("", WithFocal(600));
  const CameraModel half = ResolveIntrinsics(device, {}, 320, 240);
  EXPECT_EQ(half, WithFocal(600).ScaledTo(320, 240));
  EXPECT_DOUBLE_EQ(half.fx, 300);
  EXPECT_THAT(ErrorOf(device, {}, 640, 360), AllOf(HasSubstr("640x480"), HasSubstr("640x360")));
}

// A telephone's video is shown upright; the lens was found from pictures as they are stored, or the
// other way round.
TEST_F(Intrinsics, NamesALensOfPicturesBeforeRotation) {
  const StillDevice device("", WithFocal(600));
  for (const auto& [width, height] : {std::pair{480, 640}, std::pair{960, 1280}})
    EXPECT_THAT(ErrorOf(device, {}, width, height),
                AllOf(HasSubstr("made for 640x480"), HasSubstr(fmt::format("{}x{}", width, height)),
                      HasSubstr("width and height are exchanged"), HasSubstr("upright")));
  EXPECT_THAT(ErrorOf(StillDevice("S1"), {.calibration_path = WriteFile("lens.json", 600)}, 480, 640),
              AllOf(HasSubstr("lens.json"), HasSubstr("exchanged")));
  EXPECT_THAT(ErrorOf(device, {}, 480, 600), HasSubstr("another shape"));
  EXPECT_THAT(ErrorOf(device, {}, 480, 480), HasSubstr("another shape"));
}

TEST_F(Intrinsics, ABadFileIsAnErrorNotAFallback) {
  const auto path = scratch_ / "bad.json";
  std::ofstream(path) << "{";
  EXPECT_THAT(ErrorOf(StillDevice("", WithFocal(300)), {.calibration_path = path.string(), .focal_px = 400},
                      640, 480),
              HasSubstr("bad.json"));
}

// A camera that says what it is and which part of its sensor it shows.
class WindowDevice : public StillDevice {
 public:
  WindowDevice(DeviceInfo info, std::optional<SensorWindow> window)
      : StillDevice(info.serial), info_(info), window_(window) {}
  DeviceInfo Info() const override { return info_; }
  std::optional<SensorWindow> Window() const override { return window_; }

 private:
  DeviceInfo info_;
  std::optional<SensorWindow> window_;
};

DeviceInfo Webcam(const std::string& serial, const std::string& model, const std::string& bus) {
  return {
      .uri = "v4l2:/dev/video0", .maker = "", .model = model, .serial = serial, .bus = bus, .problem = ""};
}

TEST_F(Intrinsics, AnotherSerialIsAnErrorUnlessForced) {
  IntrinsicsArgs args{.calibration_path = WriteFile("named.json", 100), .focal_px = {}};
  EXPECT_THAT(ErrorOf(StillDevice("S2"), args, 640, 480),
              AllOf(HasSubstr("S1"), HasSubstr("S2"), HasSubstr("force_calibration")));
  args.force = true;
  const ResolvedCalibration forced = ResolveCalibration(StillDevice("S2"), args, 640, 480);
  EXPECT_DOUBLE_EQ(forced.camera.fx, 100);
  EXPECT_THAT(forced.warnings, ::testing::Contains(HasSubstr("force_calibration")));
  args.force = false;
  EXPECT_TRUE(ResolveCalibration(StillDevice("S1"), args, 640, 480).warnings.empty());
  EXPECT_NO_THROW(ResolveCalibration(StillDevice(""), args, 640, 480)) << "images have no serial";
}

TEST_F(Intrinsics, GoByModelAndPlaceWithoutASerial) {
  const auto path = scratch_ / "webcam.json";
  UpdateCalibration(path, CameraIdentity::Of(Webcam("", "HD Cam", "usb-1.2")), "a test", "live",
                    {.camera = WithFocal(600)});
  const IntrinsicsArgs args{.calibration_path = path.string(), .focal_px = {}};
  EXPECT_TRUE(
      ResolveCalibration(WindowDevice(Webcam("", "HD Cam", "usb-1.2"), {}), args, 640, 480).warnings.empty());
  EXPECT_THAT(ResolveCalibration(WindowDevice(Webcam("", "HD Cam", "usb-3.1"), {}), args, 640, 480).warnings,
              ::testing::ElementsAre(AllOf(HasSubstr("usb-1.2"), HasSubstr("usb-3.1"))));
  EXPECT_THAT(ErrorOf(WindowDevice(Webcam("", "Other Cam", "usb-1.2"), {}), args, 640, 480),
              AllOf(HasSubstr("HD Cam"), HasSubstr("Other Cam")));
  // Stored under model and place, and found again there.
  const CameraIdentity identity = CameraIdentity::Of(Webcam("", "HD Cam", "usb-1.2"));
  std::filesystem::create_directories(StoredCalibrationPath(identity).parent_path());
  UpdateCalibration(StoredCalibrationPath(identity), identity, "a test", "live", {.camera = WithFocal(700)});
  EXPECT_DOUBLE_EQ(
      ResolveCalibration(WindowDevice(Webcam("", "HD Cam", "usb-1.2"), {}), {}, 640, 480).camera.fx, 700);
}

// A point of the sensor is seen in every window: its image point must move as the window says.
TEST_F(Intrinsics, OtherRegionOrBinningIsRecomputed) {
  const SensorWindow whole{1280, 960, 0, 0, 1280, 960};
  CameraModel camera = CameraModel::Pinhole(1280, 960, 1100);
  camera.cx = 655.25;
  camera.cy = 470.5;
  camera.distortion = Distortion::kRadialTangential;
  camera.coefficients = {-0.1, 0.02, 1e-3, -1e-3, 0};
  const auto path = scratch_ / "windowed.json";
  UpdateCalibration(path, {.serial = "S1", .maker = {}, .model = {}, .bus = {}}, "a test", "live",
                    {.camera = camera, .window = whole});
  const IntrinsicsArgs args{.calibration_path = path.string(), .focal_px = {}};
  for (const SensorWindow& used :
       {SensorWindow{1280, 960, 200, 100, 640, 480}, SensorWindow{1280, 960, 0, 0, 1280, 960, 2, 2},
        SensorWindow{1280, 960, 320, 240, 640, 480, 2, 4}, whole}) {
    const WindowDevice device(Webcam("S1", "", ""), used);
    const CameraModel moved =
        ResolveCalibration(device, args, used.width / used.binning_x, used.height / used.binning_y).camera;
    for (const Eigen::Vector3d& point :
         {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.2, -0.1, 1), Eigen::Vector3d(-0.3, 0.25, 1)}) {
      const Eigen::Vector2d on_sensor = *camera.ImgFromCam(point), img = *moved.ImgFromCam(point);
      EXPECT_NEAR(used.x + img.x() * used.binning_x, on_sensor.x(), 1e-9);
      EXPECT_NEAR(used.y + img.y() * used.binning_y, on_sensor.y(), 1e-9);
    }
  }
  // And back: from a calibrated part to the whole.
  const SensorWindow part{1280, 960, 200, 100, 640, 480};
  UpdateCalibration(
      path, {.serial = "S1", .maker = {}, .model = {}, .bus = {}}, "a test", "live",
      {.camera = ResolveCalibration(WindowDevice(Webcam("S1", "", ""), part), args, 640, 480).camera,
       .window = part});
  EXPECT_EQ(ResolveCalibration(WindowDevice(Webcam("S1", "", ""), whole), args, 1280, 960).camera, camera);
  // Another sensor.
  EXPECT_THAT(ErrorOf(WindowDevice(Webcam("S1", "", ""), SensorWindow{1920, 1080, 0, 0, 1920, 1080}), args,
                      1920, 1080),
              HasSubstr("1920x1080"));
}

// What a camera recorded is that camera's: a calibration is bound to it, and found for it.
class RecordedIntrinsics : public Intrinsics {
 protected:
  std::unique_ptr<Device> Recording(const RecordingHeader& header, cv::Size size = {640, 480}) {
    const auto dir = scratch_ / ("recording" + std::to_string(++recordings_));
    FrameRecorder recorder(dir, header);
    Frame frame;
    frame.image.pixels = cv::Mat(size, CV_8UC1, cv::Scalar(7));
    recorder.TryAdd(frame);
    recorder.Finish();
    return OpenDevice("replay:" + dir.string());
  }
  static RecordingHeader Of(const DeviceInfo& device) {
    RecordingHeader header;
    header.device = device;
    return header;
  }
  int recordings_ = 0;
};

TEST_F(RecordedIntrinsics, AreBoundToAndFoundByTheCamera) {
  IntrinsicsArgs args{.calibration_path = WriteFile("named.json", 100), .focal_px = {}};
  const auto of_s1 = Recording(Of(Webcam("S1", "M", "b"))), of_s2 = Recording(Of(Webcam("S2", "M", "b")));
  EXPECT_DOUBLE_EQ(ResolveCalibration(*of_s1, args, 640, 480).camera.fx, 100);
  EXPECT_THAT(ErrorOf(*of_s2, args, 640, 480),
              AllOf(HasSubstr("S1"), HasSubstr("S2"), HasSubstr("force_calibration")));
  args.force = true;
  EXPECT_THAT(ResolveCalibration(*of_s2, args, 640, 480).warnings,
              ::testing::Contains(HasSubstr("force_calibration")));
  Store("S2", 200);
  EXPECT_DOUBLE_EQ(ResolveCalibration(*of_s2, {}, 640, 480).camera.fx, 200);
  EXPECT_THAT(ErrorOf(*of_s1, {}, 640, 480), HasSubstr("S1.json"));
  // Played in time it is the same camera.
  const auto in_time = OpenDevice(of_s2->Info().uri + "?speed=1");
  EXPECT_DOUBLE_EQ(ResolveCalibration(*in_time, {}, 640, 480).camera.fx, 200);
  // A webcam without a serial, by model and place.
  const CameraIdentity identity = CameraIdentity::Of(Webcam("", "HD Cam", "usb-1.2"));
  UpdateCalibration(StoredCalibrationPath(identity), identity, "a test", "live", {.camera = WithFocal(700)});
  EXPECT_DOUBLE_EQ(
      ResolveCalibration(*Recording(Of(Webcam("", "HD Cam", "usb-1.2"))), {}, 640, 480).camera.fx, 700);
}

TEST_F(RecordedIntrinsics, SessionsLensPrecedesStoredOne) {
  RecordingHeader header = Of(Webcam("S1", "M", "b"));
  header.camera = WithFocal(300);
  header.flat_field = FlatField{.width = 640, .height = 480, .powers = {{2, 0, {-0.1, -0.2, -0.3}}}};
  header.still_camera = CameraModel::Pinhole(1280, 960, 900);
  header.still_flat_field = FlatField{.width = 1280, .height = 960, .powers = {{0, 2, {-0.3, -0.2, -0.1}}}};
  const auto device = Recording(header);
  Store("S1", 200);
  const ResolvedCalibration live = ResolveCalibration(*device, {}, 640, 480);
  EXPECT_EQ(live.camera, header.camera);
  EXPECT_EQ(live.flat_field, header.flat_field);
  const ResolvedCalibration still = ResolveCalibration(*device, {}, 0, 0, "still");
  EXPECT_EQ(still.camera, header.still_camera);
  EXPECT_EQ(still.flat_field, header.still_flat_field);
}

TEST_F(RecordedIntrinsics, AreRecomputedForTheirRegion) {
  const SensorWindow whole{1280, 960, 0, 0, 1280, 960};
  const CameraIdentity s1{.serial = "S1", .maker = {}, .model = {}, .bus = {}};
  std::filesystem::create_directories(StoredCalibrationPath("S1").parent_path());
  UpdateCalibration(StoredCalibrationPath("S1"), s1, "a test", "live",
                    {.camera = CameraModel::Pinhole(1280, 960, 1100), .window = whole});
  RecordingHeader header = Of(Webcam("S1", "M", "b"));
  header.window = SensorWindow{1280, 960, 200, 100, 640, 480};
  const CameraModel camera = ResolveCalibration(*Recording(header), {}, 640, 480).camera;
  EXPECT_DOUBLE_EQ(camera.fx, 1100) << "cropped, not scaled";
  EXPECT_DOUBLE_EQ(camera.cx, 640 - 200);
}

TEST_F(RecordedIntrinsics, ImagesHaveNoKnownCamera) {
  std::filesystem::create_directories(scratch_ / "images");
  cv::imwrite((scratch_ / "images/1.png").string(), cv::Mat(480, 640, CV_8UC1, cv::Scalar(7)));
  const auto device = OpenDevice("replay:" + (scratch_ / "images").string());
  const ResolvedCalibration resolved = ResolveCalibration(
      *device, {.calibration_path = WriteFile("named.json", 100), .focal_px = {}}, 640, 480);
  EXPECT_DOUBLE_EQ(resolved.camera.fx, 100);
  EXPECT_TRUE(resolved.warnings.empty());
}

// A part of the sensor that has the calibration's shape or size is not the calibrated image made smaller.
TEST_F(Intrinsics, RefusesAnUnexplainedSize) {
  const auto unsaid = scratch_ / "unsaid.json";
  UpdateCalibration(unsaid, {.serial = "S1", .maker = {}, .model = {}, .bus = {}}, "a test", "live",
                    {.camera = WithFocal(600)});
  const IntrinsicsArgs args{.calibration_path = unsaid.string(), .focal_px = {}};
  const SensorWindow part{1280, 960, 100, 60, 320, 240}, same_size{1280, 960, 100, 60, 640, 480};
  EXPECT_THAT(ErrorOf(WindowDevice(Webcam("S1", "", ""), part), args, 320, 240),
              AllOf(HasSubstr("640x480"), HasSubstr("--roi"), HasSubstr("--sensor 1280x960")));
  // Of the same size: taken for the same part, and said.
  const ResolvedCalibration taken =
      ResolveCalibration(WindowDevice(Webcam("S1", "", ""), same_size), args, 640, 480);
  EXPECT_EQ(taken.camera, WithFocal(600));
  EXPECT_THAT(taken.warnings,
              ::testing::ElementsAre(AllOf(HasSubstr("640x480 at 100,60"), HasSubstr("--roi"))));
  // Said, a part of equal size elsewhere is recomputed, and so is its flat field.
  FlatField flat{.width = 640, .height = 480, .powers = {{1, 0, {0.1, 0.1, 0.1}}}};
  const SensorWindow calibrated{1280, 960, 0, 0, 640, 480};
  UpdateCalibration(unsaid, {.serial = "S1", .maker = {}, .model = {}, .bus = {}}, "a test", "live",
                    {.camera = WithFocal(600), .window = calibrated, .flat_field = flat});
  const ResolvedCalibration moved =
      ResolveCalibration(WindowDevice(Webcam("S1", "", ""), same_size), args, 640, 480);
  EXPECT_TRUE(moved.warnings.empty());
  EXPECT_DOUBLE_EQ(moved.camera.cx, 320 - 100);
  EXPECT_DOUBLE_EQ(moved.camera.cy, 240 - 60);
  ASSERT_TRUE(moved.flat_field);
  EXPECT_EQ(moved.flat_field->Light(640, 480).at<cv::Vec3f>(20, 30),
            flat.Light(1280, 960).at<cv::Vec3f>(60 + 20, 100 + 30));
  // Frames that are not what the camera says of itself.
  EXPECT_THAT(ErrorOf(WindowDevice(Webcam("S1", "", ""), same_size), args, 320, 240),
              AllOf(HasSubstr("320x240"), HasSubstr("640x480")));
}

TEST_F(Intrinsics, TakesAndAnnouncesAFileWithoutCamera) {
  const auto path = scratch_ / "camchain.yaml";
  WriteFileAtomically(path, CalibrationText(CalibrationFormat::kKalibr, WithFocal(600), ""));
  const IntrinsicsArgs args{.calibration_path = path.string(), .focal_px = {}};
  EXPECT_THAT(ResolveCalibration(StillDevice("S7"), args, 640, 480).warnings,
              ::testing::ElementsAre(AllOf(HasSubstr("camchain.yaml"), HasSubstr("not bound to any camera"),
                                           HasSubstr("ulf calibration"), HasSubstr("--serial 'S7'"))));
  EXPECT_TRUE(
      ResolveCalibration(WindowDevice(Webcam("S7", "", "files"), {}), args, 640, 480).warnings.empty())
      << "recorded frames come from no camera";
}

// A JPEG's head whose Exif data tell one number: the focal length of a lens with the same field of view
// on 35 mm film.
std::string ExifOfFocal35mm(char focal_mm) {
  using namespace std::string_literals;
  const std::string one_entry = "\x01\x00"s, last_directory = "\x00\x00\x00\x00"s;
  const std::string to_exif = "\x69\x87\x04\x00\x01\x00\x00\x00\x1A\x00\x00\x00"s;
  const std::string focal = "\x05\xA4\x03\x00\x01\x00\x00\x00"s + focal_mm + "\x00\x00\x00"s;
  return "\xFF\xD8\xFF\xE1\x00\x34"s + "Exif\x00\x00"s + "II*\x00\x08\x00\x00\x00"s + one_entry + to_exif +
         last_directory + one_entry + focal + last_directory + "\xFF\xD9"s;
}

TEST_F(Intrinsics, AGuessIsTheLastResortAndSaysSo) {
  Frame frame;
  frame.image.pixels = cv::Mat(480, 640, CV_8UC1, cv::Scalar(0));
  EXPECT_DOUBLE_EQ(GuessFocalPx(frame), 0.85 * 640);
  frame.encoded = EncodedImage{".jpg", std::make_shared<const std::string>(ExifOfFocal35mm(28))};
  EXPECT_NEAR(GuessFocalPx(frame), 28 / 43.267 * 800, 0.1) << "28 mm on a diagonal of 43.3 mm, 800 pixels";

  const IntrinsicsArgs guessed{.guessed_focal_px = 500};
  const ResolvedCalibration guess = ResolveCalibration(StillDevice("unknown"), guessed, 640, 480);
  EXPECT_DOUBLE_EQ(guess.camera.fx, 500);
  EXPECT_EQ(guess.source, kFocalLengthGuessed);
  EXPECT_EQ(guess.origin, LensOrigin::kGuessed);
  EXPECT_THAT(guess.warnings, ::testing::ElementsAre(HasSubstr("500 px is guessed")));
  EXPECT_DOUBLE_EQ(
      ResolveIntrinsics(StillDevice("unknown"), {.focal_px = 600, .guessed_focal_px = 500}, 640, 480).fx,
      600);
}

TEST_F(Intrinsics, AnOldFileKeepsReading) {
  const auto path = scratch_ / "old.json";
  std::ofstream(path)
      << R"({"modes": {"live": {"width": 640, "height": 480, "fx": 500, "fy": 501, "cx": 320, "cy": 240,
    "distortion": "none", "coefficients": [0,0,0,0,0], "pixel_centers": "half"}}, "serial": "S1", "source": "before"})";
  const ResolvedCalibration old =
      ResolveCalibration(StillDevice("S1"), {.calibration_path = path.string(), .focal_px = {}}, 640, 480);
  EXPECT_DOUBLE_EQ(old.camera.fy, 501);
  EXPECT_FALSE(old.flat_field);
}

TEST_F(Intrinsics, AreReadForARealSequence) {
  ULF_NEED_TEST_DATA(kitchen, "handheld_kitchen");
  const CameraModel camera = ResolveIntrinsics(
      StillDevice(""), {.calibration_path = (kitchen / "intrinsics.txt").string(), .focal_px = {}}, 640, 480);
  EXPECT_DOUBLE_EQ(camera.fx, 527.39);
  EXPECT_DOUBLE_EQ(camera.cx, 320.5) << "the file counts from integer pixel centres";
}

}  // namespace
}  // namespace ulf::intrinsics_test
