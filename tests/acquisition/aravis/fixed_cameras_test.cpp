// Tests: acquisition/aravis/aravis_setting, acquisition/aravis/aravis_configuration,
// acquisition/aravis/aravis_automatics, acquisition/aravis/aravis_region, acquisition/aravis/aravis_trigger.
//
// Cameras that have fixed what others let be set: what reads as wanted needs no write, what nobody asked for
// is taken as it is and said once, and what was asked for by name and cannot be had is refused by name.
#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "acquisition/opening/open_device.h"
#include "tests/acquisition/aravis/edited_camera.h"

namespace ulf::test::fixed_cameras_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kWithoutRegion = "aravis:127.0.0.1?format=Mono8&settle=0.2";

class FixedCameras : public EditedCamera {
 protected:
  // Opens, takes frames, and returns the first; `said`: all that was told.
  static Frame FrameOf(const std::string& uri, std::vector<std::string>* said = nullptr) {
    const auto device = OpenDriver(uri);
    if (said) *said = Said(*device);
    device->Start();
    const std::vector<Frame> frames = Take(*device, 2);
    if (said)
      for (std::string& text : Said(*device)) said->push_back(text);
    return frames.empty() ? Frame{} : frames.front();
  }
  static std::vector<std::string> SaidBy(const std::string& uri) {
    std::vector<std::string> said;
    FrameOf(uri, &said);
    return said;
  }
  // Serves the description with `node`, of whatever kind, in place of an enumeration.
  void ServeAutomatic(const std::string& name, const std::string& node) {
    const std::string whole_description = description_;
    ReplaceNode("Enumeration", name, node);
    Start();
    description_ = whole_description;
  }
};

TEST_F(FixedCameras, ValueThatIsAlreadySetNeedsNoWrite) {
  for (const char* reg : {"AcquisitionModeReg", "ExposureAutoReg", "GainAutoReg", "BlackAutoReg", "PeriodReg",
                          "OffsetXReg", "OffsetYReg", "ChunkModeReg", "TriggerModeReg", "PixelFormatReg"})
    Fix(reg);
  Start();
  const std::string uri =
      kCamera + "?format=Mono8&exposure_us=4000&gain_db=0&black_level=0&fps=25&roi=256x256+0+0";
  std::vector<std::string> said;
  const Frame frame = FrameOf(uri, &said);
  EXPECT_THAT(said, IsEmpty());
  EXPECT_EQ(frame.image.width(), 256);
  EXPECT_DOUBLE_EQ(frame.exposure_s, 0.004);
  EXPECT_EQ(frame.image.pixels.at<std::uint8_t>(7, 9), 3 * 9 + 5 * 7);
}

TEST_F(FixedCameras, AModeThatNobodyAskedForIsTakenAsItIs) {
  ReplaceNode(
      "Enumeration", "AcquisitionMode",
      Choice("AcquisitionMode", {{"Continuous", 1}, {"MultiFrame", 3}}, "ModeNow") + Constant("ModeNow", 3));
  Start();
  EXPECT_THAT(SaidBy(kSmall), ElementsAre(HasSubstr("AcquisitionMode reads MultiFrame and is read-only")));
}

TEST_F(FixedCameras, ASizeThatNobodyAskedForIsTakenAsItIs) {
  Fix("WidthReg");
  Start();
  std::vector<std::string> said;
  const Frame frame = FrameOf(kWithoutRegion, &said);
  EXPECT_EQ(frame.image.width(), 512) << "as the fake camera begins";
  EXPECT_EQ(frame.image.height(), 2048) << "this one is not fixed";
  EXPECT_THAT(said, Contains(HasSubstr("a Width of 512: Width is read-only")));
  EXPECT_EQ(FrameOf(kCamera + "?format=Mono8&roi=512x64+0+0").image.height(), 64);
  EXPECT_THAT(ErrorOfUri(kCamera + "?format=Mono8&roi=256x64+0+0"),
              AllOf(HasSubstr("roi=256x64+0+0"), HasSubstr("nearest is roi=512x64+0+0"),
                    HasSubstr("512 alone, because Width is read-only")));
}

