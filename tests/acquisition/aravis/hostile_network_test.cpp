// Tests: acquisition/aravis/stream_guard, acquisition/simulator/gige/gvcp_server,
// acquisition/gige_vision/gvcp, acquisition/simulator/gige/register_memory,
// acquisition/simulator/gige/gige_registers.
//
// Forged packets against both ends of a GigE Vision link, each just beyond what is allowed: a camera or a
// stream must go on as if nothing had come. The library behind the guards survives each of them; what the
// guards refuse is counted. What the stream's guard does with each is in stream_guard_test.
#include <gmock/gmock.h>

#include <thread>

#include "acquisition/device/features.h"
#include "acquisition/simulator/gige/gvcp_server.h"
#include "acquisition/simulator/gige/register_memory.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"
#include "tests/support/gige_packets.h"

namespace ulf::test::hostile_network_test {
namespace {

using ::testing::HasSubstr;

constexpr char kCamera[] = "127.0.0.1";
constexpr std::uint16_t kDiscovery = 0x02, kReadRegister = 0x80, kWriteRegister = 0x82, kReadMemory = 0x84,
                        kWriteMemory = 0x86;
constexpr std::uint16_t kNotImplemented = 0x8001, kInvalidParameter = 0x8002, kInvalidAddress = 0x8003,
                        kWriteProtect = 0x8004, kBadAlignment = 0x8005, kAccessDenied = 0x8006,
                        kInvalidHeader = 0x800E;

Packet WithoutLastByte(Packet packet) {
  packet.pop_back();
  return packet;
}

class HostileNetwork : public CameraInNamespace {
 protected:
  void SetUp() override {
    CameraInNamespace::SetUp();
    if (IsSkipped()) return;
    GigeServerOptions options;
    options.simulation.width = 320;
    options.simulation.height = 240;
    options.simulation.fps = 20;
    options.loop = 2;
    server_ = std::make_unique<SimulatedGigeCamera>(options);
  }

  static std::optional<Packet> Answer(const UdpSocket& from, const ControlRequest& request, int patience_ms) {
    static std::uint16_t number = 100;
    from.Send(Control(request, ++number), kCamera, kGvcpPort);
    const auto answer = from.Receive(patience_ms);
    if (answer && answer->size() >= 8) {
      EXPECT_EQ((*answer)[6] << 8 | (*answer)[7], number);
      EXPECT_EQ((*answer)[2] << 8 | (*answer)[3], request.command + 1);
    }
    return answer;
  }
  // Where the last word of the camera's description lies, which the camera tells as
  // "Local:NAME;ADDRESS;LENGTH".
  static std::uint32_t LastWord() {
    constexpr std::uint32_t kUrlAt = 0x200, kUrlBytes = 512, kBehindHeaderAndAddress = 12;
    const auto answer = Answer(UdpSocket(), {kReadMemory, Words({kUrlAt, kUrlBytes})}, 2000);
    if (!answer || answer->size() < kBehindHeaderAndAddress) throw Error("no address of the description");
    const std::string url(answer->begin() + kBehindHeaderAndAddress, answer->end());
    const std::size_t address = url.find(';') + 1, length = url.find(';', address) + 1;
    const auto number = [&](std::size_t at) { return std::stoul(url.substr(at), nullptr, 16); };
    return static_cast<std::uint32_t>(number(address) + (number(length) + 3) / 4 * 4 - 4);
  }
  static int StatusOf(const std::optional<Packet>& answer) {
    return answer && answer->size() >= 8 ? (*answer)[0] << 8 | (*answer)[1] : -1;
  }
  static double Transport(const Device& device, TransportFigure figure) {
    if (const auto value = FigureIn(device.Statistics().transport, figure)) return *value;
    return -1;
  }

