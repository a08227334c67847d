// The tests' camera with some of its features as other makers have them: full_camera.xml, edited by the test
// and served by the fake camera.
#pragma once

#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "acquisition/device/features.h"
#include "acquisition/opening/open_device.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/test_paths.h"

namespace ulf::test {

inline const std::string kCamera = "aravis:127.0.0.1";
inline const std::string kSmall = "aravis:127.0.0.1?format=Mono8&roi=64x64+0+0&fps=50&settle=0.2";

// A register of four bytes that is plain memory, 0 at first.
inline std::string Register(const std::string& name, const std::string& address,
                            const std::string& index = "") {
  return "<IntReg Name=\"" + name + "\"><Address>" + address + "</Address>" + index +
         "<Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort><Sign>Unsigned</Sign>"
         "<Endianess>BigEndian</Endianess></IntReg>";
}

inline std::string Choice(const std::string& name, const std::vector<std::pair<std::string, int>>& entries,
                          const std::string& value, const std::string& more = "") {
  std::string text = "<Enumeration Name=\"" + name + "\">" + more;
  for (const auto& [entry, number] : entries)
    text += "<EnumEntry Name=\"" + entry + "\"><Value>" + std::to_string(number) + "</Value></EnumEntry>";
  return text + "<pValue>" + value + "</pValue></Enumeration>";
}

// A number that never changes.
inline std::string Constant(const std::string& name, int value) {
  return "<IntSwissKnife Name=\"" + name + "\"><Formula>" + std::to_string(value) +
         "</Formula></IntSwissKnife>";
}

class EditedCamera : public CameraInNamespace {
 protected:
  void SetUp() override {
    CameraInNamespace::SetUp();
    if (!IsSkipped()) description_ = ReadWholeFile(FULL_CAMERA);
  }

  void Replace(const std::string& from, const std::string& to) {
    const std::size_t at = description_.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    description_.replace(at, from.size(), to);
  }
  // A node with all that is in it.
  void ReplaceNode(const std::string& kind, const std::string& name, const std::string& to) {
    const std::size_t at = description_.find("<" + kind + " Name=\"" + name + "\"");
    ASSERT_NE(at, std::string::npos) << name;
    const std::string end = "</" + kind + ">";
    description_.replace(at, description_.find(end, at) + end.size() - at, to);
  }
  void Add(const std::string& nodes) {
    Replace("<Port Name=\"Device\"/>", nodes + "<Port Name=\"Device\"/>");
  }
  // A register that can only be read.
  void Fix(const std::string& reg) {
    const std::size_t at = description_.find("<IntReg Name=\"" + reg + "\""),
                      access = description_.find("<AccessMode>RW", at);
    ASSERT_NE(at, std::string::npos) << reg;
    ASSERT_LT(access, description_.find("</IntReg>", at)) << reg;
    description_.replace(access + 12, 2, "RO");
  }
  void Start() {
    WriteFileAtomically(scratch_ / "camera.xml", description_);
    StartCamera("V1", "0", "127.0.0.1", (scratch_ / "camera.xml").string());
  }

  static std::string ValueOf(const std::string& name) {
    const auto feature = OpenFeatures(kCamera)->Find(name);
    return feature ? feature->value : "no " + name;
  }
  static std::string ErrorOfUri(const std::string& uri) {
    try {
      OpenDriver(uri);
    } catch (const Refusal& error) {
      return error.what();
    }
    return "no usage error";
  }
  static std::string ErrorOf(const std::string& options) { return ErrorOfUri(kSmall + "&" + options); }
  static std::vector<std::string> Said(Device& device) {
    std::vector<std::string> texts;
    for (const DeviceEvent& event : device.TakeEvents()) texts.push_back(event.text);
    return texts;
  }

  ScratchFolder scratch_;
  std::string description_;
};

}  // namespace ulf::test