TEST_F(FixedCameras, FixedSizeImageLiesAtTheAskedOffset) {
  struct {
    const char *reg, *taken, *beyond, *nearest;
    int x, y;
  } const cases[] = {{"HeightReg", "256x512+0+256", "256x512+0+1538", "256x512+0+1536", 0, 256},
                     {"HeightReg", "256x512+1792+1536", "256x512+0+2000", "256x512+0+1536", 1792,
                      1536},  // OffsetY says 2032
                     {"WidthReg", "512x256+128+2", "512x256+1540+0", "512x256+1536+0", 128, 2},
                     {"WidthReg", "512x256+1536+1792", "512x258+1536+1792", "512x258+1536+1790", 1536, 1792}};
  const std::string whole_description = description_;
  for (const auto& [reg, taken, beyond, nearest, x, y] : cases) {
    SCOPED_TRACE(taken);
    description_ = whole_description;
    Fix(reg);
    Start();
    const std::string format = kCamera + "?format=Mono8&roi=";
    std::vector<std::string> said;
    const Frame frame = FrameOf(format + taken, &said);
    EXPECT_THAT(said, IsEmpty());
    EXPECT_EQ(frame.image.pixels.at<std::uint8_t>(0, 0), static_cast<std::uint8_t>(3 * x + 5 * y));
    EXPECT_THAT(ErrorOfUri(format + beyond), HasSubstr("nearest is roi=" + std::string(nearest) + " "));
    EXPECT_EQ(OpenDriver(format + taken)->Window()->sensor_width, 2048);
  }
}

TEST_F(FixedCameras, AFixedSizeIsNotTheSensors) {
  const std::string whole_description = description_, format = kCamera + "?format=Mono8&roi=";
  const auto serve = [&](const std::string& of_largest, const std::string& of_offset) {
    description_ = whole_description;
    // Without the sensor's size; what the rest counts with has another name.
    for (const char* side : {"Width", "Height"})
      while (description_.find("Sensor" + std::string(side)) != std::string::npos)
        Replace("Sensor" + std::string(side), "Chip" + std::string(side));
    while (description_.find("HeightMax") != std::string::npos) Replace("HeightMax", "ChipRows");
    ReplaceNode(
        "Integer", "OffsetY",
        "<Integer Name=\"OffsetY\"><pValue>OffsetYReg</pValue><Min>0</Min>" + of_offset + "</Integer>");
    Fix("HeightReg");
    Add(of_largest +
        "<IntSwissKnife Name=\"OffsetYNow\"><pVariable Name=\"M\">ChipRows</pVariable>"
        "<pVariable Name=\"H\">HeightReg</pVariable><Formula>M-H</Formula></IntSwissKnife>");
    Start();
  };
  const std::string by_size = "<pMax>OffsetYNow</pMax><Inc>2</Inc>";
  const std::string fixed = Constant("HeightMax", 512), whole = Constant("HeightMax", 2048);
  struct {
    const char* what;
    std::string of_largest, of_offset;
  } const cases[] = {{"neither size", "", by_size},
                     {"the largest is the fixed one", fixed, by_size},
                     {"the largest, and offsets that know no size", whole, "<Max>2032</Max><Inc>2</Inc>"},
                     {"the largest, and offsets without limits", whole, "<Inc>2</Inc>"}};
  for (const auto& [what, of_largest, of_offset] : cases) {
    SCOPED_TRACE(what);
    serve(of_largest, of_offset);
    EXPECT_EQ(FrameOf(format + "256x512+0+256").image.pixels.at<std::uint8_t>(0, 0), 5 * 256 % 256);
    EXPECT_EQ(FrameOf(format + "256x512+4+1534").image.pixels.at<std::uint8_t>(0, 0), (12 + 5 * 1534) % 256);
    EXPECT_THAT(ErrorOfUri(format + "256x512+0+1540"), HasSubstr("nearest is roi=256x512+0+1536 "));
    for (const std::string& uri : {format + "256x512+0+256", std::string(kWithoutRegion)})
      EXPECT_EQ(OpenDriver(uri)->Window()->sensor_height, 2048) << uri;
  }
  serve("", "<Inc>2</Inc>");  // nothing is known: the sensor has what the image shows
  EXPECT_EQ(OpenDriver(format + "256x512+0+256")->Window()->sensor_height, 768);
}

