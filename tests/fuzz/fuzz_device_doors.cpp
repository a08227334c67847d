#include "tests/fuzz/fuzz_targets.h"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/gige_vision/gvcp.h"
#include "acquisition/simulator/gige/gvcp_server.h"
#include "acquisition/simulator/gige/register_memory.h"
#include "acquisition/v4l2/v4l2_stream.h"
#include "core/frames/pixel_format.h"

namespace ulf::test {
namespace {

namespace gvcp = acquisition::gvcp;

// A copy with nothing behind its end, so that reading past it is noticed.
std::vector<std::uint8_t> CopyOf(std::string_view bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

void CameraImageDoor(std::string_view bytes) {
  const std::size_t end_of_line = bytes.find('\n');
  if (end_of_line == std::string_view::npos) return;
  std::istringstream line{std::string(bytes.substr(0, end_of_line))};
  std::string name;
  std::uint16_t width = 0, height = 0;  // as a stream's packets may say them at most (stream_guard)
  std::uint32_t row_bytes = 0;          // as a webcam's driver may
  if (!(line >> name >> width >> height >> row_bytes)) return;
  const auto format = PixelFormatByName(name);
  if (!format) return;
  std::vector<std::uint8_t> payload = CopyOf(bytes.substr(end_of_line + 1));
  if (format->packing == PixelPacking::kJpeg) {
    const auto jpeg = acquisition::StandaloneJpeg(payload);
    if (!jpeg) return;
    payload = CopyOf(*jpeg);
  }
  const Image image =
      ImageFromBytes(*format, width, height, payload.data(), payload.size(), {.row_bytes = row_bytes});
  if (image.pixels.cols != width || image.pixels.rows != height) Broken("an image of another size");
}

void GigeAnswerDoor(std::string_view bytes) {
  const auto answer = acquisition::ReadGigeAnswer(CopyOf(bytes));
  if (!answer) return;
  if (answer->maker.size() > 32 || answer->model.size() > 32 || answer->serial.size() > 16)
    Broken("a name longer than its register");
  acquisition::WrongNetworkText(
      *answer, {{.name = "eth0", .address = "192.168.1.5", .netmask = "255.255.255.0", .loopback = false}});
}

// Lengths of two bytes, each before a request: the simulated camera carries out none that it must not.
void GvcpRequestsDoor(std::string_view bytes) {
  constexpr std::uint32_t kPrivilegeAt = 0x0A00, kHeartbeatAt = 0x0938, kWritableAt = 0x0D04,
                          kMostPrivilege = 3, kMostWritable = 9000;
  constexpr std::size_t kMostAnswered = gvcp::kHeaderBytes + 4 + 536;
  acquisition::RegisterMemory memory("");
  memory.Write(kHeartbeatAt, 3000u);
  acquisition::GvcpServer server(
      memory,
      {{kPrivilegeAt, [](std::uint32_t value) { return value <= kMostPrivilege; }},
       {kWritableAt, [](std::uint32_t value) { return value <= kMostWritable; }}},
      [&](const acquisition::GvcpAccess& access) {
        if (access.address % 4 != 0 || access.address + 4 > memory.Bytes())
          Broken("a request beyond the registers");
        if (!access.written) return;
        if (access.address != kPrivilegeAt && access.address != kWritableAt)
          Broken("a write of what cannot be written");
        if (*access.written > (access.address == kPrivilegeAt ? kMostPrivilege : kMostWritable))
          Broken("a write out of the range");
        if (access.address == kWritableAt && memory.Read(kPrivilegeAt) == 0)
          Broken("a write by nobody who controls the camera");
      });
  while (bytes.size() > 2) {
    const std::size_t size = std::min<std::size_t>(
        gvcp::Half(reinterpret_cast<const std::uint8_t*>(bytes.data())), bytes.size() - 2);
    const std::vector<std::uint8_t> request = CopyOf(bytes.substr(2, size));
    const auto answer = server.Answer(request, {}, false);
    if (!answer.empty() && (answer.size() < gvcp::kHeaderBytes || answer.size() > kMostAnswered ||
                            gvcp::Half(&answer[4]) != answer.size() - gvcp::kHeaderBytes))
      Broken("an answer of another length than it says, or than a client has room for");
    bytes.remove_prefix(2 + size);
  }
}

}  // namespace ulf::test
