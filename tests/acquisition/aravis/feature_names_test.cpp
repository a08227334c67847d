// Tests: acquisition/aravis/feature_names, acquisition/aravis/aravis_description,
// acquisition/aravis/genicam_file.
//
// What cameras of many makers call exposure, gain, pixel format, trigger and white balance is found by the
// lookup that the driver uses, without a camera. With ULF_GENICAM_XML=FOLDER the descriptions in that folder
// are looked at as well, and a table of all is printed.
#include "acquisition/aravis/feature_names.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "acquisition/aravis/genicam_file.h"
#include "acquisition/simulator/gige/genicam_description.h"
#include "core/base/error.h"
#include "core/frames/pixel_format.h"
#include "tests/support/test_paths.h"

namespace ulf::acquisition::feature_names_test {
namespace {

namespace fs = std::filesystem;

// A description with these features: "i ", "f ", "c ", "e ", "k ", "v " before a name make it a whole number,
// a decimal, a command, an enumeration with the choices behind a colon, a category, a converter. Behind a bar
// stands a number's unit, behind another one its smallest value.
std::string NodeOf(const std::string& feature) {
  const std::string name = feature.substr(2, feature.find_first_of(":|") - 2);
  std::string more;
  if (const std::size_t bar = feature.find('|'); bar != std::string::npos) {
    const std::size_t second = feature.find('|', bar + 1);
    const std::string unit = feature.substr(bar + 1, second == std::string::npos ? second : second - bar - 1);
    if (second != std::string::npos) more += fmt::format("<Min>{}</Min>", feature.substr(second + 1));
    if (!unit.empty()) more += fmt::format("<Unit>{}</Unit>", unit);
  }
  switch (feature[0]) {
    case 'i':
      return fmt::format("<Integer Name=\"{}\"><Value>1</Value>{}</Integer>\n", name, more);
    case 'f':
      return fmt::format("<Float Name=\"{}\"><Value>1.0</Value>{}</Float>\n", name, more);
    case 'c':
      return fmt::format("<Command Name=\"{}\"><Value>1</Value><CommandValue>1</CommandValue></Command>\n",
                         name);
    case 'k':
      return fmt::format("<Category Name=\"{}\"></Category>\n", name);
    case 'v':
      return fmt::format(
          "<Converter Name=\"{}\"><FormulaTo>FROM</FormulaTo><FormulaFrom>TO</FormulaFrom>"
          "<pValue>Nothing</pValue></Converter>\n",
          name);
    default: {
      std::string node = fmt::format("<Enumeration Name=\"{}\">", name);
      std::size_t at = feature.find(':');
      for (int value = 0; at != std::string::npos; ++value) {
        const std::size_t next = feature.find(',', at + 1);
        node += fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>",
                            feature.substr(at + 1, next == std::string::npos ? next : next - at - 1), value);
        at = next;
      }
      return node + "<Value>0</Value></Enumeration>\n";
    }
  }
}

std::string DescriptionWith(const std::string& vendor, const std::vector<std::string>& features) {
  std::string nodes;
  for (const std::string& feature : features) nodes += NodeOf(feature);
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<RegisterDescription ModelName=\"M\" VendorName=\"{}\" "
      "StandardNameSpace=\"GEV\" SchemaMajorVersion=\"1\" SchemaMinorVersion=\"0\" "
      "SchemaSubMinorVersion=\"1\" "
      "MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" ToolTip=\"\" ProductGuid=\"0\" "
      "VersionGuid=\"0\" "
      "xmlns=\"http://www.genicam.org/GenApi/Version_1_0\">\n{}</RegisterDescription>\n",
      vendor, nodes);
}

struct Maker {
  std::string name;
  std::vector<std::string> features;
  FeatureNames found;
};