TEST_F(FixedCameras, SizeAndOffsetMayBothBeFixed) {
  ReplaceNode("Integer", "OffsetY", "<Integer Name=\"OffsetY\"><pValue>OffsetNow</pValue></Integer>");
  Add(Constant("OffsetNow", 256));
  Fix("HeightReg");
  const std::string whole_description = description_, format = kCamera + "?format=Mono8&roi=";
  for (const bool knows_its_sensor : {true, false}) {
    description_ = whole_description;
    for (const char* name : {"SensorHeight", "HeightMax"})
      while (!knows_its_sensor && description_.find(name) != std::string::npos)
        Replace(name, "Chip" + std::string(name + 6));
    Start();
    EXPECT_EQ(OpenDriver(format + "256x512+8+256")->Window(),
              (SensorWindow{2048, knows_its_sensor ? 2048 : 768, 8, 256, 256, 512}));
    EXPECT_THAT(ErrorOfUri(format + "256x512+8+0"),
                AllOf(HasSubstr("nearest is roi=256x512+8+256 "),
                      HasSubstr("256 alone, because OffsetY is read-only")));
  }
}

TEST_F(FixedCameras, OffsetsMayBeFixed) {
  ReplaceNode("Integer", "OffsetX", "<Integer Name=\"OffsetX\"><pValue>OffsetNow</pValue></Integer>");
  Add(Constant("OffsetNow", 8));
  Start();
  EXPECT_THAT(SaidBy(kWithoutRegion), Contains(HasSubstr("OffsetX reads 8 and is read-only")));
  EXPECT_THAT(ErrorOf("fps=20"), AllOf(HasSubstr("roi=64x64+0+0"), HasSubstr("nearest is roi=64x64+8+0"),
                                       HasSubstr("8 alone, because OffsetX is read-only")));
  EXPECT_EQ(OpenDriver(kCamera + "?format=Mono8&roi=64x64+8+0")->Window()->x, 8);
}

TEST_F(FixedCameras, UnaskedPixelFormatIsTakenAsItIs) {
  Fix("PixelFormatReg");
  Start();
  const std::string any = kCamera + "?roi=64x64+0+0";
  std::vector<std::string> said;
  EXPECT_EQ(FrameOf(any, &said).image.mosaic, Mosaic::kNone) << "ulf would have the mosaic";
  EXPECT_THAT(said, Contains(HasSubstr("sends Mono8: PixelFormat reads Mono8 and is read-only")));
  EXPECT_THAT(SaidBy(kSmall), IsEmpty());
  EXPECT_THAT(ErrorOfUri(any + "&format=RGB8"),
              AllOf(HasSubstr("format=RGB8: PixelFormat reads Mono8 and is read-only"),
                    HasSubstr("leave format out")));
}

