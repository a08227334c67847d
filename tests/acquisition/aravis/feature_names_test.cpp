// Tests: acquisition/aravis/feature_names, acquisition/aravis/aravis_description, acquisition/aravis/genicam_file.
//
// What cameras of many makers call exposure, gain, pixel format, trigger and white balance is found by the lookup that the
// driver uses, without a camera. With ULF_GENICAM_XML=FOLDER the descriptions in that folder are looked at as well, and a
// table of all is printed.
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
#include "core/image/pixel_format.h"
#include "tests/support/test_paths.h"

namespace ulf::acquisition {
namespace {

namespace fs = std::filesystem;

// A description with these features: "i ", "f ", "c ", "e " before a name make it a whole number, a decimal, a command, an
// enumeration with the choices behind a colon.
std::string DescriptionWith(const std::string& vendor, const std::vector<std::string>& features) {
  std::string nodes;
  for (const std::string& feature : features) {
    const std::string name = feature.substr(2, feature.find(':') - 2);
    switch (feature[0]) {
      case 'i':
        nodes += fmt::format("<Integer Name=\"{}\"><Value>1</Value></Integer>\n", name);
        break;
      case 'f':
        nodes += fmt::format("<Float Name=\"{}\"><Value>1.0</Value></Float>\n", name);
        break;
      case 'c':
        nodes += fmt::format(
            "<Command Name=\"{}\"><Value>1</Value><CommandValue>1</CommandValue></Command>\n", name);
        break;
      default: {
        nodes += fmt::format("<Enumeration Name=\"{}\">", name);
        std::size_t at = feature.find(':');
        for (int value = 0; at != std::string::npos; ++value) {
          const std::size_t next = feature.find(',', at + 1);
          nodes +=
              fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>",
                          feature.substr(at + 1, next == std::string::npos ? next : next - at - 1), value);
          at = next;
        }
        nodes += "<Value>0</Value></Enumeration>\n";
      }
    }
  }
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

constexpr char kTriggers[] = "e TriggerSource:Line0,Software";

// As the makers' own descriptions name and type them (docs/devices_measured.md says which).
std::vector<Maker> Makers() {
  const std::string trigger = kTriggers;
  return {
      {"standard",
       {"f ExposureTime", "e ExposureAuto:Off,Continuous", "f Gain", "e GainAuto:Off", "e PixelFormat:Mono8",
        "e TriggerMode:Off,On", trigger, "c TriggerSoftware", "e BalanceWhiteAuto:Off,Once",
        "e BalanceRatioSelector:Red,Blue", "f BalanceRatio"},
       {.exposure = "ExposureTime",
        .gain_db = "Gain",
        .gain_raw = "",
        .software_source = "Software",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "BalanceRatio"}},
      {"Basler",
       {"f ExposureTimeAbs", "i ExposureTimeRaw", "i GainRaw", "e PixelFormat:Mono8", "e TriggerMode:Off,On",
        trigger, "c TriggerSoftware", "e BalanceWhiteAuto:Off,Once", "e BalanceRatioSelector:Red,Blue",
        "f BalanceRatioAbs", "i BalanceRatioRaw"},
       {.exposure = "ExposureTimeAbs",
        .gain_db = "",
        .gain_raw = "GainRaw",
        .software_source = "Software",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "BalanceRatioAbs"}},
      {"Prosilica",
       {"f ExposureTimeAbs", "i GainRaw", "e PixelFormat:Mono8", "e TriggerMode:Off,On", trigger,
        "c TriggerSoftware", "e BalanceWhiteAuto:Off,Once", "e BalanceRatioSelector:Red,Blue",
        "f BalanceRatioAbs"},
       {.exposure = "ExposureTimeAbs",
        .gain_db = "",
        .gain_raw = "GainRaw",
        .software_source = "Software",
        .white_balance_auto = "BalanceWhiteAuto",
        .balance_ratio = "BalanceRatioAbs"}},
      {"PCO",
       {"f ExposureTimeAbs", "e PixelFormat:Mono16", "e TriggerMode:Off,On",
        "e TriggerSource:ExtTrig,SoftTrigger,ExtTrigAndAcqEnbl", "c TriggerSoftware"},
       {.exposure = "ExposureTimeAbs",
        .gain_db = "",
        .gain_raw = "",
        .software_source = "SoftTrigger",
        .white_balance_auto = "",
        .balance_ratio = ""}},
      {"Mikrotron",
       {"i ExposureTime", "e PixelFormat:Mono8", "e TriggerMode:Off,On",
        "e TriggerSource:Software,LinkTrigger0,Line0", "c TriggerSoftware"},
       {.exposure = "ExposureTime",
        .gain_db = "",
        .gain_raw = "",
        .software_source = "Software",
        .white_balance_auto = "",
        .balance_ratio = ""}},
      {"raw alone",
       {"i ExposureTimeRaw", "i Gain", "e PixelFormat:Mono8"},
       {.exposure = "ExposureTimeRaw",
        .gain_db = "",
        .gain_raw = "Gain",
        .software_source = "",
        .white_balance_auto = "",
        .balance_ratio = ""}},
  };
}

TEST(FeatureNames, AreFoundUnderEachMakersNames) {
  const test::ScratchFolder scratch;
  for (const Maker& maker : Makers()) {
    const fs::path file = scratch / "camera.xml";
    std::ofstream(file) << DescriptionWith(maker.name, maker.features);
    const GenicamFile read = ReadGenicamFile(file);
    EXPECT_EQ(read.vendor, maker.name);
    EXPECT_EQ(read.features, maker.features.size()) << maker.name;
    const FeatureNames& found = read.names;
    EXPECT_EQ(found.exposure, maker.found.exposure) << maker.name;
    EXPECT_EQ(found.gain_db, maker.found.gain_db) << maker.name;
    EXPECT_EQ(found.gain_raw, maker.found.gain_raw) << maker.name;
    EXPECT_EQ(found.software_source, maker.found.software_source) << maker.name;
    EXPECT_EQ(found.white_balance_auto, maker.found.white_balance_auto) << maker.name;
    EXPECT_EQ(found.balance_ratio, maker.found.balance_ratio) << maker.name;
    EXPECT_EQ(found.pixel_format, "PixelFormat") << maker.name;
    EXPECT_EQ(found.CanTrigger(), maker.name != "raw alone");
  }
  std::ofstream(scratch / "none.xml") << "<html/>";
  EXPECT_THROW(ReadGenicamFile(scratch / "none.xml"), Error);
}

std::string OrNone(const std::string& name) { return name.empty() ? "-" : name; }

std::string RowOf(const GenicamFile& read) {
  const FeatureNames& names = read.names;
  const auto supported =
      std::count_if(read.pixel_formats.begin(), read.pixel_formats.end(),
                    [](const std::string& name) { return PixelFormatByName(name).has_value(); });
  return fmt::format("| {} | {} | {} | {} | {} | {} of {} | {} | {} |", read.vendor, read.model,
                     read.features, OrNone(names.exposure),
                     OrNone(names.gain_db.empty() ? names.gain_raw : names.gain_db), supported,
                     read.pixel_formats.size(),
                     names.CanTrigger() ? names.trigger_source + "=" + OrNone(names.software_source) : "-",
                     OrNone(names.balance_ratio.empty() ? names.white_balance_auto : names.balance_ratio));
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
      "| maker | model | features | exposure | gain | formats | software trigger | white balance |\n";
  for (std::size_t i = 0; i < files.size(); ++i) {
    GenicamFile read;
    ASSERT_NO_THROW(read = ReadGenicamFile(files[i])) << files[i];
    table += RowOf(read) + "\n";
    EXPECT_GT(read.features, 0u) << files[i];
    if (i >= ours) continue;  // a camera may lack any of the following
    EXPECT_FALSE(read.names.exposure.empty()) << files[i];
    EXPECT_FALSE(read.names.gain_db.empty()) << files[i];
    EXPECT_FALSE(read.names.software_source.empty()) << files[i];
    EXPECT_FALSE(read.pixel_formats.empty()) << files[i];
  }
  if (files.size() > ours) fmt::print("{}", table);
}

}  // namespace
}  // namespace ulf::acquisition
