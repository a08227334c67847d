#include "acquisition/simulator/gige/genicam_description.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/simulator/gige/gige_registers.h"
#include "acquisition/simulator/sensor.h"

namespace ulf::acquisition {
namespace {

constexpr const char* kBegin = R"(<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription ModelName="HandheldSimulator" VendorName="ULF" StandardNameSpace="GEV"
  ToolTip="Simulated hand-held camera of ulf" SchemaMajorVersion="1" SchemaMinorVersion="0" SchemaSubMinorVersion="1"
  MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="7A0C1C52-3B1E-4B0B-9C55-0B0F53C6A001"
  VersionGuid="7A0C1C52-3B1E-4B0B-9C55-0B0F53C6A002" xmlns="http://www.genicam.org/GenApi/Version_1_0">
)";

constexpr const char* kEnd = R"(
  <Port Name="Device" NameSpace="Standard"/>
</RegisterDescription>
)";

using Names = std::vector<std::string>;
using Entries = std::vector<std::pair<std::string, std::string>>;  // name, value

std::string Description(const std::string& text) {
  return text.empty() ? "" : fmt::format("    <Description>{}</Description>\n", text);
}

// `space`: "Standard" for a name of the GenICam Standard Features Naming Convention, else "Custom".
std::string Node(const char* kind, const std::string& name, const char* space, const std::string& inside) {
  return fmt::format("  <{0} Name=\"{1}\" NameSpace=\"{2}\">\n{3}  </{0}>\n", kind, name, space, inside);
}

std::string Category(const std::string& name, const char* space, const Names& features) {
  std::string inside;
  for (const std::string& feature : features) inside += fmt::format("    <pFeature>{}</pFeature>\n", feature);
  return fmt::format("\n{}", Node("Category", name, space, inside));
}

std::string RegisterAt(const char* address, int bytes, const char* access) {
  return fmt::format(
      "    <Address>{}</Address><Length>{}</Length><AccessMode>{}</AccessMode><pPort>Device</pPort>\n",
      address, bytes, access);
}

std::string TextElement(const std::string& name, const char* address, int bytes) {
  return Node("StringReg", name, "Standard", RegisterAt(address, bytes, "RO"));
}

// An unsigned number of four bytes.
std::string Number(const std::string& name, const char* space, const char* address, const char* access,
                   const std::string& description = "", bool may_be_cached = true) {
  return Node("IntReg", name, space,
              Description(description) + RegisterAt(address, 4, access) +
                  (may_be_cached ? "" : "    <Cachable>NoCache</Cachable>\n") +
                  "    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>\n");
}

// A number that clients write, in a register of its own. `most` names the feature that limits it.
std::string Size(const std::string& name, const std::string& description, int least, const char* most,
                 const char* address) {
  return Node("Integer", name, "Standard",
              Description(description) +
                  fmt::format("    <pValue>{}Reg</pValue><Min>{}</Min><pMax>{}</pMax><Inc>2</Inc>\n", name,
                              least, most)) +
         Number(name + "Reg", "Custom", address, "RW");
}

std::string Enumeration(const std::string& name, const Entries& entries, const std::string& value,
                        const std::string& description = "", const char* selects = nullptr) {
  std::string inside = Description(description);
  for (const auto& [entry, number] : entries)
    inside += fmt::format("    <EnumEntry Name=\"{}\" NameSpace=\"Standard\"><Value>{}</Value></EnumEntry>\n",
                          entry, number);
  return Node("Enumeration", name, "Standard",
              inside + fmt::format("    <pValue>{}</pValue>\n", value) +
                  (selects ? fmt::format("    <pSelected>{}</pSelected>\n", selects) : ""));
}

std::string Choice(const std::string& name, const Entries& entries, const char* address,
                   const std::string& description = "") {
  return Enumeration(name, entries, name + "Reg", description) +
         Number(name + "Reg", "Custom", address, "RW");
}

std::string Command(const std::string& name, const char* value, int number) {
  return Node("Command", name, "Standard",
              fmt::format("    <pValue>{}</pValue><CommandValue>{}</CommandValue>\n", value, number));
}