TEST_F(FixedCameras, NamesTheSettingThatCannotBeHad) {
  for (const char* reg : {"PeriodReg", "ExposureReg", "GainReg", "BlackReg", "BalanceReg", "BinningXReg"})
    Fix(reg);
  Add("<Integer Name=\"DeviceLinkThroughputLimit\"><pValue>LimitNow</pValue><Unit>Bps</Unit></Integer>" +
      Constant("LimitNow", 20000000));
  Start();
  struct {
    const char *option, *refusal;
  } const cases[] = {
      {"fps=10", "fps=10: AcquisitionFrameRate is read-only at 25; leave fps out"},
      {"exposure_us=4000", "exposure_us=4000: ExposureTime is read-only at 10000; leave exposure_us out"},
      {"gain_db=3", "gain_db=3: Gain is read-only at 0; leave gain_db out"},
      {"black_level=4", "black_level=4: BlackLevel is read-only at 0; leave black_level out"},
      {"white_balance=1.5,2",
       "white_balance=1.5 (Red): BalanceRatio is read-only at 0; leave white_balance out"},
      {"binning=2x1",
       "binning=2 is out of the camera's range, 1 alone, because BinningHorizontal is read-only"},
      {"throughput_limit=12000000",
       "throughput_limit=12000000: DeviceLinkThroughputLimit is read-only at 20000000 bytes a second"}};
  for (const auto& [option, refusal] : cases)
    EXPECT_THAT(ErrorOfUri(kCamera + "?format=Mono8&roi=64x64+0+0&" + option), HasSubstr(refusal)) << option;
  EXPECT_THAT(SaidBy(kCamera + "?format=Mono8&roi=64x64+0+0&fps=25&exposure_us=10000&gain_db=0&black_level=0&"
                               "throughput_limit=20000000"),
              IsEmpty())
      << "what they read";
}

TEST_F(FixedCameras, FixedNumberMatchesARoundedRequest) {
  ReplaceNode("Float", "AcquisitionFrameRate",
              "<Float Name=\"AcquisitionFrameRate\"><pValue>RateNow</pValue></Float>"
              "<SwissKnife Name=\"RateNow\"><Formula>30000.0/1001.0</Formula></SwissKnife>");
  Start();
  const std::string small = kCamera + "?format=Mono8&roi=64x64+0+0&fps=";
  EXPECT_THAT(SaidBy(small + "29.97"), IsEmpty());
  EXPECT_THAT(ErrorOfUri(small + "30.5"), HasSubstr("AcquisitionFrameRate is read-only at 29.97"));
}

TEST_F(FixedCameras, FeaturesThatReadAsWantedAreSet) {
  Fix("PixelFormatReg");
  Start();
  const auto access = OpenFeatures(kCamera);
  access->Set("PixelFormat", "Mono8");
  EXPECT_THROW(access->Set("PixelFormat", "RGB8"), Refusal);
  access->Set("Width", access->Find("Width")->value);
}

// ---- automatics

TEST_F(FixedCameras, AutomaticIsTurnedOffByMeaning) {
  struct {
    const char* what;
    std::string node;
    std::string on, off;
  } const cases[] = {
      {"two words", Choice("ExposureAuto", {{"Manual", 0}, {"Auto", 2}}, "ExposureAutoReg"), "Auto",
       "Manual"},
      {"words with the feature's name",
       Choice("ExposureAuto", {{"ExposureAuto_Off", 0}, {"ExposureAuto_Continuous", 2}}, "ExposureAutoReg"),
       "ExposureAuto_Continuous", "ExposureAuto_Off"},
      {"other capitals", Choice("ExposureAuto", {{"AUTO", 2}, {"OFF", 0}}, "ExposureAutoReg"), "AUTO", "OFF"},
      {"a switch",
       "<Boolean Name=\"ExposureAuto\"><pValue>ExposureAutoReg</pValue><OnValue>2</OnValue></Boolean>",
       "true", "false"},
      {"a number", "<Integer Name=\"ExposureAuto\"><pValue>ExposureAutoReg</pValue></Integer>", "2", "0"}};
  for (const auto& [what, node, on, off] : cases) {
    SCOPED_TRACE(what);
    ServeAutomatic("ExposureAuto", node);
    OpenFeatures(kCamera)->Set("ExposureAuto", on);
    std::vector<std::string> said;
    EXPECT_DOUBLE_EQ(FrameOf(kSmall, &said).exposure_s, 0.005) << "what it reached";
    EXPECT_THAT(said, ElementsAre(HasSubstr("auto_exposure off, held at exposure_us=5000")));
    EXPECT_EQ(ValueOf("ExposureAuto"), off);
    OpenFeatures(kCamera)->Set("ExposureAuto", on);
    EXPECT_DOUBLE_EQ(FrameOf(kSmall + "&exposure_us=4000", &said).exposure_s, 0.004);
    EXPECT_THAT(said, IsEmpty());
    EXPECT_EQ(ValueOf("ExposureAuto"), off);
  }
  EXPECT_THAT(ErrorOf("auto_exposure=on"),
              HasSubstr("auto_exposure=on: ExposureAuto reads 0 and offers nothing that means on"));
}

