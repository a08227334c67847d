// Tests: acquisition/aravis/aravis_setting, acquisition/aravis/aravis_trigger,
// acquisition/aravis/aravis_white_balance, acquisition/aravis/aravis_link, acquisition/aravis/aravis_region.
//
// Cameras that differ from the standard as real ones do (docs/measured/cameras.md): full_camera.xml with
// some of its features in the types, units and names of other makers, served by the fake camera and
// driven as any other.
#include <gmock/gmock.h>

#include <string>
#include <utility>

#include "acquisition/opening/open_device.h"
#include "tests/acquisition/aravis/edited_camera.h"

namespace ulf::test::vendor_cameras_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

class VendorCameras : public EditedCamera {};

// Exposes as asked, holds what the automatic reached (full_camera.xml's goal is 5000 us), and
// takes a stop more.
void ExpectExposures(const std::string& of_4000_us, const std::string& of_5000_us) {
  {
    const auto device = OpenDriver(kSmall + "&exposure_us=4000");
    EXPECT_TRUE(device->TakeEvents().empty()) << "the camera took it as it was";
    device->Start();
    for (const Frame& frame : Take(*device, 2)) EXPECT_DOUBLE_EQ(frame.exposure_s, 0.004);
    ASSERT_EQ(device->RequestExposures({1}), StillRequest::kAsked);
    double exposure_s = 0;
    for (int i = 0; i < 100 && exposure_s == 0; ++i)
      if (const auto frame = device->Next(500ms); frame && frame->asked_stops == 1)
        exposure_s = frame->exposure_s;
    EXPECT_NEAR(exposure_s, 0.008, 1e-6);
  }
  EXPECT_EQ(OpenFeatures(kCamera)->Find("ExposureTime")->value, of_4000_us) << "as before the request";
  OpenFeatures(kCamera)->Set("ExposureAuto", "Continuous");
  {
    const auto device = OpenDriver(kSmall);
    device->Start();
    for (const Frame& frame : Take(*device, 2)) EXPECT_DOUBLE_EQ(frame.exposure_s, 0.005);
    EXPECT_THAT(device->Info().uri, HasSubstr("exposure_us=5000"));
  }
  EXPECT_EQ(OpenFeatures(kCamera)->Find("ExposureTime")->value, of_5000_us);
}

TEST_F(VendorCameras, ExposureInSecondsIsConverted) {
  Replace("<Min>10</Min><Max>1000000</Max><Unit>us</Unit>", "<Min>0.00001</Min><Max>1</Max><Unit>s</Unit>");
  Replace("<FormulaTo>FROM</FormulaTo><FormulaFrom>TO</FormulaFrom><pValue>ExposureReg</pValue>",
          "<FormulaTo>FROM*1000000</FormulaTo><FormulaFrom>TO/1000000.0</FormulaFrom><pValue>ExposureReg</"
          "pValue>");
  Start();
  EXPECT_THAT(ErrorOf("exposure_us=2000000"), HasSubstr("10 to 1000000"));
  ExpectExposures("0.004", "0.005");
}

TEST_F(VendorCameras, AnExposureThatIsAWholeNumberIsTaken) {
  ReplaceNode(
      "Float", "ExposureTime",
      "<Integer Name=\"ExposureTime\"><pIsLocked>ExposureLocked</pIsLocked><pValue>ExposureReg</pValue>"
      "<Min>10</Min><Max>1000000</Max></Integer>");
  Start();
  EXPECT_THAT(ErrorOf("exposure_us=2000000"), HasSubstr("10 to 1000000"));
  ExpectExposures("4000", "5000");
}

TEST_F(VendorCameras, AGainThatIsAFactorIsNoDecibels) {
  ReplaceNode("Float", "Gain",
              "<Float Name=\"Gain\"><pValue>GainConverter</pValue><Min>1</Min><Max>4</Max></Float>");
  Replace("<FormulaTo>FROM*10</FormulaTo><FormulaFrom>TO/10.0</FormulaFrom>",
          "<FormulaTo>FROM*100</FormulaTo><FormulaFrom>TO/100.0</FormulaFrom>");
  Start();
  EXPECT_THAT(ErrorOf("gain_db=13"), AllOf(HasSubstr("gain_db=13"), HasSubstr("0 to 12.04")));
  {
    const auto device = OpenDriver(kSmall + "&gain_db=6.0206");
    EXPECT_TRUE(device->TakeEvents().empty());
    device->Start();
    for (const Frame& frame : Take(*device, 2)) EXPECT_NEAR(frame.gain, 2, 1e-6);
  }
  EXPECT_EQ(ValueOf("Gain"), "2");
  OpenFeatures(kCamera)->Set("GainAuto", "Continuous");  // goes to 1.2
  const auto device = OpenDriver(kSmall);
  device->Start();
  for (const Frame& frame : Take(*device, 2)) EXPECT_NEAR(frame.gain, 1.2, 1e-6);
  EXPECT_THAT(Said(*device), Contains(HasSubstr("held at gain_db=1.58")));
}

