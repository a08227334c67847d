// Tests: acquisition/aravis/stream_guard, acquisition/simulator/gige/gvcp_filter,
// acquisition/simulator/gige/gvcp, acquisition/simulator/gige/taken_sockets,
// acquisition/simulator/gige/gige_registers.
//
// Forged packets against both ends of a GigE Vision link: the known killers one by one, each against a camera
// or a stream that must go on as if nothing had come. What the guard does with each is in stream_guard_test.
#include <gmock/gmock.h>

#include "acquisition/device/features.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"
#include "tests/support/gige_packets.h"

namespace ulf::test::hostile_network {
namespace {

using ::testing::HasSubstr;

constexpr char kCamera[] = "127.0.0.1";
constexpr std::uint16_t kDiscovery = 0x02, kReadRegister = 0x80, kWriteRegister = 0x82, kReadMemory = 0x84,
                        kWriteMemory = 0x86;
constexpr std::uint16_t kNotImplemented = 0x8001, kInvalidParameter = 0x8002, kInvalidAddress = 0x8003,
                        kWriteProtect = 0x8004, kBadAlignment = 0x8005, kAccessDenied = 0x8006,
                        kInvalidHeader = 0x800E;

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
  static int StatusOf(const std::optional<Packet>& answer) {
    return answer && answer->size() >= 8 ? (*answer)[0] << 8 | (*answer)[1] : -1;
  }
  static double Transport(const Device& device, const std::string& name) {
    for (const auto& [known, value] : device.Statistics().transport)
      if (known == name) return value;
    return -1;
  }

