// Tests: acquisition/simulator/gige/gige_relay, acquisition/simulator/gige/gige_address.
//
// The relay that simulates a bad link: before it the client that everything else uses, behind it a camera in
// a process of its own. Values are checked pixel by pixel: a packet sent again must land where it belongs.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/gige/gige_address.h"
#include "acquisition/simulator/gige/gige_relay.h"
#include "core/base/error.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"

namespace ulf::test::gige_relay_test {
namespace {

using ::testing::HasSubstr;

constexpr char kPublic[] = "127.0.0.5",
               kUri[] = "aravis:127.0.0.5?format=Mono8&packet_size=1400&fps=20&roi=640x480+0+0";

class GigeRelayed : public CameraInNamespace {
 protected:
  void SetUp() override {
    CameraInNamespace::SetUp();
    if (!IsSkipped()) StartCamera();
  }
  static GigeRelayOptions Behind(const GigeLinkFaults& faults, bool resends = true) {
    return {.camera = "127.0.0.1", .address = kPublic, .faults = faults, .resends = resends, .seed = 3};
  }
};

// Empty: nobody answers.
std::string SerialAt(const std::string& address, std::chrono::milliseconds timeout) {
  const auto camera = QueryGigeCamera(address, timeout);
  return camera ? camera->serial : "";
}

int WrongPixels(const Frame& frame) {
  int wrong = 0;
  for (int y = 0; y < frame.image.height(); ++y)
    for (int x = 0; x < frame.image.width(); ++x)
      wrong += frame.image.pixels.at<std::uint8_t>(y, x) != static_cast<std::uint8_t>(3 * x + 5 * y);
  return wrong;
}

int Incomplete(const std::vector<Frame>& frames) {
  return static_cast<int>(std::count_if(frames.begin(), frames.end(), [](const Frame& frame) {
    return frame.status == FrameStatus::kIncomplete;
  }));
}

TEST_F(GigeRelayed, AGoodLinkChangesNothing) {
  const GigeRelay relay(Behind({}));
  const auto device = OpenDevice(kUri);
  device->Start();
  const auto frames = Take(*device, 20);
  device->Stop();
  EXPECT_EQ(Incomplete(frames), 0);
  for (const Frame& frame : frames) EXPECT_EQ(WrongPixels(frame), 0) << frame.id;
  EXPECT_GE(relay.Statistics().frames, 20u);
  EXPECT_EQ(relay.Statistics().lost, 0u);
}

TEST_F(GigeRelayed, LostDoubledAndSwappedPacketsAreMended) {
  const GigeRelay relay(Behind({.lost = 0.01, .doubled = 0.02, .swapped = 0.02}));
  const auto device = OpenDevice(kUri);
  device->Start();
  const auto frames = Take(*device, 40);
  device->Stop();
  const GigeRelayStatistics link = relay.Statistics();
  EXPECT_GT(link.lost, 20u);
  EXPECT_GT(link.doubled, 20u);
  EXPECT_GT(link.swapped, 20u);
  EXPECT_GT(link.resent, 20u);
  EXPECT_LE(Incomplete(frames), 1) << link.lost << " packets lost, " << link.resent << " sent again";
  for (const Frame& frame : frames) {
    if (frame.status != FrameStatus::kComplete) continue;
    EXPECT_EQ(WrongPixels(frame), 0) << frame.id;
  }
}

TEST_F(GigeRelayed, WithoutResendsFramesStayIncomplete) {
  const GigeRelay relay(Behind({.lost = 0.01}, false));
  const auto device = OpenDevice(kUri);
  device->Start();
  const auto frames = Take(*device, 20);
  device->Stop();
  EXPECT_EQ(relay.Statistics().resent, 0u);
  EXPECT_GT(Incomplete(frames), 5);
}

TEST_F(GigeRelayed, TheSamePacketsAreLostForTheSameSeed) {
  const auto lost = [&](std::uint64_t seed) {
    camera_.reset();
    StartCamera();
    GigeRelayOptions options = Behind({.lost = 0.002}, false);  // a third of the frames
    options.seed = seed;
    const GigeRelay relay(options);
    const auto device = OpenDevice(kUri);
    device->Start();
    std::map<std::uint64_t, FrameStatus> outcome;
    for (const Frame& frame : Take(*device, 24)) outcome[frame.id] = frame.status;
    device->Stop();
    return outcome;
  };
  const auto once = lost(3), again = lost(3), other = lost(4);
  int common = 0, differs = 0;
  for (const auto& [id, status] : once) {
    if (const auto same = again.find(id); same != again.end()) {
      ++common;
      EXPECT_EQ(same->second, status) << id;
    }
    if (const auto different = other.find(id); different != other.end())
      differs += different->second != status;
  }
  EXPECT_GT(common, 15);
  EXPECT_GT(differs, 0);
}

TEST_F(GigeRelayed, LateFramesComeWholeAndInOrder) {
  const GigeRelay relay(Behind({.late = 0.3, .late_by = 80ms}));
  const auto device = OpenDevice(kUri);
  device->Start();
  const auto frames = Take(*device, 30);
  device->Stop();
  EXPECT_GT(relay.Statistics().late_frames, 3u);
  EXPECT_EQ(Incomplete(frames), 0);
  int late = 0;
  for (const Frame& frame : frames) late += frame.host_time_s - frame.device_time_s > 0.07;
  EXPECT_GT(late, 3);
  for (std::size_t i = 1; i < frames.size(); ++i)
    EXPECT_GT(frames[i].device_time_s, frames[i - 1].device_time_s);
}

TEST_F(GigeRelayed, APulledCableIsSilentUntilItIsPutBack) {
  GigeRelay relay(Behind({}));
  const auto device = OpenDevice(kUri);
  device->Start();
  Take(*device, 3);
  EXPECT_EQ(SerialAt(kPublic, 500ms), "T1");
  relay.Pull();
  EXPECT_EQ(SerialAt(kPublic, 300ms), "");
  while (device->Next(100ms)) continue;  // what was under way
  EXPECT_FALSE(device->Next(400ms));
  relay.PutBack();
  EXPECT_EQ(SerialAt(kPublic, 500ms), "T1");
  EXPECT_LE(Incomplete(Take(*device, 5)), 2)
      << "away for less than the heartbeat: the stream goes on, but for frames cut in two";
  relay.PassStream(false);
  while (device->Next(100ms)) continue;
  EXPECT_EQ(SerialAt(kPublic, 500ms), "T1") << "control goes on";
  relay.PassStream(true);
  Take(*device, 3);
}

TEST_F(GigeRelayed, TheCameraTellsClientsApart) {
  const GigeRelay relay(Behind({}));
  const auto device = OpenDevice(kUri);
  EXPECT_THROW(OpenDevice(kUri), Error) << "controlled by the first";
}

TEST_F(GigeRelayed, AddressesAreAddedAndRemoved) {
  EXPECT_EQ(HiddenGigeAddress("127.0.0.2"), "127.64.0.2");
  EXPECT_THROW(HiddenGigeAddress("10.0.0.2"), Refusal);
  EXPECT_THROW(HiddenGigeAddress("127.64.0.2"), Refusal);
  const auto serves = [](const std::string& address) {
    ChildProcess camera({FAKE_GIGE_CAMERA, "T2", "0", address});
    return camera.ReadUntil("ready", 5).find("ready") != std::string::npos;
  };
  EXPECT_FALSE(serves("127.0.0.9"));
  {
    const LoopbackAddress address("127.0.0.9"), before("127.0.0.1");
    EXPECT_TRUE(serves("127.0.0.9"));
  }
  EXPECT_FALSE(serves("127.0.0.9"));
  EXPECT_EQ(SerialAt("127.0.0.1", 500ms), "T1") << "an address that was there stays";
  EXPECT_THAT([&] { const GigeRelay taken({.camera = "127.0.0.1", .address = "127.0.0.1", .faults = {}}); },
              testing::ThrowsMessage<Error>(HasSubstr("serial 'T1'")))
      << "taken by the camera";
}

}  // namespace
}  // namespace ulf::test::gige_relay_test