TEST_F(VendorCameras, AGainThatMayBeAnythingIsUnknown) {
  ReplaceNode("Float", "Gain",
              "<Float Name=\"Gain\"><pValue>GainConverter</pValue><Min>0</Min><Max>24</Max></Float>");
  Start();
  EXPECT_THAT(ErrorOf("gain_db=3"), HasSubstr("gain_raw"));
  {
    const auto device = OpenDriver(kSmall + "&gain_raw=12");
    device->Start();
    for (const Frame& frame : Take(*device, 2)) EXPECT_EQ(frame.gain, 1);
  }
  EXPECT_EQ(ValueOf("Gain"), "12");
}

TEST_F(VendorCameras, GainsOfColoursAreTheWhiteBalance) {
  ReplaceNode("Enumeration", "BalanceRatioSelector", "");
  ReplaceNode("Float", "BalanceRatio", "");
  ReplaceNode("Float", "Gain",
              "<Float Name=\"Gain\"><pValue>GainConverter</pValue><Min>0.1</Min><Max>8</Max></Float>");
  Replace("<FormulaTo>FROM*10</FormulaTo><FormulaFrom>TO/10.0</FormulaFrom>",
          "<FormulaTo>FROM*100</FormulaTo><FormulaFrom>TO/100.0</FormulaFrom>");
  ReplaceNode("IntReg", "GainReg",
              Register("GainReg", "0x1070", "<pIndex Offset=\"4\">GainSelectorReg</pIndex>"));
  Add(Choice("GainSelector", {{"All", 0}, {"Red", 1}, {"Green", 2}, {"Blue", 3}}, "GainSelectorReg") +
      Register("GainSelectorReg", "0x1090"));
  Start();
  const auto gain_of = [](FeatureAccess& access, const char* colour) {
    access.Set("GainSelector", colour);
    return access.Find("Gain")->value;
  };
  {
    const auto access = OpenFeatures(kCamera);
    for (const auto& [colour, gain] :
         {std::pair("All", "1"), std::pair("Red", "1"), std::pair("Green", "1.5"), std::pair("Blue", "1")}) {
      access->Set("GainSelector", colour);
      access->Set("Gain", gain);
    }
  }
  EXPECT_TRUE(OpenDriver(kSmall + "&white_balance=1.2,2&gain_db=6.0206")->TakeEvents().empty());
  {
    const auto access = OpenFeatures(kCamera);
    EXPECT_EQ(access->Find("GainSelector")->value, "All");
    EXPECT_EQ(gain_of(*access, "Red"), "1.8");
    EXPECT_EQ(gain_of(*access, "Blue"), "3");
    EXPECT_EQ(gain_of(*access, "Green"), "1.5");
    EXPECT_EQ(gain_of(*access, "All"), "2");
  }
  EXPECT_THAT(ErrorOf("white_balance=1,6"), HasSubstr("white_balance=6"));
}

TEST_F(VendorCameras, ALimitOfThroughputIsInTheCamerasUnit) {
  struct Case {
    const char *node, *unit, *bounds, *of_20_mb;
  };
  const std::string whole_description = description_;
  for (const Case& each : {Case{"Integer", "KB", "<Min>1000</Min><Max>120000</Max><Inc>8</Inc>", "20000"},
                           Case{"Integer", "Bps", "<Min>1000000</Min><Max>120000000</Max>", "20000000"}}) {
    description_ = whole_description;
    const std::string node = each.node;
    Add(Choice("DeviceLinkThroughputLimitMode", {{"Off", 0}, {"On", 1}}, "LimitModeReg") +
        Register("LimitModeReg", "0x10a0") + Register("LimitReg", "0x10a4") + "<" + node +
        " Name=\"DeviceLinkThroughputLimit\"><pIsAvailable>LimitModeReg</pIsAvailable><pValue>LimitReg</"
        "pValue>" +
        each.bounds + "<Unit>" + each.unit + "</Unit></" + node + ">");
    Start();
    EXPECT_THAT(ErrorOf("throughput_limit=10000"), HasSubstr("1000000 to 120000000 bytes a second"))
        << each.unit;
    {
      const auto device = OpenDriver(kSmall + "&throughput_limit=20000000");
      device->Start();
      Take(*device, 1);
      device->Stop();
      EXPECT_THAT(device->Statistics().transport,
                  Contains(std::pair<TransportFigure, double>(TransportFigure::kThroughputLimit, 2e7)))
          << each.unit;
    }
    EXPECT_EQ(ValueOf("DeviceLinkThroughputLimit"), each.of_20_mb);
    EXPECT_EQ(ValueOf("DeviceLinkThroughputLimitMode"), "On");
  }
}

