// Tests: acquisition/aravis/aravis_automatics.
//
// What a camera changes by itself: full_camera.xml's automatics move their values while they run, and give
// back the ones set by hand when they are off.
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <thread>

#include "acquisition/device/features.h"
#include "acquisition/opening/open_device.h"
#include "core/base/atomic_file.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::aravis_automatics_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kCamera = "aravis:127.0.0.1";
constexpr const char* kUri = "aravis:127.0.0.1?format=Mono8&roi=64x64+0+0&fps=50&settle=0.5";
constexpr const char* kAutomatics[] = {"ExposureAuto", "GainAuto", "BlackLevelAuto", "BalanceWhiteAuto"};

// Opening takes seconds: once for all of them.
std::map<std::string, std::string> Values() {
  std::map<std::string, std::string> values;
  const auto access = OpenFeatures(kCamera);
  for (const char* name : {"ExposureAuto", "GainAuto", "BlackLevelAuto", "BalanceWhiteAuto", "ExposureTime",
                           "Gain", "GainRaw", "BlackLevel", "BalanceRatio"})
    if (const auto feature = access->Find(name)) values[name] = feature->value;
  return values;
}

double TransportOf(const Device& device, TransportFigure figure) {
  if (const auto value = FigureIn(device.Statistics().transport, figure)) return *value;
  ADD_FAILURE() << "no " << Name(figure);
  return -1;
}

std::vector<std::string> Said(Device& device) {
  std::vector<std::string> texts;
  for (const DeviceEvent& event : device.TakeEvents())
    if (event.kind == DeviceEventKind::kNotice) texts.push_back(event.text);
  return texts;
}

class AravisAutomatics : public CameraInNamespace {
 protected:
  // As the last program may have left it.
  static void LeaveOn() {
    const auto access = OpenFeatures(kCamera);
    for (const char* automatic : kAutomatics) access->Set(automatic, "Off");
    access->Set("ExposureTime", "3000");
    access->Set("Gain", "6");
    access->Set("BlackLevel", "4");
    for (const auto& [colour, ratio] : {std::pair("Red", "1.5"), std::pair("Blue", "2.25")}) {
      access->Set("BalanceRatioSelector", colour);
      access->Set("BalanceRatio", ratio);
    }
    for (const char* automatic : kAutomatics) access->Set(automatic, "Continuous");
  }
  static void ExpectHeld(const Frame& frame) {
    EXPECT_DOUBLE_EQ(frame.exposure_s, 0.005);
    EXPECT_NEAR(frame.gain, std::pow(10, 12 / 20.0), 1e-6);
    EXPECT_NEAR(frame.black_level, 8 / 255.0, 1e-6);
  }
};

TEST_F(AravisAutomatics, HoldTheirValuesAfterSettling) {
  StartFullCamera();
  LeaveOn();
  const auto begun = Clock::now();
  const auto device = OpenDriver(kUri);
  device->Start();
  for (const Frame& frame : Take(*device, 5)) ExpectHeld(frame);
  EXPECT_EQ(device->Held().exposure, true);
  EXPECT_EQ(device->Held().white_balance, true);
  EXPECT_FALSE(device->Held().focus) << "no such feature";
  EXPECT_GT(SecondsSince(begun), 0.5) << "they were given time to settle";
  EXPECT_THAT(Said(*device),
              AllOf(Contains(HasSubstr("auto_exposure off, held at exposure_us=5000")),
                    Contains(HasSubstr("auto_gain off, held at gain_db=12")),
                    Contains(HasSubstr("auto_black_level off, held at black_level=8")),
                    Contains(HasSubstr("auto_white_balance off, held at white_balance=2,1.25"))));
  auto values = Values();
  for (const char* automatic : kAutomatics) EXPECT_EQ(values[automatic], "Off");
  EXPECT_EQ(values["ExposureTime"], "5000") << "not what was set by hand before";
  EXPECT_EQ(values["Gain"], "12");
  EXPECT_EQ(values["BlackLevel"], "8");
  EXPECT_EQ(values["BalanceRatio"], "1.25") << "of blue, which was written last";
  device->Stop();
  // Not handed out, but not passed over in silence: 50 a second for half a second.
  EXPECT_GT(TransportOf(*device, TransportFigure::kWhileSettling), 5);
  EXPECT_LT(TransportOf(*device, TransportFigure::kWhileSettling), 40);
}