// As the makers' own descriptions name and type them (docs/measured/cameras.md says which). What was not read
// there is left out here, but for PixelFormat, which the standard demands. The library drives GigE Vision and
// USB3 Vision; of CoaXPress cameras it reads the description alone.
std::vector<Maker> Makers() {
  return {
      {"SFNC 2",
       {"f ExposureTime|us", "e ExposureAuto:Off,Continuous", "f Gain|dB|0", "e GainAuto:Off",
        "e PixelFormat:Mono8", "e TriggerMode:Off,On", "e TriggerSource:Line0,Software", "c TriggerSoftware",
        "e BalanceWhiteAuto:Off,Once", "e BalanceRatioSelector:Red,Blue", "f BalanceRatio",
        "i DeviceLinkThroughputLimit|Bps"},
       {.exposure = "ExposureTime",
        .gain = "Gain",
        .software_source = "Software",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "BalanceRatio",
        .throughput_limit = "DeviceLinkThroughputLimit"}},
      {"Basler acA1300",
       {"f ExposureTimeAbs|us", "i ExposureTimeRaw", "e ExposureAuto:Off,Once,Continuous", "i GainRaw",
        "e GainSelector:AnalogAll,DigitalAll,All,Tap1,Tap2", "i BlackLevelRaw",
        "f AcquisitionFrameRateAbs|Hz", "e PixelFormat:Mono8,Mono12Packed", "e TriggerMode:Off,On",
        "e TriggerSource:Software,Line1,Line4,CC1,Action1", "e TriggerActivation:RisingEdge,FallingEdge",
        "c TriggerSoftware", "e BalanceRatioSelector:Red,Green,Blue", "f BalanceRatioAbs",
        "i BalanceRatioRaw"},
       {.exposure = "ExposureTimeAbs",
        .gain_raw = "GainRaw",
        .gain_of_all = "All",
        .software_source = "Software",
        .balance_ratio = "BalanceRatioAbs"}},
      {"Allied Vision Prosilica GC",
       {"f ExposureTimeAbs", "i ExposureValue", "e ExposureAuto:other,Off,Continuous,Once", "k Exposure",
        "k Gain", "i GainRaw", "e GainSelector:All", "e GainAuto:Off,Continuous,Once",
        "v AcquisitionFrameRateAbs", "e PixelFormat:Mono8,BayerGR8,RGB8Packed,YUV422Packed",
        "e TriggerSelector:FrameStart,AcquisitionStart,AcquisitionEnd,AcquisitionRecord",
        "e TriggerMode:Off,On", "e TriggerSource:Freerun,Line1,Line2,Line3,Line4,FixedRate,Software",
        "c TriggerSoftware", "e TriggerActivation:RisingEdge,FallingEdge", "e BalanceRatioSelector:Red,Blue",
        "f BalanceRatioAbs", "e BalanceWhiteAuto:Off,Continuous,Once", "i StreamBytesPerSecond||1000000"},
       {.exposure = "ExposureTimeAbs",
        .gain_raw = "GainRaw",
        .gain_of_all = "All",
        .software_source = "Software",
        .frame_trigger = "FrameStart",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "BalanceRatioAbs",
        .throughput_limit = "StreamBytesPerSecond"}},
      {"Allied Vision Mako",
       {"f ExposureTimeAbs", "i ExposureValue", "e PixelFormat:Mono8",
        "e TriggerSource:Freerun,Line1,Line2,FixedRate,Software", "c TriggerSoftware", "f TriggerDelayAbs"},
       {.exposure = "ExposureTimeAbs", .software_source = "Software"}},
      {"Point Grey Flea3 GE",
       {"f ExposureTime|us", "e ExposureAuto:Off,Once,Continuous", "f Gain|dB",
        "e GainAuto:Off,Once,Continuous", "f BlackLevel|percent", "e PixelFormat:Mono8,BayerGR8",
        "e TriggerSelector:ExposureStart,ExposureActive", "e TriggerMode:Off,On",
        "e TriggerSource:Line0,Line1,Line2,Line3,Software", "c TriggerSoftware",
        "e TriggerActivation:FallingEdge,RisingEdge", "e BalanceRatioSelector:Red,Green,Blue",
        "f BalanceRatioRaw", "e BalanceWhiteAuto:Off,Once,Continuous"},
       {.exposure = "ExposureTime",
        .gain = "Gain",
        .software_source = "Software",
        .frame_trigger = "ExposureStart",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "BalanceRatioRaw"}},
      {"FLIR Blackfly S",
       {"f ExposureTime", "e ExposureAuto:Off,Once,Continuous", "f Gain", "e GainSelector:All",
        "e GainAuto:Off,Once,Continuous", "f BlackLevel", "i BlackLevelRaw", "e PixelFormat:Mono8,BayerRG8",
        "e TriggerSelector:AcquisitionStart,FrameStart,FrameBurstStart", "e TriggerMode:Off,On",
        "c TriggerSoftware", "e TriggerSource:Line0,Line1,Counter0Start,Action0,Software",
        "e TriggerActivation:LevelLow,RisingEdge", "e BalanceRatioSelector:Red,Blue", "f BalanceRatio",
        "e BalanceWhiteAuto:Off,Once,Continuous", "i DeviceLinkThroughputLimit", "i DeviceMaxThroughput"},
       // Its units were not read, without which a gain is one of its own.
       {.exposure = "ExposureTime",
        .gain_raw = "Gain",
        .gain_of_all = "All",
        .software_source = "Software",
        .frame_trigger = "FrameStart",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "BalanceRatio",
        .throughput_limit = "DeviceLinkThroughputLimit"}},
      {"FLIR SC6700",
       {"e PixelFormat:Mono8,Mono16", "e AcquisitionMode:Continuous,SingleFrame", "c AcquisitionStart",
        "c AcquisitionStop", "i GevSCPSPacketSize", "i GevSCPD"},
       {}},
      {"The Imaging Source DMK 33GX174",
       {"f ExposureTime|us|30", "f ExposureTimeAbs", "i ExposureTimeRaw", "e ExposureAuto:Off,Continuous",
        "f Gain|dB|0", "e GainAuto:Off,Continuous", "f BlackLevel", "e PixelFormat:Mono8,Mono12Packed,Mono16",
        "e TriggerSelector:FrameStart,ExposureActive", "e TriggerMode:Off,On",
        "e TriggerSource:Line1,Software,Action0,Any", "c TriggerSoftware", "f AcquisitionFrameRate|Hz"},
       {.exposure = "ExposureTime",
        .gain = "Gain",
        .software_source = "Software",
        .frame_trigger = "FrameStart"}},
      {"Mikrotron MC206xS11 (CoaXPress)",
       {"i ExposureTime", "e AnalogGain", "f DigitalGain||1.00", "i AcquisitionFrameRate",
        "e PixelFormat:Mono8,Mono10", "e TriggerSelector:FrameStart", "e TriggerMode:Off,On",
        "e TriggerSource:Software,LinkTrigger0,Line0,Line1", "c TriggerSoftware"},
       {.exposure = "ExposureTime", .software_source = "Software", .frame_trigger = "FrameStart"}},
      {"Adimec Q-12A180 (CoaXPress)",
       {"f ExposureTime|us|1", "i ExposureTimeRaw", "e ExposureMode:Timed,TriggerWidth,TimedTriggerControl",
        "e PixelFormat:Mono8", "e TriggerSource", "e TriggerActivation:FallingEdge,RisingEdge",
        "i InterfaceUtilization||50"},
       {.exposure = "ExposureTime"}},
      {"Vieworks VNP-604 (CoaXPress)",
       {"f ExposureTime|us", "e PixelFormat:Mono8", "e TriggerSelector:ExposureStart", "e TriggerMode:Off,On",
        "c TriggerSoftware", "e TriggerSource:Software,UserOutput0,CXPin,Timer0Active,Line0",
        "e GainSelector:All,AnalogAll,DigitalAll", "f Gain", "f BlackLevel",
        "e BalanceRatioSelector:Red,Green,Blue", "f BalanceRatio", "e BalanceWhiteAuto:Off,Once,Continuous",
        "f DeviceLinkThroughputLimit|MBps", "f DeviceLinkSpeed|MBps"},
       // Its gain has no unit, and its limits are registers.
       {.exposure = "ExposureTime",
        .gain_raw = "Gain",
        .gain_of_all = "All",
        .software_source = "Software",
        .frame_trigger = "ExposureStart",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "BalanceRatio",
        .throughput_limit = "DeviceLinkThroughputLimit",
        .throughput_bytes = 1e6}},
      {"Tucsen Dhyana 6060BSI (CoaXPress)",
       {"i AcquisitionExpTime", "e GainMode:HDR_16bit,HG_12bit,LG_12bit", "i BlackLevel",
        "e PixelFormat:Mono12,Mono14,Mono16", "e AcquisitionTrigMode:FreeRunning,Standard,Software,Gps",
        "c TrigSoftwareSignal", "f AcquisitionFrameRate|Hz"},
       {.exposure = "AcquisitionExpTime"}},
      {"Hamamatsu C16240-20UP (CoaXPress)",
       {"f ExposureTime|s", "e PixelFormat:Mono8,Mono12,Mono16"},
       {.exposure = "ExposureTime", .exposure_us = 1e6}},
      {"Teledyne Shad-o-Box HS",
       {"i ExtendedExposure", "i FrameInterval", "f FrameRate", "e DigitalGain:ONEX,TWOX",
        "e PixelFormat:Mono16", "e SynchronizationMode:FreeRunning,ExtTrigger,Snapshot", "c SoftwareTrigger"},
       {}},
      {"Hikrobot MV-CA013-A0UM",
       {"f ExposureTime", "f ExposureTimeRaw|us", "e ExposureAuto:Off,Once,Continuous", "e PixelFormat:Mono8",
        "e TriggerMode:Off,On", "c TriggerSoftware",
        "e TriggerSource:Line0,Line1,Line2,Line3,Counter0,Software,FrequencyConverter,Action1,Anyway",
        "e TriggerActivation:RisingEdge,FallingEdge",
        "e BinningHorizontal:BinningHorizontal1,BinningHorizontal2", "e DeviceLinkThroughputLimitMode:Off,On",
        "i DeviceLinkThroughputLimit|KB"},
       {.exposure = "ExposureTime",
        .software_source = "Software",
        .throughput_limit = "DeviceLinkThroughputLimit",
        .throughput_bytes = 1e3,
        .throughput_mode = "DeviceLinkThroughputLimitMode"}},
      {"Imperx",
       {"i ExposureTimeRaw", "e ExposureMode:Off,Timed,TriggerWidth,IOExposureControl", "e PixelFormat:Mono8",
        "e TriggerMode:Off,On", "c TriggerSoftware",
        "e TriggerSource:Software,External,PulseGenerator,TimerTrigger",
        "e TriggerActivation:RisingEdge,FallingEdge", "i TriggerDelayRaw"},
       {.exposure = "ExposureTimeRaw", .software_source = "Software"}},
      {"IDS UI-322xCP-M",
       {"f ExposureTime|us", "e ExposureAuto:Off,Continuous", "f Gain||1",
        "e GainSelector:All,Red,Green,Blue", "e GainAuto:Off,Continuous", "e BalanceWhiteAuto:Off,Continuous",
        "e PixelFormat:Mono8", "e TriggerSource:Software,UserOutput3", "c TriggerSoftware",
        "e TriggerActivation:RisingEdge,FallingEdge", "f BlackLevel"},
       {.exposure = "ExposureTime",
        .gain = "Gain",
        .gain_is_factor = true,
        .gain_of_all = "All",
        .software_source = "Software",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "Gain",
        .balance_is_gain = true}},
      {"Huaray DS5131MG30CE",
       {"e PixelFormat:Mono8", "e TriggerSelector:ExposureStart,LightStart",
        "e TriggerType:FreeRun,SingleFrame", "e TriggerMode:Off,On",
        "e TriggerSource:Software,Line0,Line1,Line2", "c TriggerSoftware",
        "e TriggerActivation:RisingEdgeOrHighLevel,FallingEdgeOrLowLevel", "f FrameRate|Hz|0.5"},
       {.software_source = "Software", .frame_trigger = "ExposureStart"}},
      {"PCO 1600",
       {"f ExposureTimeAbs", "e PixelFormat:Mono16", "e TriggerMode:Off,On",
        "e TriggerSource:ExtTrig,SoftTrigger,ExtTrigAndAcqEnbl", "c TriggerSoftware"},
       {.exposure = "ExposureTimeAbs", .software_source = "SoftTrigger"}},
  };
}