// A real number that the register `reg` stores as a whole one. The formulas convert it to that and back.
struct Converted {
  const char* name;
  const char* space;
  const char* description;
  const char *least, *most, *unit;
  const char* converter;
  const char *to, *from;
  const char* reg;
  const char* address;
  int reg_least, reg_most;  // a converter without limits behind it converts 0 as well
};

std::string Real(const Converted& c) {
  const char* slope =
      std::string_view(c.to).find("/ FROM") == std::string_view::npos ? "Increasing" : "Decreasing";
  return Node("Float", c.name, c.space,
              Description(c.description) +
                  fmt::format("    <pValue>{}</pValue><Min>{}</Min><Max>{}</Max><Unit>{}</Unit>\n",
                              c.converter, c.least, c.most, c.unit)) +
         Node("Converter", c.converter, "Custom",
              fmt::format("    <FormulaTo>{}</FormulaTo><FormulaFrom>{}</FormulaFrom>\n"
                          "    <pValue>{}</pValue><Slope>{}</Slope>\n",
                          c.to, c.from, c.reg, slope)) +
         Node("Integer", c.reg, "Custom",
              fmt::format("    <pValue>{}At</pValue><Min>{}</Min><Max>{}</Max>\n", c.reg, c.reg_least,
                          c.reg_most)) +
         Number(fmt::format("{}At", c.reg), "Custom", c.address, "RW");
}

std::string Difference(const std::string& name, const char* all, const char* part) {
  return Node(
      "IntSwissKnife", name, "Custom",
      fmt::format("    <pVariable Name=\"ALL\">{}</pVariable><pVariable Name=\"PART\">{}</pVariable>\n"
                  "    <Formula>ALL - PART</Formula>\n",
                  all, part));
}

std::string At(std::uint32_t address) { return fmt::format("0x{:x}", address); }

std::string Switch(const std::string& name, const std::string& reg, const std::string& address) {
  return Node("Boolean", name, "Standard", fmt::format("    <pValue>{}</pValue>\n", reg)) +
         Number(reg, "Custom", address.c_str(), "RW");
}

// The states of a port, as IEEE 1588 numbers them.
std::string ClockControl() {
  return Switch("PtpEnable", "PtpEnableReg", At(kPtpEnableAt)) +
         Enumeration("PtpStatus",
                     {{"Initializing", "1"},
                      {"Faulty", "2"},
                      {"Disabled", "3"},
                      {"Listening", "4"},
                      {"PreMaster", "5"},
                      {"Master", "6"},
                      {"Passive", "7"},
                      {"Uncalibrated", "8"},
                      {"Slave", "9"}},
                     "PtpStatusReg") +
         Number("PtpStatusReg", "Custom", At(kPtpStatusAt).c_str(), "RO", "", false) +
         Command("PtpDataSetLatch", "PtpLatchReg", 1) +
         Number("PtpLatchReg", "Custom", At(kPtpLatchAt).c_str(), "RW") +
         Node("IntReg", "PtpOffsetFromMaster", "Standard",
              Description(
                  "Of the camera's clock from its master's at the last PtpDataSetLatch, in nanoseconds.") +
                  RegisterAt(At(kPtpOffsetAt).c_str(), 4, "RO") +
                  "    <Cachable>NoCache</Cachable>\n    "
                  "<Sign>Signed</Sign><Endianess>BigEndian</Endianess>\n");
}

std::string DeviceControl() {
  return Category("DeviceControl", "Standard",
                  {"DeviceVendorName", "DeviceModelName", "DeviceManufacturerInfo", "DeviceVersion",
                   "DeviceSerialNumber", "DeviceLinkThroughputLimitMode", "DeviceLinkThroughputLimit",
                   "PtpEnable", "PtpStatus", "PtpDataSetLatch", "PtpOffsetFromMaster"}) +
         TextElement("DeviceVendorName", "0x48", 32) + TextElement("DeviceModelName", "0x68", 32) +
         TextElement("DeviceVersion", "0x88", 32) + TextElement("DeviceManufacturerInfo", "0xa8", 48) +
         TextElement("DeviceSerialNumber", "0xd8", 16) +
         Choice("DeviceLinkThroughputLimitMode", {{"Off", "0"}, {"On", "1"}}, At(kThroughputModeAt).c_str()) +
         Node(
             "Integer", "DeviceLinkThroughputLimit", "Standard",
             Description("What the camera sends at most, in bytes a second.") +
                 fmt::format("    <pValue>ThroughputReg</pValue><Min>{}</Min><Max>{}</Max><Unit>Bps</Unit>\n",
                             kLeastThroughput, kMostThroughput)) +
         Number("ThroughputReg", "Custom", At(kThroughputLimitAt).c_str(), "RW") + ClockControl();
}