  std::unique_ptr<SimulatedGigeCamera> server_;
};

TEST_F(HostileNetwork, TheCameraAnswersJunkWithStatusCodes) {
  const std::uint32_t last = LastWord();
  // Of an address that nothing lies at, so many bytes of nothing.
  const auto unused = [](std::size_t bytes) {
    Packet packet = Words({0x8000});
    packet.resize(packet.size() + bytes);
    return packet;
  };
  struct {
    const char* what;
    ControlRequest request;
    int status;
  } const cases[] = {
      {"memory one word over the end", {kReadMemory, Words({last, 8})}, kInvalidAddress},
      {"register between two", {kReadRegister, Words({0x102})}, kBadAlignment},
      {"memory between two", {kReadMemory, Words({0x102, 4})}, kBadAlignment},
      {"one word more than fits an answer", {kReadMemory, Words({0, 540})}, kInvalidParameter},
      {"no memory", {kReadMemory, Words({0, 0})}, kInvalidParameter},
      {"memory, a byte of the count short", {kReadMemory, WithoutLastByte(Words({0, 4}))}, kInvalidHeader},
      {"register, a byte of the address short",
       {kReadRegister, WithoutLastByte(Words({0x100}))},
       kInvalidHeader},
      {"two registers", {kReadRegister, Words({0, 4})}, kNotImplemented},
      {"a length longer than the packet", {kWriteMemory, Words({0x48, 0x41414141}), 12}, kInvalidHeader},
      {"a length shorter than the packet", {kReadRegister, Words({0x100}), 0}, kInvalidHeader},
      {"write memory one word over the end", {kWriteMemory, Words({last, 1, 2})}, kInvalidAddress},
      {"write, a byte of the value short",
       {kWriteRegister, WithoutLastByte(Words({0x100, 320}))},
       kInvalidHeader},
      {"write memory without bytes", {kWriteMemory, Words({0x100})}, kInvalidHeader},
      {"write the maker's name", {kWriteMemory, Words({0x48, 0x41414141})}, kWriteProtect},
      {"write the description", {kWriteRegister, Words({0x10000, 0})}, kWriteProtect},
      {"write over what is writable", {kWriteMemory, Words({0x100, 320, 240, 1})}, kWriteProtect},
      {"a column too many", {kWriteRegister, Words({0x100, 321})}, kInvalidParameter},
      {"a row too many", {kWriteRegister, Words({0x104, 241})}, kInvalidParameter},
      {"a frame period below the least", {kWriteRegister, Words({0x138, 999})}, kInvalidParameter},
      {"packets below the least", {kWriteRegister, Words({0xD04, 99})}, kInvalidParameter},
      {"a pixel format that it has not", {kWriteRegister, Words({0x128, 0x01080002})}, kInvalidParameter},
      {"a width, of a camera that nobody controls", {kWriteRegister, Words({0x100, 160})}, kAccessDenied},
      {"a stream's address, without control", {kWriteRegister, Words({0xD18, 0x7F000001})}, kAccessDenied},
      {"a start, without control", {kWriteMemory, Words({0x124, 1})}, kAccessDenied},
      {"a command that there is not", {0x0100, Words({1, 2, 3})}, kNotImplemented},
      {"a packet asked for again", {0x0040, Words({0, 1, 2})}, kNotImplemented},
      {"another address forced", {0x0004, Packet(56)}, kNotImplemented},
      {"discovery with a body", {kDiscovery, Words({1})}, kInvalidHeader},
      {"no request of the protocol", {.command = kDiscovery, .key = 0x11}, -1},
      {"no answer wanted", {.command = kReadRegister, .body = Words({0x102}), .flags = 0}, -1},
      {"one word more than may be written at once", {kWriteMemory, unused(540)}, kInvalidParameter},
      {"one word more than the server holds", {kWriteMemory, unused(2040)}, kInvalidHeader}};
  const UdpSocket stranger;
  for (const auto& [what, request, status] : cases)
    EXPECT_EQ(StatusOf(Answer(stranger, request, status < 0 ? 50 : 2000)), status) << what;
  stranger.Send(WithoutLastByte(Control({kDiscovery})), kCamera, kGvcpPort);
  EXPECT_FALSE(stranger.Receive(50)) << "a header without its last byte";
  EXPECT_EQ(server_->Statistics().refused, std::size(cases) - 1) << "all but what is no request";
  EXPECT_EQ(StatusOf(Answer(stranger, {kReadRegister, Words({0x100})}, 2000)), 0);
  EXPECT_EQ(StatusOf(Answer(stranger, {kReadMemory, Words({0, 536})}, 2000)), 0);
  const auto width = [&] { return ReadGigeRegister(kCamera, 0x100); };
  EXPECT_EQ(width(), 320u);
  EXPECT_EQ(StatusOf(Answer(stranger, {kWriteRegister, Words({0xA00, 2})}, 2000)), 0);
  EXPECT_EQ(StatusOf(Answer(stranger, {kWriteRegister, Words({0x100, 160})}, 2000)), 0) << "with control";
  EXPECT_EQ(width(), 160u);
  EXPECT_EQ(StatusOf(Answer(stranger, {kWriteRegister, Words({0x100, 320})}, 2000)), 0);
  EXPECT_EQ(StatusOf(Answer(stranger, {kWriteRegister, Words({0xA00, 0})}, 2000)), 0);
  EXPECT_EQ(StatusOf(Answer(stranger, {kWriteRegister, Words({0x100, 160})}, 2000)), kAccessDenied)
      << "given back";
  EXPECT_EQ(width(), 320u);
  const auto device = OpenDriver("aravis:127.0.0.1");
  device->Start();
  Take(*device, 3);
  EXPECT_EQ(StatusOf(Answer(stranger, {kWriteRegister, Words({0x124, 0})}, 2000)), kAccessDenied)
      << "a stranger stops another's stream";
  EXPECT_EQ(StatusOf(Answer(stranger, {kWriteRegister, Words({0xA00, 2})}, 2000)), kAccessDenied)
      << "a stranger takes the camera";
  Take(*device, 3);
}

TEST(GvcpServer, SilentControllerLosesTheCamera) {
  constexpr std::uint32_t kTimeoutMs = 0x938, kPrivilege = 0xA00;
  RegisterMemory memory("");
  memory.Write(kTimeoutMs, 60'000u);
  GvcpServer server(memory, {{kPrivilege, [](std::uint32_t) { return true; }}});
  sockaddr_in one{}, two{};
  one.sin_port = 1;
  two.sin_port = 2;
  const auto status = [&](const sockaddr_in& client, const ControlRequest& request) {
    const auto answer = server.Answer(Control(request), client, false);
    return answer[0] << 8 | answer[1];
  };
  const ControlRequest take{kWriteRegister, Words({kPrivilege, 2})},
      heartbeat{kReadRegister, Words({kPrivilege})};
  EXPECT_EQ(status(one, take), 0);
  std::this_thread::sleep_for(500ms);
  EXPECT_EQ(status(one, heartbeat), 0);
  memory.Write(kTimeoutMs, 450u);
  EXPECT_EQ(status(two, take), kAccessDenied);
  std::this_thread::sleep_for(500ms);
  EXPECT_EQ(status(two, heartbeat), 0) << "another's";
  EXPECT_FALSE(server.IsControlled());
  EXPECT_EQ(memory.Read(kPrivilege), 0u);
  memory.Write(kTimeoutMs, 60'000u);
  EXPECT_EQ(status(two, take), 0);
  EXPECT_EQ(status(one, take), kAccessDenied);
}

TEST_F(HostileNetwork, StreamSurvivesForgedPackets) {
  // Small packets, so that there is room for wrong numbers.
  const auto device = OpenDriver("aravis:127.0.0.1?packet_size=576&format=Mono8");
  device->Start();
  Take(*device, 3);
  EXPECT_EQ(Transport(*device, TransportFigure::kPacketsRefused), 0);
  const StreamEnds ends = AskStreamEnds(kCamera);
  ASSERT_NE(ends.from.sin_port, 0) << "the camera tells where it sends from";
  const Packet full(540);
  constexpr std::uint32_t kBlocks = (320 * 240 + 539) / 540;
  const std::vector<std::pair<const char*, std::vector<Packet>>> forged{
      {"a trailer one packet beyond the payload", {Plain(2, 30000, kBlocks + 2)}},
      {"a packet more than the payload has", {Plain(3, 30000, kBlocks + 1, full)}},
      {"all in one", {Plain(4, 30000, 0, full)}},
      {"a frame of one part", {Plain(1, 30000, 1, MultipartLeader(1, 320 * 240)), Plain(7, 30000, 1, full)}},
      {"a leader of unknown data", {Plain(1, 30000, 0, Leader(320, 240, 0x01080001, 0))}},
      {"a frame of one row too many", {Plain(1, 30000, 0, Leader(320, 241))}},
      {"a leader without its last byte", {WithoutLastByte(Plain(1, 30000, 0, Leader(320, 240)))}},
      {"a header without its last byte", {WithoutLastByte(Plain(2, 30000, 1))}}};
  const Forger forger;
  double refused = 0;
  for (const auto& [what, packets] : forged) {
    SCOPED_TRACE(what);
    for (const Packet& packet : packets) forger.Send(packet, ends.from, ends.to);
    refused += static_cast<double>(packets.size());
    for (const Frame& frame : Take(*device, 2)) EXPECT_EQ(frame.status, FrameStatus::kComplete);
    ASSERT_EQ(device->State(), DeviceState::kStreaming);
  }
  // From elsewhere not even what the camera itself could have sent.
  const UdpSocket stranger, far("127.0.0.77");
  for (const UdpSocket* from : {&stranger, &far})
    from->Send(Plain(1, 30000, 0, Leader(320, 240)), kCamera, ntohs(ends.to.sin_port));
  refused += 2;
  for (const Frame& frame : Take(*device, 6)) EXPECT_EQ(frame.status, FrameStatus::kComplete);
  EXPECT_EQ(Transport(*device, TransportFigure::kPacketsRefused), refused);
  bool said = false;
  for (const DeviceEvent& event : device->TakeEvents())
    said = said || event.text.find("counts them as 'packets refused'") != std::string::npos;
  EXPECT_TRUE(said);
}

TEST_F(HostileNetwork, WrongPortIsOverriddenByTheAddress) {
  server_.reset();
  StartCamera();
  // The library's own camera lets everybody write everything.
  EXPECT_EQ(StatusOf(Answer(UdpSocket(), {kWriteRegister, Words({0xD1C, 9})}, 2000)), 0);
  const auto device = OpenDriver("aravis:127.0.0.1?format=Mono8");
  device->Start();
  Take(*device, 5);
  std::string said;
  for (const DeviceEvent& event : device->TakeEvents()) said += event.text + "\n";
  EXPECT_THAT(said, HasSubstr("from another port than it reports"));
}

}  // namespace
}  // namespace ulf::test::hostile_network_test