TEST_F(AravisAutomatics, HoldSettledValuesAfterALoss) {
  StartFullCamera();
  LeaveOn();
  const auto device = OpenDevice(kUri);
  device->Start();
  ASSERT_EQ(Take(*device, 3).size(), 3u);
  camera_->Kill();
  StartFullCamera();  // as it comes from the factory
  const auto back = Clock::now();
  while (device->Statistics().reconnects == 0 && SecondsSince(back) < 20) device->Next(50ms);
  ASSERT_EQ(device->Statistics().reconnects, 1u);
  std::optional<Frame> frame;
  while (!frame && SecondsSince(back) < 25) frame = device->Next(100ms);
  ASSERT_TRUE(frame);
  ExpectHeld(*frame);
  auto values = Values();
  EXPECT_EQ(values["ExposureTime"], "5000");
  EXPECT_EQ(values["Gain"], "12");
  EXPECT_EQ(values["BlackLevel"], "8");
  EXPECT_EQ(values["BalanceRatio"], "1.25");
  std::this_thread::sleep_for(250ms);  // the counters are taken ten times a second
  EXPECT_EQ(TransportOf(*device, TransportFigure::kFrameRetentionMs), 100)
      << "a setting, not a count of streams";
  EXPECT_EQ(TransportOf(*device, TransportFigure::kPayloadBytes), 64 * 64);
  EXPECT_EQ(TransportOf(*device, TransportFigure::kSetFps), 50);
  EXPECT_EQ(TransportOf(*device, TransportFigure::kExposureUs), 5000);
  EXPECT_EQ(TransportOf(*device, TransportFigure::kResends), 0)
      << "this camera cannot send again, so it is not asked";
}

TEST_F(AravisAutomatics, StayAsTheyAreAskedFor) {
  StartFullCamera();
  LeaveOn();
  const auto device = OpenDriver(std::string(kUri) +
                                 "&auto_exposure=on&auto_gain=off&auto_white_balance=on&auto_black_level=on");
  device->Start();
  for (const Frame& frame : Take(*device, 40)) {
    EXPECT_EQ(frame.exposure_s, 0) << "unknown: the camera chooses";
    EXPECT_NEAR(frame.gain, std::pow(10, 6 / 20.0), 1e-6) << "ended at once, at what was set by hand";
  }
  EXPECT_EQ(device->Held().exposure, false);
  EXPECT_EQ(device->Held().white_balance, false);
  EXPECT_THAT(Said(*device), Not(Contains(HasSubstr("auto_"))));
  auto values = Values();
  EXPECT_EQ(values["ExposureAuto"], "Continuous");
  EXPECT_EQ(values["GainAuto"], "Off");
  EXPECT_EQ(values["BlackLevelAuto"], "Continuous");
  EXPECT_EQ(values["BalanceWhiteAuto"], "Continuous");
  EXPECT_EQ(values["ExposureTime"], "5000") << "it went on to its goal";
  device->Stop();
  EXPECT_EQ(TransportOf(*device, TransportFigure::kWhileSettling), 0);
}

TEST_F(AravisAutomatics, HoldAGainInTheCamerasOwnUnits) {
  const ScratchFolder scratch;
  std::string description = ReadWholeFile(FULL_CAMERA);
  const std::string decibels = "<Float Name=\"Gain\">";
  const std::size_t from = description.find(decibels);
  ASSERT_NE(from, std::string::npos);
  description.replace(
      from, description.find("</Float>", from) + 8 - from,
      "<Integer Name=\"GainRaw\"><pValue>GainReg</pValue><Min>0</Min><Max>240</Max></Integer>");
  WriteFileAtomically(scratch / "camera.xml", description);
  StartCamera("R1", "0", "127.0.0.1", (scratch / "camera.xml").string());
  {
    const auto access = OpenFeatures(kCamera);
    access->Set("GainRaw", "60");
    access->Set("GainAuto", "Continuous");
  }
  const auto device = OpenDriver(kUri);
  device->Start();
  ASSERT_EQ(Take(*device, 3).size(), 3u);
  EXPECT_THAT(Said(*device), Contains(HasSubstr("auto_gain off, held at gain_raw=120")));
  EXPECT_THAT(device->Info().uri, HasSubstr("gain_raw=120"));
  EXPECT_EQ(Values()["GainRaw"], "120");
}

}  // namespace
}  // namespace ulf::test::aravis_automatics_test