TEST(FeatureNames, AreFoundUnderEachMakersNames) {
  const test::ScratchFolder scratch;
  for (const Maker& maker : Makers()) {
    const fs::path file = scratch / "camera.xml";
    std::ofstream(file) << DescriptionWith(maker.name, maker.features);
    const GenicamFile read = ReadGenicamFile(file);
    EXPECT_EQ(read.vendor, maker.name);
    EXPECT_EQ(read.features, static_cast<std::size_t>(
                                 std::count_if(maker.features.begin(), maker.features.end(),
                                               [](const std::string& feature) { return feature[0] != 'k'; })))
        << maker.name << ", categories aside";
    const FeatureNames& found = read.names;
    EXPECT_EQ(found.exposure, maker.found.exposure) << maker.name;
    EXPECT_EQ(found.exposure_us, maker.found.exposure_us) << maker.name;
    EXPECT_EQ(found.gain, maker.found.gain) << maker.name;
    EXPECT_EQ(found.gain_is_factor, maker.found.gain_is_factor) << maker.name;
    EXPECT_EQ(found.gain_raw, maker.found.gain_raw) << maker.name;
    EXPECT_EQ(found.gain_of_all, maker.found.gain_of_all) << maker.name;
    EXPECT_EQ(found.software_source, maker.found.software_source) << maker.name;
    EXPECT_EQ(found.frame_trigger, maker.found.frame_trigger) << maker.name;
    EXPECT_EQ(found.white_balance_auto, maker.found.white_balance_auto) << maker.name;
    EXPECT_EQ(found.balance_ratio, maker.found.balance_ratio) << maker.name;
    EXPECT_EQ(found.balance_is_gain, maker.found.balance_is_gain) << maker.name;
    EXPECT_EQ(found.throughput_limit, maker.found.throughput_limit) << maker.name;
    EXPECT_EQ(found.throughput_bytes, maker.found.throughput_bytes) << maker.name;
    EXPECT_EQ(found.throughput_mode, maker.found.throughput_mode) << maker.name;
    EXPECT_EQ(found.pixel_format, "PixelFormat") << maker.name;
  }
  std::ofstream(scratch / "none.xml") << "<html/>";
  EXPECT_THROW(ReadGenicamFile(scratch / "none.xml"), Error);
}