std::string ImageFormatControl() {
  Entries formats;
  for (int i = 0; i <= static_cast<int>(SensorFormat::kBgr8); ++i) {
    const PixelFormat& format = PixelsOf(static_cast<SensorFormat>(i));
    formats.emplace_back(format.name, fmt::format("0x{:08X}", format.code));
  }
  return Category("ImageFormatControl", "Standard",
                  {"SensorWidth", "SensorHeight", "Width", "Height", "OffsetX", "OffsetY", "PixelFormat"}) +
         Number("SensorWidth", "Standard", "0x11c", "RO", "Width of the sensor, in pixels.") +
         Number("SensorHeight", "Standard", "0x118", "RO", "Height of the sensor, in pixels.") +
         Size("Width", "Width of the part of the sensor that is sent, in pixels.", 16, "SensorWidth",
              "0x100") +
         Size("Height", "Height of the part of the sensor that is sent, in pixels.", 16, "SensorHeight",
              "0x104") +
         Size("OffsetX", "Left edge of the part that is sent, in pixels.", 0, "OffsetXMax", "0x130") +
         Difference("OffsetXMax", "SensorWidth", "Width") +
         Size("OffsetY", "Top edge of the part that is sent, in pixels.", 0, "OffsetYMax", "0x134") +
         Difference("OffsetYMax", "SensorHeight", "Height") +
         Choice("PixelFormat", formats, "0x128", "How a pixel is sent; all formats are linear in light.");
}

