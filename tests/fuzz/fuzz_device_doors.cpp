#include "tests/fuzz/fuzz_targets.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/gige_vision/gvcp.h"
#include "acquisition/simulator/gige/gvcp_filter.h"
#include "acquisition/v4l2/v4l2_stream.h"
#include "core/frames/pixel_format.h"

namespace ulf::test {
namespace {

namespace gvcp = acquisition::gvcp;

// A copy with nothing behind its end, so that reading past it is noticed.
std::vector<std::uint8_t> CopyOf(std::string_view bytes) { return {bytes.begin(), bytes.end()}; }

// The simulated camera behind its filter: answers everything, and looks at what it was sent.
class FilteredCamera {
 public:
  FilteredCamera() {
    for (auto* pair : {&client_, &camera_})
      if (socketpair(AF_UNIX, SOCK_DGRAM, 0, pair->data()) != 0) Broken("no sockets");
    filter_.emplace(acquisition::GvcpFilterOptions{
        .unicast = client_[1],
        .broadcasts = {},
        .camera = camera_[1],
        .memory_bytes = kMemoryBytes,
        .writable = {{kPrivilegeAt, [](std::uint32_t value) { return value < 4; }},
                     {kWritableAt, [](std::uint32_t value) { return value <= kMostWritable; }}},
        .privilege = [this] { return privilege_.load(); }});
  }

  void Handle(const std::vector<std::vector<std::uint8_t>>& requests) {
    privilege_ = 0;
    for (const auto& request : requests) send(client_[0], request.data(), request.size(), 0);
    // Packets are handled one after the other: when this one is there the others have been.
    std::array<std::uint8_t, gvcp::kHeaderBytes> last{0x42, 0x01, 0, gvcp::kDiscovery};
    gvcp::PutHalf(&last[6], ++last_number_);
    send(client_[0], last.data(), last.size(), 0);
    for (bool is_last = false; !is_last;) {
      std::array<std::uint8_t, 2048> request{};
      pollfd wait{camera_[0], POLLIN, 0};
      // Many short waits: a machine that pauses for seconds ends one of them only.
      constexpr int kWaitMs = 100, kMostWaits = 100;
      int waits = 0;
      while (poll(&wait, 1, kWaitMs) != 1)
        if (++waits == kMostWaits) Broken("the filter stands still");
      const ssize_t size = recv(camera_[0], request.data(), request.size(), 0);
      if (size < static_cast<ssize_t>(gvcp::kHeaderBytes)) Broken("a request without a header");
      is_last =
          std::equal(last.begin(), last.end(), request.begin()) && size == static_cast<ssize_t>(last.size());
      Check(request.data(), static_cast<std::size_t>(size));
      std::array<std::uint8_t, gvcp::kHeaderBytes> answer{};
      gvcp::PutHalf(&answer[2], gvcp::Half(&request[2]) + 1u);
      gvcp::PutHalf(&answer[6], gvcp::Half(&request[6]));
      send(camera_[0], answer.data(), answer.size(), 0);
    }
  }

 private:
  static constexpr std::uint32_t kMemoryBytes = 0x10000, kPrivilegeAt = 0x0A00, kWritableAt = 0x0D04,
                                 kMostWritable = 9000;

  void Check(const std::uint8_t* request, std::size_t size) {
    const std::uint8_t* const body = request + gvcp::kHeaderBytes;
    const std::size_t body_bytes = size - gvcp::kHeaderBytes;
    const auto require_inside = [&](std::uint64_t bytes) {
      if (gvcp::Word(body) % 4 != 0 || gvcp::Word(body) + bytes > kMemoryBytes)
        Broken("a request beyond the registers");
    };
    if (gvcp::Half(request + 4) != body_bytes) Broken("a request of another length than it says");
    switch (gvcp::Half(request + 2)) {
      case gvcp::kDiscovery:
        return;
      case gvcp::kReadRegister:
        if (body_bytes != 4) Broken("a read of several registers");
        return require_inside(4);
      case gvcp::kReadMemory:
        if (body_bytes != 8) Broken("a read of memory without a count");
        return require_inside(gvcp::Word(body + 4));
      case gvcp::kWriteRegister:
      case gvcp::kWriteMemory: {
        const std::uint32_t address = gvcp::Word(body), value = gvcp::Word(body + 4);
        require_inside(body_bytes - 4);
        if (body_bytes != 8 || (address != kPrivilegeAt && address != kWritableAt))
          Broken("a write of what cannot be written");
        if (address == kWritableAt && (value > kMostWritable || privilege_ == 0))
          Broken("a write out of the range, or by nobody who controls the camera");
        if (address == kPrivilegeAt) privilege_ = value;
        return;
      }
      default:
        Broken("an unknown command");
    }
  }

  std::array<int, 2> client_{}, camera_{};  // ours, the filter's
  std::atomic<std::uint32_t> privilege_{0};
  std::uint16_t last_number_ = 0;
  std::optional<acquisition::GvcpFilter> filter_;
};

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

void GvcpRequestsDoor(std::string_view bytes) {
  static FilteredCamera camera;
  std::vector<std::vector<std::uint8_t>> requests;
  // What the sockets hold: whoever sends more waits. A packet of the most bytes is longer than the
  // filter's buffer.
  constexpr std::size_t kMostRequests = 8, kMostBytes = 4096;
  while (bytes.size() > 2 && requests.size() < kMostRequests) {
    const std::size_t size = std::min<std::size_t>(
        gvcp::Half(reinterpret_cast<const std::uint8_t*>(bytes.data())), bytes.size() - 2);
    requests.push_back(CopyOf(bytes.substr(2, std::min(size, kMostBytes))));
    bytes.remove_prefix(2 + size);
  }
  camera.Handle(requests);
}

}  // namespace ulf::test