FeatureNames FoundIn(const std::vector<std::string>& features) {
  const test::ScratchFolder scratch;
  std::ofstream(scratch / "camera.xml") << DescriptionWith("V", features);
  return ReadGenicamFile(scratch / "camera.xml").names;
}

TEST(FeatureNames, UnusualUnitsAreNotMistaken) {
  for (const auto& [unit, microseconds] :
       {std::pair("", 1.0), std::pair("us", 1.0), std::pair("\u00b5s", 1.0), std::pair("ms", 1e3),
        std::pair("s", 1e6)})
    EXPECT_EQ(FoundIn({fmt::format("f ExposureTime|{}", unit)}).exposure_us, microseconds) << unit;
  EXPECT_EQ(FoundIn({"f ExposureTime|lines"}).exposure, "");
  EXPECT_EQ(FoundIn({"f ExposureTime|lines", "i ExposureTimeRaw|ms"}).exposure, "ExposureTimeRaw");
  EXPECT_EQ(FoundIn({"f Gain|dB"}).gain, "Gain");
  EXPECT_FALSE(FoundIn({"f Gain|dB|1"}).gain_is_factor);
  EXPECT_EQ(FoundIn({"i GainRaw|dB"}).gain, "GainRaw");
  for (const char* unknown : {"f Gain", "f Gain||0", "f Gain|steps|1"}) {
    EXPECT_EQ(FoundIn({unknown}).gain, "") << unknown;
    EXPECT_EQ(FoundIn({unknown}).gain_raw, "Gain") << unknown;
  }
  EXPECT_TRUE(FoundIn({"f Gain||1"}).gain_is_factor);
  for (const auto& [unit, bytes] : {std::pair("", 1.0), std::pair("Bps", 1.0), std::pair("KB", 1e3),
                                    std::pair("MBps", 1e6), std::pair("Mbps", 0.0)})
    EXPECT_EQ(FoundIn({fmt::format("f DeviceLinkThroughputLimit|{}", unit)}).throughput_bytes, bytes) << unit;
}