std::string AcquisitionControl() {
  return Category("AcquisitionControl", "Standard",
                  {"AcquisitionMode", "AcquisitionStart", "AcquisitionStop", "AcquisitionFrameRate",
                   "ExposureTime", "TriggerSelector", "TriggerMode", "TriggerSource", "TriggerSoftware",
                   "LinePulseRate"}) +
         Choice("AcquisitionMode", {{"Continuous", "1"}}, "0x12c") +
         Command("AcquisitionStart", "AcquisitionReg", 1) + Command("AcquisitionStop", "AcquisitionReg", 0) +
         Number("AcquisitionReg", "Custom", "0x124", "RW") +
         Real({"AcquisitionFrameRate", "Standard", "Frames per second of the free-running camera.", "0.1",
               "1000.0", "Hz", "FrameRateFromPeriod", "1000000.0 / FROM", "1000000.0 / TO", "FramePeriodReg",
               "0x138", 1'000, 10'000'000}) +
         Real({"ExposureTime", "Standard",
               "How long the shutter is open, in microseconds: more light, and more motion blur.", "10.0",
               "1000000.0", "us", "ExposureFromReg", "FROM", "TO", "ExposureReg", "0x120", 10, 1'000'000}) +
         Enumeration("TriggerSelector", {{"FrameStart", "0"}}, "TriggerSelectorValue") +
         "  <Integer Name=\"TriggerSelectorValue\" NameSpace=\"Custom\"><Value>0</Value></Integer>\n" +
         Choice("TriggerMode", {{"Off", "0"}, {"On", "1"}}, "0x300") +
         Choice("TriggerSource", {{"Line0", "0"}, {"Software", "1"}}, "0x1020") +
         Real({"LinePulseRate", "Custom", "Pulses a second on the simulated input Line0.", "0.1", "200.0",
               "Hz", "LineRateFromPeriod", "1000000.0 / FROM", "1000000.0 / TO", "LinePeriodReg", "0x1024",
               5'000, 10'000'000}) +
         Command("TriggerSoftware", "TriggerSoftwareReg", 1) +
         Number("TriggerSoftwareReg", "Custom", "0x30c", "RW");
}

// The register of the gain counts tenths of a decibel.
std::string AnalogControl() {
  return Category("AnalogControl", "Standard", {"Gain"}) +
         Real({"Gain", "Standard",
               "Amplification before the converter, in decibels (20 dB: ten times the number).", "0.0",
               "36.0", "dB", "GainFromReg", "FROM * 10.0", "TO / 10.0", "GainReg", "0x110", 0, 360});
}

std::string DigitalIOControl() {
  return Category("DigitalIOControl", "Standard", {"LineStatusAll"}) +
         Number("LineStatusAll", "Standard", At(kLineStatusAt).c_str(), "RO",
                "Bit 0: Line0, at the last frame.", false);
}

std::string ChunkDataControl() {
  Names features{"ChunkModeActive", "ChunkSelector", "ChunkEnable"};
  Entries selected;
  std::string values;
  for (std::size_t i = 0; i < kChunks.size(); ++i) {
    const SimulatedChunk& chunk = kChunks[i];
    const std::string name = fmt::format("Chunk{}", chunk.name);
    features.push_back(name);
    selected.emplace_back(chunk.name, fmt::format("{}", i));
    values += Node(chunk.is_real ? "FloatReg" : "IntReg", name, "Standard",
                   fmt::format("    <Address>0</Address><Length>{}</Length><AccessMode>RO</AccessMode>"
                               "<pPort>{}Port</pPort>\n{}    <Endianess>BigEndian</Endianess>\n",
                               kChunkValueBytes, name, chunk.is_real ? "" : "    <Sign>Unsigned</Sign>\n")) +
              Node("Port", name + "Port", "Custom", fmt::format("    <ChunkID>{:x}</ChunkID>\n", chunk.id));
  }
  return Category("ChunkDataControl", "Standard", features) +
         Switch("ChunkModeActive", "ChunkModeReg", At(kChunkModeAt)) +
         Enumeration("ChunkSelector", selected, "ChunkSelectorReg", "", "ChunkEnable") +
         Number("ChunkSelectorReg", "Custom", At(kChunkSelectorAt).c_str(), "RW") +
         Node("Boolean", "ChunkEnable", "Standard", "    <pValue>ChunkEnableReg</pValue>\n") +
         Node("IntReg", "ChunkEnableReg", "Custom",
              fmt::format("    <Address>{}</Address><pIndex Offset=\"4\">ChunkSelectorReg</pIndex>\n"
                          "    <Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>\n"
                          "    <Cachable>NoCache</Cachable>\n"
                          "    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>\n",
                          At(kChunkEnableAt))) +
         values;
}

// Describes the sets: how long the shutter is open, and which set follows.
std::string SequencerControl() {
  const auto set_number = [](const char* name, std::uint32_t address, const char* description) {
    return Node(
               "Integer", name, "Standard",
               Description(description) + fmt::format("    <pValue>{}Reg</pValue><Min>0</Min><Max>{}</Max>\n",
                                                      name, kSequencerSets - 1)) +
           Number(std::string(name) + "Reg", "Custom", At(address).c_str(), "RW");
  };
  const Entries off_on{{"Off", "0"}, {"On", "1"}};
  return Category("SequencerControl", "Standard",
                  {"SequencerMode", "SequencerConfigurationMode", "SequencerSetSelector", "SequencerSetSave",
                   "SequencerSetStart", "SequencerSetNext"}) +
         Choice("SequencerMode", off_on, At(kSequencerModeAt).c_str(),
                "On: each frame has the exposure time of the set whose turn it is.") +
         Choice("SequencerConfigurationMode", off_on, At(kSequencerConfigurationAt).c_str(),
                "On: sets can be saved, and the sequencer rests.") +
         set_number("SequencerSetSelector", kSequencerSelectorAt,
                    "The set that is saved, or whose next one is named.") +
         Command("SequencerSetSave", "SequencerSetSaveReg", 1) +
         Number("SequencerSetSaveReg", "Custom", At(kSequencerSaveAt).c_str(), "RW") +
         set_number("SequencerSetStart", kSequencerStartAt, "The set of the first frame.") +
         Node("Integer", "SequencerSetNext", "Standard",
              fmt::format("    <pValue>SequencerSetNextReg</pValue><Min>0</Min><Max>{}</Max>\n",
                          kSequencerSets - 1)) +
         Node("IntReg", "SequencerSetNextReg", "Custom",
              fmt::format("    <Address>{}</Address><pIndex Offset=\"4\">SequencerSetSelectorReg</pIndex>\n"
                          "    <Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>\n"
                          "    <Cachable>NoCache</Cachable>\n"
                          "    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>\n",
                          At(kSequencerNextAt)));
}

// What chunk data add to the payload: each that is switched on, and the image's own entry.
std::string ChunkPayload() {
  std::string registers, variables, formula;
  for (std::size_t i = 0; i < kChunks.size(); ++i) {
    registers += Number(fmt::format("Chunk{}On", kChunks[i].name), "Custom",
                        At(kChunkEnableAt + 4 * static_cast<std::uint32_t>(i)).c_str(), "RW", "", false);
    variables += fmt::format("    <pVariable Name=\"C{}\">Chunk{}On</pVariable>\n", i, kChunks[i].name);
    formula += fmt::format("{}C{}", i == 0 ? "" : " + ", i);
  }
  return registers + Node("IntSwissKnife", "ChunkPayload", "Custom",
                          "    <pVariable Name=\"ON\">ChunkModeReg</pVariable>\n" + variables +
                              fmt::format("    <Formula>ON * ({} + {} * ({}))</Formula>\n", kImageChunkBytes,
                                          kChunkBytes, formula));
}

std::string LastFrame() {
  const auto fact = [](const char* name, const char* address, const char* description) {
    return Number(name, "Custom", address, "RO", description, false);
  };
  return Category("LastFrame", "Custom",
                  {"LastFrameId", "LastFrameNumber", "LastExposureTime", "LastGain", "LastHandTime"}) +
         fact("LastFrameId", "0x1000", "Number that the last frame was sent with: 16 bits.") +
         fact("LastFrameNumber", "0x1004", "Frames taken, counted from 1.") +
         fact("LastExposureTime", "0x1008", "Exposure of the last frame, in microseconds.") +
         fact("LastGain", "0x100c", "Gain of the last frame, in tenths of a decibel.") +
         fact("LastHandTime", "0x1010",
              "Time of the simulated hand's motion at the last frame, in milliseconds.");
}

// The payload's size follows from the bits per pixel: bits 16 to 23 of a format's code (PFNC).
std::string TransportLayerControl() {
  return Category("TransportLayerControl", "Standard",
                  {"PayloadSize", "GevSCPD", "GevTimestampTickFrequency"}) +
         Number("GevSCPD", "Standard", At(kPacketDelayAt).c_str(), "RW",
                "Pause between two packets, in ticks of GevTimestampTickFrequency.", false) +
         Number("GevTimestampTickFrequency", "Standard", At(kTickFrequencyAt + 4).c_str(), "RO") +
         Node("IntSwissKnife", "PayloadSize", "Standard",
              "    <pVariable Name=\"W\">Width</pVariable><pVariable Name=\"H\">Height</pVariable>\n"
              "    <pVariable Name=\"CODE\">PixelFormatReg</pVariable>\n"
              "    <pVariable Name=\"CHUNKS\">ChunkPayload</pVariable>\n"
              "    <Formula>W * H * ((CODE >> 16) &amp; 0xFF) / 8 + CHUNKS</Formula>\n") +
         ChunkPayload() +
         Node("Integer", "TLParamsLocked", "Standard",
              "    <Visibility>Invisible</Visibility><Value>0</Value><Min>0</Min><Max>1</Max>\n");
}

}  // namespace

const std::string& GenicamDescription() {
  static const std::string description =
      kBegin +
      Category(
          "Root", "Standard",
          {"DeviceControl", "ImageFormatControl", "AcquisitionControl", "AnalogControl", "DigitalIOControl",
           "SequencerControl", "ChunkDataControl", "LastFrame", "TransportLayerControl"}) +
      DeviceControl() + ImageFormatControl() + AcquisitionControl() + AnalogControl() + DigitalIOControl() +
      SequencerControl() + ChunkDataControl() + LastFrame() + TransportLayerControl() + kEnd;
  return description;
}

}  // namespace ulf::acquisition