TEST_F(FixedCameras, AutomaticIsTurnedOnByMeaning) {
  ServeAutomatic("GainAuto",
                 Choice("GainAuto", {{"Manual", 0}, {"AutoOnce", 1}, {"Auto", 2}}, "GainAutoReg"));
  EXPECT_EQ(FrameOf(kSmall + "&auto_gain=on").gain, 1) << "unknown: the camera chooses";
  EXPECT_EQ(ValueOf("GainAuto"), "Auto");
  EXPECT_NEAR(FrameOf(kSmall + "&auto_gain=off").gain, 1, 1e-6);
  EXPECT_EQ(ValueOf("GainAuto"), "Manual");
}

TEST_F(FixedCameras, AnAutomaticWithoutWordsIsLeftAlone) {
  ServeAutomatic("ExposureAuto", Choice("ExposureAuto", {}, "ExposureAutoReg"));
  std::vector<std::string> said;
  EXPECT_DOUBLE_EQ(FrameOf(kSmall + "&exposure_us=4000", &said).exposure_s, 0.004);
  EXPECT_THAT(said, ElementsAre(HasSubstr("keeps ExposureAuto as it is")));
  EXPECT_THAT(ErrorOf("auto_exposure=off"),
              AllOf(HasSubstr("auto_exposure=off: ExposureAuto"), HasSubstr("it has no choices"),
                    HasSubstr("leave auto_exposure out")));
  ServeAutomatic("GainAuto", Choice("GainAuto", {{"Sunny", 0}, {"Cloudy", 2}}, "GainAutoReg"));
  EXPECT_THAT(SaidBy(kSmall + "&gain_db=3"), ElementsAre(HasSubstr("keeps GainAuto as it is")));
  EXPECT_THAT(ErrorOf("auto_gain=off"), HasSubstr("its choices are Sunny, Cloudy"));
}

TEST_F(FixedCameras, StuckAutomaticIsRefusedOnlyIfUsed) {
  // Two words of which one is described, and a register that nobody may write.
  for (const std::string& node :
       {Choice("GainAuto", {{"Continuous", 2}}, "GainAutoReg"),
        Choice("GainAuto", {{"Off", 0}, {"Continuous", 2}}, "AlwaysOn") + Constant("AlwaysOn", 2)}) {
    ServeAutomatic("GainAuto", node);
    if (node.find("AlwaysOn") == std::string::npos) OpenFeatures(kCamera)->Set("GainAuto", "Continuous");
    EXPECT_THAT(SaidBy(kSmall), ElementsAre(AllOf(HasSubstr("auto_gain stays on: GainAuto reads Continuous"),
                                                  HasSubstr("pictures may change between views"))));
    EXPECT_THAT(ErrorOf("gain_db=3"), AllOf(HasSubstr("gain_db=3 needs GainAuto off"),
                                            HasSubstr("reads Continuous"), HasSubstr("leave gain_db out")));
    EXPECT_EQ(FrameOf(kSmall + "&auto_gain=on").gain, 1);
  }
}