std::string OrNone(const std::string& name) { return name.empty() ? "-" : name; }

std::string RowOf(const GenicamFile& read) {
  const FeatureNames& names = read.names;
  const auto supported =
      std::count_if(read.pixel_formats.begin(), read.pixel_formats.end(),
                    [](const std::string& name) { return PixelFormatByName(name).has_value(); });
  return fmt::format("| {} | {} | {} | {} | {} us | {} | {} of {} | {} | {} |", read.vendor, read.model,
                     read.features, OrNone(names.exposure), names.exposure_us,
                     OrNone(names.gain.empty() ? names.gain_raw : names.gain), supported,
                     read.pixel_formats.size(),
                     names.CanTrigger() ? names.trigger_source + "=" + OrNone(names.software_source) : "-",
                     OrNone(names.balance_ratio.empty() ? names.white_balance_auto : names.balance_ratio));
}

// Of the Aravis project, no dumps of cameras.
TEST(GenicamFiles, DescriptionsByOthersAreUnderstood) {
  ULF_NEED_TEST_DATA(folder, "genicam_xml");
  const GenicamFile fake = ReadGenicamFile(folder / "src/arv-fake-camera.xml");
  EXPECT_EQ(fake.vendor, "Aravis");
  EXPECT_EQ(fake.names.exposure, "ExposureTimeAbs");
  EXPECT_EQ(fake.names.gain_raw, "GainRaw");
  EXPECT_EQ(fake.names.software_source, "Software");
  EXPECT_EQ(fake.names.frame_trigger, "FrameStart");
  EXPECT_GT(fake.features, 30u);
  const GenicamFile webcam = ReadGenicamFile(folder / "src/arv-v4l2.xml");
  EXPECT_EQ(webcam.model, "V4L2");
  EXPECT_EQ(webcam.names.exposure, "ExposureTimeAbs");
  EXPECT_EQ(webcam.names.software_source, "") << "it has none";
  const GenicamFile unusual = ReadGenicamFile(folder / "tests/data/genicam.xml");
  EXPECT_EQ(unusual.vendor, "Emmanuel");
  EXPECT_EQ(unusual.names.exposure, "");
}