  std::unique_ptr<SimulatedGigeCamera> server_;
};

TEST_F(HostileNetwork, TheCameraAnswersJunkWithStatusCodes) {
  struct {
    const char* what;
    ControlRequest request;
    int status;
  } const cases[] = {
      {"register at the end of the address space", {kReadRegister, Words({0xFFFFFFFC})}, kInvalidAddress},
      {"memory up to the end of the address space", {kReadMemory, Words({0xFFFFFFF0, 16})}, kInvalidAddress},
      {"memory over the end of the address space", {kReadMemory, Words({0xFFFFFFF0, 512})}, kInvalidAddress},
      {"register behind the description", {kReadRegister, Words({0x00020000})}, kInvalidAddress},
      {"memory behind the description", {kReadMemory, Words({0x7FFFFFFC, 512})}, kInvalidAddress},
      {"register between two", {kReadRegister, Words({0x102})}, kBadAlignment},
      {"memory between two", {kReadMemory, Words({0x102, 4})}, kBadAlignment},
      {"more memory than fits an answer", {kReadMemory, Words({0, 0xFFFF})}, kInvalidParameter},
      {"a count that overflows", {kReadMemory, Words({0x10, 0xFFFFFFFF})}, kInvalidParameter},
      {"no memory", {kReadMemory, Words({0, 0})}, kInvalidParameter},
      {"memory without a count", {kReadMemory, Words({0})}, kInvalidHeader},
      {"register without an address", {kReadRegister}, kInvalidHeader},
      {"two registers", {kReadRegister, Words({0, 4})}, kNotImplemented},
      {"a length longer than the packet", {kWriteMemory, Words({0x100, 320}), 0xFFF8}, kInvalidHeader},
      {"a length shorter than the packet", {kReadRegister, Words({0x100}), 0}, kInvalidHeader},
      {"write at the end of the address space", {kWriteRegister, Words({0xFFFFFFFC, 1})}, kInvalidAddress},
      {"write memory over the end", {kWriteMemory, Words({0xFFFFFFF8, 1, 2, 3, 4})}, kInvalidAddress},
      {"write without a value", {kWriteRegister, Words({0x100})}, kInvalidHeader},
      {"write memory without bytes", {kWriteMemory, Words({0x100})}, kInvalidHeader},
      {"write the maker's name", {kWriteMemory, Words({0x48, 0x41414141})}, kWriteProtect},
      {"write the description", {kWriteRegister, Words({0x10000, 0})}, kWriteProtect},
      {"write over what is writable", {kWriteMemory, Words({0x100, 320, 240, 0})}, kWriteProtect},
      {"a width of 4 GB", {kWriteRegister, Words({0x100, 0xFFFFFFFF})}, kInvalidParameter},
      {"a height whose product overflows", {kWriteRegister, Words({0x104, 0x01000000})}, kInvalidParameter},
      {"a frame period of nothing", {kWriteRegister, Words({0x138, 0})}, kInvalidParameter},
      {"packets smaller than their headers", {kWriteRegister, Words({0xD04, 36})}, kInvalidParameter},
      {"a pixel format of no bits", {kWriteRegister, Words({0x128, 0x01000001})}, kInvalidParameter},
      {"a width, of a camera that nobody controls", {kWriteRegister, Words({0x100, 160})}, kAccessDenied},
      {"a stream's address, without control", {kWriteRegister, Words({0xD18, 0x7F000001})}, kAccessDenied},
      {"a start, without control", {kWriteMemory, Words({0x124, 1})}, kAccessDenied},
      {"a command that there is not", {0x0100, Words({1, 2, 3})}, kNotImplemented},
      {"a packet asked for again", {0x0040, Words({0, 1, 2})}, kNotImplemented},
      {"another address forced", {0x0004, Packet(56)}, kNotImplemented},
      {"discovery with a body", {kDiscovery, Words({1})}, kInvalidHeader},
      {"no request of the protocol", {.command = kDiscovery, .key = 0x11}, -1},
      {"no answer wanted", {.command = kReadRegister, .body = Words({0xFFFFFFFC}), .flags = 0}, -1},
      {"more than any packet", {kWriteMemory, Packet(5000)}, kInvalidHeader}};
  const UdpSocket stranger;
  for (const auto& [what, request, status] : cases)
    EXPECT_EQ(StatusOf(Answer(stranger, request, status < 0 ? 50 : 2000)), status) << what;
  for (std::size_t size = 0; size < 12; ++size) {
    Packet cut = Control({kReadRegister, Words({0x100})});
    cut.resize(size);
    stranger.Send(cut, kCamera, kGvcpPort);
  }
  while (stranger.Receive(50)) continue;
  EXPECT_GE(server_->Statistics().refused, 32u);
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

TEST_F(HostileNetwork, AStreamOutlivesWhatPretendsToBeTheCameras) {
  // Small packets, so that there is room for wrong numbers.
  const auto device = OpenDriver("aravis:127.0.0.1?packet_size=576&format=Mono8");
  device->Start();
  Take(*device, 3);
  EXPECT_EQ(Transport(*device, "packets refused"), 0);
  const StreamEnds ends = AskStreamEnds(kCamera);
  ASSERT_NE(ends.from.sin_port, 0) << "the camera tells where it sends from";
  const Packet full(540);
  const std::vector<std::pair<const char*, std::vector<Packet>>> killers{
      {"an allocation of 64 GB", {Extended(2, 30000, 0xFFFFFFFE)}},
      {"more packets than the frame has, then one of them",
       {Plain(2, 30000, 400), Plain(3, 30000, 390, full)}},
      {"a count of packets that overflows", {Extended(2, 30000, 0xFFFFFFFF)}},
      {"all in one, then a packet", {Plain(4, 30000, 0), Plain(3, 30000, 200, full)}},
      {"parts that the leader has not", {Plain(1, 30000, 255, MultipartLeader(1, 0xFFFFFFFFFFFF))}},
      {"a part of less than nothing", {Plain(1, 30000, 1, MultipartLeader(1, 76800)), Plain(7, 30000, 1)}},
      {"a leader of nothing", {Plain(1, 30000, 0)}},
      {"a leader of unknown data", {Plain(1, 30000, 0, Leader(320, 240, 0x01080001, 0))}},
      {"a frame of 4 GB by 4 GB", {Plain(1, 30000, 0, Leader(0xFFFFFFFF, 0xFFFFFFFF))}},
      {"nothing", {Packet{}}},
      {"half a header", {Packet{0, 0, 0x75, 0x30}}}};
  const Forger forger;
  double refused = 0;
  for (const auto& [what, packets] : killers) {
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
  EXPECT_EQ(Transport(*device, "packets refused"), refused);
  bool said = false;
  for (const DeviceEvent& event : device->TakeEvents())
    said = said || event.text.find("counts them as 'packets refused'") != std::string::npos;
  EXPECT_TRUE(said);
}

TEST_F(HostileNetwork, ACameraThatTellsTheWrongPortIsBelievedByItsAddress) {
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
}  // namespace ulf::test::hostile_network
