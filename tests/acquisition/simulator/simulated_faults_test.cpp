// Tests: acquisition/simulator/simulated_faults, acquisition/simulator/simulated_device.
//
// Faults that are asked for: their words, `sim:` with them, and the served camera with them.
#include "acquisition/simulator/simulated_faults.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "acquisition/aravis/aravis_device.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "acquisition/simulator/simulated_device.h"
#include "core/base/error.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"

namespace ulf::test::simulated_faults_test {
namespace {

using ::testing::HasSubstr;

constexpr char kSmall[] = "sim:wall?width=64&height=48&fps=10&noise=0";

std::vector<Frame> TakeUntilLost(Device& device, std::size_t most) {
  std::vector<Frame> frames;
  for (int tries = 0; tries < 500 && frames.size() < most && device.State() == DeviceState::kStreaming;
       ++tries)
    if (auto frame = device.Next(20ms)) frames.push_back(std::move(*frame));
  return frames;
}

// The driver itself, without what looks for lost cameras.
std::unique_ptr<Device> OpenSim(const std::string& uri) { return OpenSimulatedDevice(DeviceUri::Parse(uri)); }

double Mean(const Frame& frame) { return cv::mean(frame.image.pixels)[1]; }

TEST(SimulatedFaults, AreParsedFromText) {
  SimulatedFaults faults;
  for (const char* text :
       {"lost=0.005", "doubled=0.01", "swapped=0.02", "late=80:0.1", "freeze=5:2", "freeze=9:1",
        "disconnect=20:3", "ptp_lost=4:2", "drift=-0.5", "resend=0", "incomplete=0.25", "flicker=100:0.4",
        "defocus=3", "hunting=4:1.6", "lens=0.9", "dust=5", "auto_exposure=untold"})
    faults.Add(text);
  EXPECT_EQ(faults.link.lost, 0.005);
  EXPECT_EQ(faults.link.late_by, 80ms);
  EXPECT_EQ(faults.link.late, 0.1);
  EXPECT_FALSE(faults.resends);
  EXPECT_TRUE(faults.NeedRelay());
  EXPECT_FALSE(faults.Frozen(4.99));
  EXPECT_TRUE(faults.Frozen(5));
  EXPECT_FALSE(faults.Frozen(7));
  EXPECT_TRUE(faults.Frozen(9.5));
  EXPECT_TRUE(faults.Disconnected(22.9));
  EXPECT_FALSE(faults.MasterLost(3.9));
  EXPECT_TRUE(faults.MasterLost(5.9));
  EXPECT_DOUBLE_EQ(faults.Light(120)[1], 0.5);
  EXPECT_EQ(faults.flicker.hz, 100);
  EXPECT_EQ(faults.hunting.period_s, 1.6);
  EXPECT_EQ(faults.focal_ratio, 0.9);
  EXPECT_EQ(faults.dust_spots, 5);
  EXPECT_EQ(faults.auto_exposure, AutoExposure::kUntold);
  for (const char* wrong :
       {"", "lost", "lost=", "lost=2", "lost=-1", "lost=nan", "late=80", "freeze=a:1",
        "freeze=1:", "resend=2", "gone=1", "=1", "flicker=100", "hunting=4:0", "lens=0", "auto_exposure=1"})
    EXPECT_THROW(SimulatedFaults().Add(wrong), Refusal) << wrong;
}

TEST(SimDevice, KnowsItsWindow) {
  const auto window = OpenSim(kSmall)->Window();
  ASSERT_TRUE(window);
  EXPECT_EQ(window->sensor_width, 64);
  EXPECT_EQ(window->height, 48);
}

TEST(SimDevice, IsLostAndComesBackLater) {
  const std::string uri = std::string(kSmall) + "&seed=11&fault=disconnect=1:0.5";
  auto device = OpenSim(uri);
  device->Start();
  const auto before = TakeUntilLost(*device, 100);
  ASSERT_EQ(before.size(), 10u);
  EXPECT_EQ(device->State(), DeviceState::kLost);
  EXPECT_THAT(device->Info().problem, HasSubstr("cable"));
  device.reset();
  EXPECT_THAT([&] { OpenSim(uri); }, testing::ThrowsMessage<Error>(HasSubstr("plugged in again in")))
      << "the cable is out";
  EXPECT_NO_THROW(OpenSim(kSmall)) << "another camera";
  const auto begin = Clock::now();
  while (!device && SecondsSince(begin) < 5) {
    try {
      device = OpenSim(uri);
    } catch (const Error&) {
      std::this_thread::sleep_for(20ms);
    }
  }
  ASSERT_TRUE(device);
  device->Start();
  const auto after = TakeUntilLost(*device, 5);
  ASSERT_EQ(after.size(), 5u);
  EXPECT_EQ(after.front().id, 15u) << "half a second at 10 fps has passed by";
  EXPECT_EQ(after.front().known_cam_from_world->Matrix(), [&] {
    const auto whole = OpenSim(std::string(kSmall) + "&seed=11");
    whole->Start();
    return TakeUntilLost(*whole, 16).back().known_cam_from_world->Matrix();
  }());
}

TEST(SimDevice, FreezesForAWhile) {
  const auto device = OpenSim(std::string(kSmall) + "&fault=freeze=0.5:0.3");
  device->Start();
  std::vector<Frame> frames;
  for (int i = 0; i < 5; ++i) frames.push_back(*device->Next(0ms));
  const auto begin = Clock::now();
  EXPECT_FALSE(device->Next(50ms));
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
  EXPECT_GT(SecondsSince(begin), 0.04);
  const auto next = device->Next(5s);
  ASSERT_TRUE(next);
  EXPECT_GT(SecondsSince(begin), 0.28);
  EXPECT_EQ(next->id, 8u);
  EXPECT_EQ(device->Statistics().missing, 3u);
}

TEST(SimDevice, SomeFramesComeIncompleteTheSameEveryTime) {
  const std::string uri = std::string(kSmall) + "&fault=incomplete=0.2";
  const auto outcome = [&](const std::string& from) {
    const auto device = OpenSim(from);
    device->Start();
    std::vector<bool> complete;
    for (const Frame& frame : TakeUntilLost(*device, 100))
      complete.push_back(frame.status == FrameStatus::kComplete);
    EXPECT_EQ(device->Statistics().delivered,
              static_cast<std::size_t>(std::count(complete.begin(), complete.end(), true)));
    return complete;
  };
  const auto once = outcome(uri);
  EXPECT_EQ(once, outcome(uri));
  EXPECT_NE(once, outcome(uri + "&seed=8"));
  const auto bad = std::count(once.begin(), once.end(), false);
  EXPECT_GT(bad, 8);
  EXPECT_LT(bad, 36);
}

TEST(SimDevice, TheLightDrifts) {
  const auto mean_at_a_second = [](const std::string& fault) {
    const auto device = OpenSim(kSmall + fault);
    device->Start();
    const Frame frame = TakeUntilLost(*device, 11).back();
    EXPECT_EQ(frame.exposure_s, 0.005) << "not reported";
    return Mean(frame);
  };
  const double usual = mean_at_a_second("&exposure_us=5000");
  EXPECT_NEAR(mean_at_a_second("&exposure_us=5000&fault=drift=-30") / usual, std::exp2(-0.5), 0.03);
}

TEST(SimDevice, RefusesFaultsOfANetwork) {
  EXPECT_THAT([&] { OpenSim(std::string(kSmall) + "&fault=lost=0.1"); },
              testing::ThrowsMessage<Refusal>(HasSubstr("ulf simulate --fault")));
}

class FaultyGigeCamera : public CameraInNamespace {
 protected:
  static GigeServerOptions With(std::initializer_list<const char*> faults) {
    GigeServerOptions options;
    options.simulation = SimulationOptions::FromUri(DeviceUri::Parse(kSmall));
    options.simulation.width = 320;
    options.simulation.height = 240;
    options.simulation.fps = 20;
    for (const char* fault : faults) options.simulation.faults.Add(fault);
    return options;
  }
};

TEST_F(FaultyGigeCamera, FreezesAndGoesOn) {
  const SimulatedGigeCamera server(With({"freeze=1:1.2"}));
  const auto device = OpenDevice("aravis:127.0.0.1?format=Mono8");
  device->Start();
  double longest_s = 0, last_s = 0;
  for (const Frame& frame : Take(*device, 45)) {
    if (last_s > 0) longest_s = std::max(longest_s, frame.device_time_s - last_s);
    last_s = frame.device_time_s;
  }
  EXPECT_GT(longest_s, 1.1) << "a gap in the frames' own times";
  EXPECT_LT(longest_s, 2.5);
  EXPECT_GE(device->Statistics().missing, 10u) << "the camera went on taking frames that nobody saw";
}

TEST_F(FaultyGigeCamera, IsFoundAtItsPublicAddressOnly) {
  SimulatedGigeCamera server(With({"freeze=0:0"}));
  ASSERT_TRUE(server.relay());
  std::vector<std::string> found;
  for (const DeviceInfo& info : ListDevices())
    if (info.bus == "GigEVision") found.push_back(info.uri);
  EXPECT_THAT(found, ::testing::ElementsAre("aravis:127.0.0.1"));
  const auto device = OpenDevice("aravis:ULF-SIM-1?format=Mono8");
  device->Start();
  Take(*device, 5);
}

TEST_F(FaultyGigeCamera, ReopensAfterADisconnect) {
  // Longer than the camera's heartbeat of three seconds: it has forgotten who controlled it.
  const SimulatedGigeCamera server(With({"disconnect=0.5:4"}));
  const DeviceUri uri = DeviceUri::Parse("aravis:127.0.0.1?format=Mono8");
  auto device = OpenAravisDevice(uri);
  device->Start();
  const auto begin = Clock::now();
  while (device->Next(300ms)) continue;
  device->Stop();
  device.reset();
  while (!device && SecondsSince(begin) < 20) {
    try {
      device = OpenAravisDevice(uri);
    } catch (const Error&) {
    }
  }
  ASSERT_TRUE(device);
  EXPECT_GT(SecondsSince(begin), 3.5);
  device->Start();
  EXPECT_EQ(Take(*device, 5).size(), 5u);
}

TEST_F(FaultyGigeCamera, TheLightDrifts) {
  const SimulatedGigeCamera server(With({"drift=40"}));
  const auto device = OpenDevice("aravis:127.0.0.1?format=Mono8&exposure_us=1000");
  device->Start();
  const auto frames = Take(*device, 40);
  ASSERT_EQ(frames.size(), 40u);
  // Two thirds of a stop a second.
  const double seconds = frames.back().device_time_s - frames.front().device_time_s;
  const double stops =
      std::log2(cv::mean(frames.back().image.pixels)[0] / cv::mean(frames.front().image.pixels)[0]);
  EXPECT_NEAR(stops / seconds, 40 / 60.0, 0.25) << "the wall seen changes a little as well";
}

}  // namespace
}  // namespace ulf::test::simulated_faults_test