TEST_F(FixedCameras, WhiteBalanceOnceIsFoundByMeaning) {
  ServeAutomatic("BalanceWhiteAuto",
                 Choice("BalanceWhiteAuto", {{"Manual", 0}, {"OnePush", 1}}, "BalanceAutoReg"));
  FrameOf(kSmall + "&white_balance=auto");
  EXPECT_EQ(ValueOf("BalanceWhiteAuto"), "OnePush");
  FrameOf(kSmall + "&white_balance=1.5,2");
  EXPECT_EQ(ValueOf("BalanceWhiteAuto"), "Manual");
  EXPECT_EQ(ValueOf("BalanceRatio"), "2") << "of blue, which was written last";
  ServeAutomatic("BalanceWhiteAuto",
                 Choice("BalanceWhiteAuto", {{"Manual", 0}, {"Auto", 2}}, "BalanceAutoReg"));
  EXPECT_THAT(ErrorOf("white_balance=auto"), HasSubstr("the camera has Manual, Auto"));
}

// ---- rates that a switch makes available

TEST_F(FixedCameras, ARateIsSetOnceItsSwitchLetsIt) {
  const std::string on_switch =
      "<Boolean Name=\"AcquisitionFrameRateEnable\"><pValue>SwitchReg</pValue></Boolean>";
  struct {
    const char* what;
    std::string of_rate, of_switch, name, reads;
  } const cases[] = {
      {"available", "<pIsAvailable>SwitchReg</pIsAvailable>", on_switch, "AcquisitionFrameRateEnable",
       "true"},
      {"unlocked", "<pIsLocked>SwitchIsOff</pIsLocked>", on_switch, "AcquisitionFrameRateEnable", "true"},
      {"the other name", "<pIsAvailable>SwitchReg</pIsAvailable>",
       "<Boolean Name=\"AcquisitionFrameRateEnabled\"><pValue>SwitchReg</pValue></Boolean>",
       "AcquisitionFrameRateEnabled", "true"},
      {"words", "<pIsAvailable>SwitchReg</pIsAvailable>",
       Choice("AcquisitionFrameRateEnable", {{"Off", 0}, {"On", 1}}, "SwitchReg"),
       "AcquisitionFrameRateEnable", "On"},
      {"a number", "<pIsAvailable>SwitchReg</pIsAvailable>",
       "<Integer Name=\"AcquisitionFrameRateEnable\"><pValue>SwitchReg</pValue></Integer>",
       "AcquisitionFrameRateEnable", "1"},
      {"an automatic", "<pIsLocked>SwitchReg</pIsLocked>",
       Choice("AcquisitionFrameRateAuto", {{"Off", 0}, {"Continuous", 1}}, "SwitchReg"),
       "AcquisitionFrameRateAuto", "Off"},
      {"inverted", "<pIsLocked>SwitchReg</pIsLocked>", on_switch, "AcquisitionFrameRateEnable", "false"}};
  const std::string whole_description = description_;
  for (const auto& [what, of_rate, of_switch, name, reads] : cases) {
    SCOPED_TRACE(what);
    description_ = whole_description;
    Replace("<Float Name=\"AcquisitionFrameRate\">", "<Float Name=\"AcquisitionFrameRate\">" + of_rate);
    Add(of_switch + Register("SwitchReg", "0x10b0") +
        "<IntSwissKnife Name=\"SwitchIsOff\"><pVariable "
        "Name=\"S\">SwitchReg</pVariable><Formula>S=0</Formula>"
        "</IntSwissKnife>");
    Start();
    if (name == "AcquisitionFrameRateAuto") OpenFeatures(kCamera)->Set(name, "Continuous");
    EXPECT_THAT(Said(*OpenDriver(kCamera + "?format=Mono8&roi=64x64+0+0&fps=40")), IsEmpty());
    EXPECT_EQ(ValueOf("AcquisitionFrameRate"), "40");
    EXPECT_EQ(ValueOf(name), reads);
  }
}

