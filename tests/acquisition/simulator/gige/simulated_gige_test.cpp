// Tests: acquisition/simulator/gige/simulated_gige_camera, acquisition/simulator/gige/gige_pictures,
// commands/camera/simulate_command.
//
// The whole way from the simulated sensor to an ulf::Frame over the network: `ulf simulate` in a process of
// its own, opened as the machine-vision camera that it is.
#include <gmock/gmock.h>
#include <signal.h>

#include <cstdlib>
#include <opencv2/core.hpp>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::simulated_gige_test {
namespace {

using ::testing::HasSubstr;

class SimulatedGige : public CameraInNamespace {
 protected:
  void SetUp() override {
    CameraInNamespace::SetUp();
    if (IsSkipped()) return;
    const char* binary = std::getenv("ULF_BINARY");
    ASSERT_TRUE(binary) << "ULF_BINARY is not set: run through ctest";
    camera_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{binary, "simulate", "wall", "--options", "width=320&height=240", "--fps",
                                 "20", "--calibration-out", (scratch_ / "sim.json").string()});
    ASSERT_THAT(camera_->ReadUntil("serving", 60), HasSubstr("serving"));
  }

  // The mean light of some frames, 1 at full scale.
  double MeanLight(const std::string& options, FrameStatus* status = nullptr, Frame* last = nullptr) {
    const auto device = OpenDevice("aravis:127.0.0.1?" + options);
    device->Start();
    double sum = 0;
    const auto frames = Take(*device, 5);
    for (const Frame& frame : frames) {
      const cv::Scalar mean = cv::mean(LinearFloat(frame.image));
      sum += (mean[0] + mean[1] + mean[2]) / 3;
      if (status && frame.status != FrameStatus::kComplete) *status = frame.status;
    }
    if (last && !frames.empty()) *last = frames.back();
    return sum / static_cast<double>(std::max<std::size_t>(1, frames.size()));
  }

  ScratchFolder scratch_;
};

TEST_F(SimulatedGige, ExposureAndGainActAndAreInTheFrame) {
  FrameStatus status = FrameStatus::kComplete;
  Frame frame;
  const double light = MeanLight("format=BayerRG8&exposure_us=2000&gain_db=0", &status, &frame);
  EXPECT_EQ(status, FrameStatus::kComplete);
  EXPECT_DOUBLE_EQ(frame.exposure_s, 0.002);
  EXPECT_DOUBLE_EQ(frame.gain, 1);
  EXPECT_EQ(frame.image.mosaic, Mosaic::kRggb);
  EXPECT_GT(light, 0.01) << "not a black picture";

  const double longer = MeanLight("format=BayerRG8&exposure_us=4000&gain_db=0", nullptr, &frame);
  EXPECT_DOUBLE_EQ(frame.exposure_s, 0.004);
  EXPECT_NEAR(longer / light, 2, 0.3);  // the hand moves on between the two

  const double amplified = MeanLight("format=BayerRG8&exposure_us=2000&gain_db=6", nullptr, &frame);
  EXPECT_NEAR(frame.gain, 1.9953, 1e-3);
  EXPECT_NEAR(amplified / light, frame.gain, 0.3);
}

TEST_F(SimulatedGige, FormatsShowTheSamePicture) {
  Frame bayer, rgb, mono;
  MeanLight("format=BayerRG8&exposure_us=3000", nullptr, &bayer);
  MeanLight("format=RGB8&exposure_us=3000", nullptr, &rgb);
  MeanLight("format=Mono8&exposure_us=3000", nullptr, &mono);
  const cv::Scalar from_bayer = cv::mean(LinearFloat(bayer.image)),
                   from_rgb = cv::mean(LinearFloat(rgb.image)), from_mono = cv::mean(LinearFloat(mono.image));
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_NEAR(from_bayer[channel], from_rgb[channel], 0.15 * from_rgb[channel])
        << "B, G, R channel " << channel;
  EXPECT_NEAR(from_mono[1], from_rgb[1], 0.3 * from_rgb[1]);
}

TEST_F(SimulatedGige, ItsCalibrationFitsItsFrames) {
  const auto device = OpenDevice("aravis:127.0.0.1");
  device->Start();
  const auto frames = Take(*device, 1);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_NE(frames[0].image.mosaic, Mosaic::kNone) << "raw colour where it is offered";
  std::string source;
  const CameraModel camera =
      ResolveIntrinsics(*device, {.calibration_path = (scratch_ / "sim.json").string(), .focal_px = {}},
                        frames[0].image.width(), frames[0].image.height(), &source);
  EXPECT_EQ(camera.width, 320);
  EXPECT_THAT(source, HasSubstr("sim.json"));
}

TEST_F(SimulatedGige, EndsOnItsSignalAndTheClientLetsGo) {
  auto device = OpenDevice("aravis:127.0.0.1");
  device->Start();
  Take(*device, 3);
  camera_->Signal(SIGTERM);
  EXPECT_EQ(camera_->Wait(10), 0);
  const auto start = Clock::now();
  device->Stop();
  EXPECT_EQ(device->State(), DeviceState::kConnected);
  device.reset();
  EXPECT_LT(SecondsSince(start), 3);
}

}  // namespace
}  // namespace ulf::test::simulated_gige_test