// Ours always; others' where there are any.
TEST(GenicamFiles, LoadAndAreUnderstood) {
  const test::ScratchFolder scratch;
  std::ofstream(scratch / "simulated.xml") << GenicamDescription();
  std::vector<fs::path> files{scratch / "simulated.xml", FULL_CAMERA};
  const std::size_t ours = files.size();
  if (const char* folder = std::getenv("ULF_GENICAM_XML"))
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.path().extension() == ".xml") files.push_back(entry.path());
  std::sort(files.begin() + static_cast<std::ptrdiff_t>(ours), files.end());
  std::string table =
      "| maker | model | features | exposure | one of it | gain | formats | software trigger | white balance "
      "|\n";
  for (std::size_t i = 0; i < files.size(); ++i) {
    GenicamFile read;
    ASSERT_NO_THROW(read = ReadGenicamFile(files[i])) << files[i];
    table += RowOf(read) + "\n";
    EXPECT_GT(read.features, 0u) << files[i];
    if (i >= ours) continue;  // a camera may lack any of the following
    EXPECT_FALSE(read.names.exposure.empty()) << files[i];
    EXPECT_FALSE(read.names.gain.empty()) << files[i];
    EXPECT_FALSE(read.names.software_source.empty()) << files[i];
    EXPECT_FALSE(read.pixel_formats.empty()) << files[i];
  }
  if (files.size() > ours) fmt::print("{}", table);
}

}  // namespace
}  // namespace ulf::acquisition::feature_names_test