TEST_F(FixedCameras, FixedRateSwitchNamesRateAndSwitch) {
  Replace("<Float Name=\"AcquisitionFrameRate\">",
          "<Float Name=\"AcquisitionFrameRate\"><pIsAvailable>AlwaysOff</pIsAvailable>");
  Add(Choice("AcquisitionFrameRateEnable", {{"Off", 0}, {"On", 1}}, "AlwaysOff") + Constant("AlwaysOff", 0));
  Start();
  EXPECT_THAT(
      ErrorOfUri(kCamera + "?format=Mono8&roi=64x64+0+0&fps=25"),
      AllOf(HasSubstr("fps=25: AcquisitionFrameRate is not available now"),
            HasSubstr("AcquisitionFrameRateEnable reads Off and is read-only"), HasSubstr("leave fps out")));
  FrameOf(kCamera + "?format=Mono8&roi=64x64+0+0");
}

TEST_F(FixedCameras, SlowerCameraThanToldDoesNotStall) {
  ReplaceNode("Float", "AcquisitionFrameRate",
              "<Float Name=\"AcquisitionFrameRate\"><pValue>Thirty</pValue></Float>");
  Add(Constant("Thirty", 30) + "<Integer Name=\"RealPeriod\"><pValue>PeriodReg</pValue></Integer>");
  Start();
  OpenFeatures(kCamera)->Set("RealPeriod", "600000");
  const auto device = OpenDriver(kCamera + "?format=Mono8&roi=64x64+0+0");
  device->Start();
  EXPECT_EQ(Take(*device, 9).size(), 9u);
  int stalls = 0;
  for (const DeviceEvent& event : device->TakeEvents()) stalls += event.kind == DeviceEventKind::kStalled;
  EXPECT_GE(stalls, 1);
  EXPECT_LE(stalls, 4) << "after three it is the camera's own rate";
}

// ---- triggers

TEST_F(FixedCameras, ReadOnlySourceIsWrittenAnyway) {
  Fix("TriggerSourceReg");
  Start();
  const std::string uri = kCamera + "?format=Mono8&roi=64x64+0+0&trigger=software";
  {
    const auto device = OpenDriver(uri);
    EXPECT_THAT(Said(*device), ElementsAre(HasSubstr("took TriggerSource=Software although")));
    device->Start();
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(device->Next(5s)) << i;
    EXPECT_EQ(device->Statistics().delivered, 3u) << "one for each";
  }
  EXPECT_EQ(ValueOf("TriggerSource"), "Software");
  EXPECT_EQ(ValueOf("TriggerMode"), "On");
  EXPECT_THAT(Said(*OpenDriver(uri)), IsEmpty()) << "it reads so now";
}

TEST_F(FixedCameras, SourceThatIgnoresWritesIsRefused) {
  ReplaceNode(
      "Enumeration", "TriggerSource",
      Choice("TriggerSource", {{"Line0", 0}, {"Software", 1}}, "SourceNow") + Constant("SourceNow", 0));
  Start();
  EXPECT_THAT(ErrorOfUri(kCamera + "?format=Mono8&roi=64x64+0+0&trigger=software"),
              AllOf(HasSubstr("trigger=software: TriggerSource reads Line0 and is read-only"),
                    HasSubstr("leave trigger out")));
  EXPECT_THAT(Said(*OpenDriver(kCamera + "?format=Mono8&roi=64x64+0+0&trigger=Line0")), IsEmpty());
}

TEST_F(FixedCameras, AnEdgeThatNobodyAskedForIsTakenAsItIs) {
  Add(Choice("TriggerActivation", {{"RisingEdge", 0}, {"FallingEdge", 1}}, "EdgeNow") +
      Constant("EdgeNow", 1));
  Start();
  EXPECT_THAT(Said(*OpenDriver(kCamera + "?format=Mono8&roi=64x64+0+0&trigger=Line0")),
              ElementsAre(HasSubstr("TriggerActivation reads FallingEdge and is read-only")));
}