TEST_F(VendorCameras, ThroughputMayHaveAnUnknownUnit) {
  const std::string whole_description = description_;
  const auto serve = [&](const std::string& unit) {
    description_ = whole_description;
    Add("<Float "
        "Name=\"DeviceLinkThroughputLimit\"><pValue>LimitConverter</pValue><Min>1</Min><Max>120</Max><Unit>" +
        unit + "</Unit></Float><Converter Name=\"LimitConverter\"><FormulaTo>FROM*10</FormulaTo>" +
        "<FormulaFrom>TO/10.0</FormulaFrom><pValue>LimitReg</pValue></Converter>" +
        Register("LimitReg", "0x10a4"));
    Start();
  };
  serve("MBps");
  EXPECT_THAT(ErrorOf("throughput_limit=10000"), HasSubstr("1000000 to 120000000 bytes a second"));
  EXPECT_TRUE(OpenDriver(kSmall + "&throughput_limit=12500000")->TakeEvents().empty());
  EXPECT_EQ(ValueOf("DeviceLinkThroughputLimit"), "12.5");
  serve("furlongs");
  EXPECT_THAT(ErrorOf("throughput_limit=12500000"), HasSubstr("a unit that ulf does not know"));
  EXPECT_EQ(ValueOf("DeviceLinkThroughputLimit"), "0") << "nothing was written";
}

// One frame for each call, none without, and back to the camera's own rate.
void ExpectTriggers(const std::string& source) {
  {
    const auto device = OpenDriver("aravis:127.0.0.1?format=Mono8&roi=64x64+0+0&trigger=software");
    device->Start();
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(device->Next(5s)) << source << i;
    EXPECT_EQ(device->Statistics().delivered, 3u) << source;
  }
  EXPECT_EQ(OpenFeatures(kCamera)->Find("TriggerMode")->value, "On") << source;
  EXPECT_EQ(OpenFeatures(kCamera)->Find("TriggerSource")->value, "Software") << source;
  OpenDriver(kSmall);
  EXPECT_EQ(OpenFeatures(kCamera)->Find("TriggerMode")->value, "Off") << source;
}

TEST_F(VendorCameras, OneTriggerNeedsNoSelector) {
  ReplaceNode("Enumeration", "TriggerSelector", "");
  Start();
  ExpectTriggers("no selector");
  EXPECT_EQ(ValueOf("TriggerSelector"), "no TriggerSelector");
}

TEST_F(VendorCameras, ReadOnlySelectorIsLeftAlone) {
  ReplaceNode("Enumeration", "TriggerSelector",
              Choice("TriggerSelector", {{"ExposureStart", 0}, {"ExposureActive", 1}}, "TriggerSelectorReg",
                     "<ImposedAccessMode>RO</ImposedAccessMode>"));
  Start();
  ExpectTriggers("read-only");
}

TEST_F(VendorCameras, ATriggerThatStartsTheExposureIsTaken) {
  // The fake camera looks at the registers of selector 0.
  ReplaceNode("Enumeration", "TriggerSelector",
              Choice("TriggerSelector", {{"LightStart", 1}, {"ExposureStart", 0}}, "TriggerSelectorReg"));
  Start();
  OpenFeatures(kCamera)->Set("TriggerSelector", "LightStart");
  ExpectTriggers("ExposureStart");
}

TEST_F(VendorCameras, TriggersThatStartNoFrameAreNamed) {
  ReplaceNode("Enumeration", "TriggerSelector",
              Choice("TriggerSelector", {{"LightStart", 0}}, "TriggerSelectorReg"));
  Start();
  EXPECT_THAT(ErrorOf("trigger=software"), AllOf(HasSubstr("LightStart"), HasSubstr("leave trigger out")));
}

// By the names of its choices: their values are the camera's own business.
TEST_F(VendorCameras, BinningMayBeAChoice) {
  for (const char* axis : {"Horizontal", "Vertical"}) {
    const std::string name = std::string("Binning") + axis, reg = name + "Chosen";
    ReplaceNode("Integer", name, Choice(name, {{name + "1", 0}, {name + "2", 1}, {name + "4", 3}}, reg));
    Add(Register(reg, axis[0] == 'H' ? "0x10b0" : "0x10b4"));
    Replace("<pVariable Name=\"B\">" + name + "</pVariable><Formula>S/B</Formula>",
            "<pVariable Name=\"B\">" + reg + "</pVariable><Formula>S/(B+1)</Formula>");
  }
  Start();
  const SensorWindow window = *OpenDriver(std::string(kCamera) + "?binning=2x4&roi=512x256+64+32")->Window();
  EXPECT_EQ(window.binning_x, 2);
  EXPECT_EQ(window.binning_y, 4);
  EXPECT_EQ(window.width, 1024);
  EXPECT_EQ(window.sensor_width, 2048);
  EXPECT_EQ(ValueOf("BinningHorizontal"), "BinningHorizontal2");
  EXPECT_THAT(ErrorOf("binning=3x1"), AllOf(HasSubstr("binning=3"), HasSubstr("BinningHorizontal4")));
  EXPECT_EQ(OpenDriver(kSmall)->Window()->binning_y, 1) << "what the last program set is undone";
}

}  // namespace
}  // namespace ulf::test::vendor_cameras_test