// ---- room for a frame

TEST_F(FixedCameras, APayloadThatIsTooSmallIsCorrected) {
  struct {
    const char *what, *formula;
    std::size_t room;
    bool is_said;
  } const cases[] = {{"nothing", "0", 64 * 48 * 3, true},
                     {"without the bytes of a pixel", "W*H", 64 * 48 * 3, true},
                     {"one byte short", "W*H*3-1", 64 * 48 * 3, true},
                     {"of the whole sensor", "2048*2048*3", 2048 * 2048 * 3, false},
                     {"one byte more", "W*H*3+1", 64 * 48 * 3 + 1, false}};
  const std::string whole_description = description_;
  for (const auto& [what, formula, room, is_said] : cases) {
    SCOPED_TRACE(what);
    description_ = whole_description;
    Replace("<Formula>W*H*((F&gt;&gt;16)&amp;0xFF)/8</Formula>",
            "<Formula>" + std::string(formula) + "</Formula>");
    Start();
    const auto device = OpenDriver(kCamera + "?format=RGB8&roi=64x48+0+0&fps=50");
    const auto said = Said(*device);
    ASSERT_EQ(said.size(), is_said ? 1u : 0u);
    if (is_said) {
      EXPECT_THAT(said.front(), AllOf(HasSubstr("PayloadSize"), HasSubstr("64x48 of RGB8 are 9216"),
                                      HasSubstr("description is wrong")));
    }
    device->Start();
    for (const Frame& frame : Take(*device, 3)) {
      EXPECT_EQ(frame.status, FrameStatus::kComplete);
      EXPECT_EQ(frame.image.pixels.at<cv::Vec3b>(47, 63), cv::Vec3b(77, 47, 63)) << "blue, green, red";
    }
    device->Stop();
    EXPECT_EQ(device->Statistics().incomplete, 0u);
    EXPECT_THAT(device->Statistics().transport,
                Contains(std::pair<TransportFigure, double>(TransportFigure::kPayloadBytes, room)));
  }
}

TEST_F(FixedCameras, APayloadThatIsNotToldIsComputed) {
  ReplaceNode("IntSwissKnife", "PayloadSize", "");
  Start();
  EXPECT_THAT(SaidBy(kSmall), ElementsAre(HasSubstr("PayloadSize")));
  // Another region needs other room.
  const Frame frame = FrameOf(kCamera + "?format=Mono8&roi=512x256+0+0");
  EXPECT_EQ(frame.image.pixels.at<std::uint8_t>(255, 511), static_cast<std::uint8_t>(3 * 511 + 5 * 255));
}

TEST_F(FixedCameras, ChunkDataHaveRoomBesideTheImage) {
  const std::string whole_description = description_;
  for (const auto& [formula, room] : {std::pair("W*H+C*100", 64 * 64 + 100), std::pair("W*H", 64 * 64 + 4096),
                                      std::pair("0", 64 * 64 + 4096)}) {
    description_ = whole_description;
    Replace(
        "<pVariable Name=\"F\">PixelFormatReg</pVariable><Formula>W*H*((F&gt;&gt;16)&amp;0xFF)/8</Formula>",
        "<pVariable Name=\"C\">ChunkModeReg</pVariable><Formula>" + std::string(formula) + "</Formula>");
    Start();
    const auto device = OpenDriver(kSmall + "&chunks=on");
    device->Start();
    EXPECT_EQ(Take(*device, 3).size(), 3u);
    device->Stop();
    EXPECT_THAT(device->Statistics().transport,
                Contains(std::pair<TransportFigure, double>(TransportFigure::kPayloadBytes, room)));
  }
}

}  // namespace
}  // namespace ulf::test::fixed_cameras_test
