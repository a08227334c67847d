// Tests: commands/capture/capture_command.
//
// A minute of random packets, seeded, against both ports of a running pair: `ulf simulate` and `ulf capture
// aravis:`, each a process of its own, in a network of this test's own. Both must come to their ordinary end.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "acquisition/calibration/calibration_io.h"
#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/gige_packets.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"

namespace ulf::test::network_fuzz_long_test {
namespace {

using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

constexpr char kCamera[] = "127.0.0.1";
constexpr double kSeconds = 60;
constexpr int kFps = 15;
constexpr int kMostPackets = 600'000;

class Fuzzer {
 public:
  explicit Fuzzer(unsigned seed) : random_(seed) {}

  std::uint32_t Below(std::uint32_t end) { return static_cast<std::uint32_t>(random_() % end); }
  bool OneIn(std::uint32_t n) { return Below(n) == 0; }

  // Mostly what is at the edge of something.
  std::uint32_t Number() {
    static constexpr std::uint32_t kEdges[] = {
        0,      1,        2,         3,          4,          36,         536,
        576,    0xD00,    0xD04,     0xA00,      0xFFFC,     0xFFFF,     0x10000,
        0x3000, 0xFFFFFF, 0x1000000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFC, 0xFFFFFFFF};
    std::uint32_t number =
        OneIn(3) ? static_cast<std::uint32_t>(random_()) : kEdges[Below(std::size(kEdges))];
    if (OneIn(4)) number += Below(9) - 4;
    if (OneIn(4)) number &= 0x1FFF;
    return number;
  }

  // Field by field, then a cut, a longer end or a flipped bit.
  Packet Damage(Packet packet) {
    if (OneIn(4)) packet.resize(Below(static_cast<std::uint32_t>(packet.size()) + 1));
    if (OneIn(6)) packet.resize(packet.size() + Below(600), static_cast<std::uint8_t>(Below(256)));
    for (; !packet.empty() && OneIn(3);)
      packet[Below(static_cast<std::uint32_t>(packet.size()))] ^= static_cast<std::uint8_t>(1u << Below(8));
    return packet;
  }

  Packet ControlPacket() {
    static constexpr std::uint16_t kCommands[] = {0x02, 0x04, 0x40, 0x80, 0x81,
                                                  0x82, 0x84, 0x86, 0xC0, 0x100};
    ControlRequest request{.command = OneIn(8) ? static_cast<std::uint16_t>(Number())
                                               : kCommands[Below(std::size(kCommands))]};
    for (std::uint32_t words = Below(5); words > 0; --words) Append(request.body, Number(), 4);
    if (OneIn(10)) request.body.resize(Below(1200));
    if (OneIn(8)) request.length = static_cast<std::uint16_t>(Number());
    if (OneIn(30)) request.key = static_cast<std::uint8_t>(Below(256));
    if (OneIn(10)) request.flags = static_cast<std::uint8_t>(Below(256));
    return Damage(Control(request));
  }

  // Of frames of its own and of those that the camera is about to send, which it may spoil, as the camera
  // itself could. `near`: a number not far from the camera's.
  Packet StreamPacket(std::uint32_t near) {
    static constexpr int kKinds[] = {1, 2, 3, 3, 3, 4, 5, 6, 7, 8};
    const int kind = OneIn(10) ? static_cast<int>(Below(128)) : kKinds[Below(std::size(kKinds))];
    const bool of_the_camera = OneIn(4);
    const std::uint32_t until = near + 15;
    const std::uint32_t real = 1 + (OneIn(2) ? Below(until) : until - Below(std::min(until, 90u)) - 1);
    const auto frame = static_cast<std::uint16_t>(of_the_camera ? real : Number());
    const std::uint32_t number = OneIn(2) ? Below(200) : Number();
    Packet body(OneIn(2) ? Below(64) : Below(560), static_cast<std::uint8_t>(Below(256)));
    if (kind == 1)
      body = OneIn(3) ? MultipartLeader(static_cast<int>(Below(8)), Number()) : Leader(Number(), Number());
    if (kind == 1 && OneIn(3)) body = Leader(320, 240);
    return Damage(OneIn(2)
                      ? Extended(kind,
                                 of_the_camera || OneIn(2) ? frame : std::uint64_t{Number()} << 32 | Number(),
                                 number, body)
                      : Plain(kind, frame, number & 0xFFFFFF, body));
  }

 private:
  std::mt19937 random_;
};

class NetworkFuzz : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::optional<std::string> why_not = EnterLoopbackNamespace();
    if (why_not) GTEST_SKIP() << *why_not;
    const std::string binary = std::getenv("ULF_BINARY");
    simulator_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{binary, "simulate", "--options", "width=320&height=240", "--loop", "90",
                                 "--fps", std::to_string(kFps), "--calibration-out", scratch_ / "sim.json"});
    ASSERT_THAT(simulator_->ReadUntil("serving", 60), HasSubstr("serving"));
  }

  std::unique_ptr<ChildProcess> Capture() {
    return std::make_unique<ChildProcess>(std::vector<std::string>{
        "/bin/sh", "-c",
        "exec \"$ULF_BINARY\" capture 'aravis:127.0.0.1?packet_size=576' --headless --json -o " +
            (scratch_ / "lf").string() + " --calibration " + (scratch_ / "sim.json").string() + " 2> " +
            (scratch_ / "errors").string()});
  }

  bool HasAView() const {
    std::error_code missing;
    return std::filesystem::exists(scratch_ / "lf/journal.jsonl", missing) &&
           ReadWholeFile(scratch_ / "lf/journal.jsonl").find("\"event\":\"view\"") != std::string::npos;
  }

  ScratchFolder scratch_;
  std::unique_ptr<ChildProcess> simulator_;
};

TEST_F(NetworkFuzz, NeitherEndFalls) {
  const auto began = Clock::now();
  const auto capture = Capture();
  for (int i = 0; i < 1200 && !HasAView(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ASSERT_TRUE(HasAView()) << "without a packet of ours";
  const StreamEnds ends = AskStreamEnds(kCamera);
  ASSERT_NE(ends.to.sin_port, 0);
  Fuzzer fuzzer(1);
  const Forger forger;
  const UdpSocket stranger;
  int sent = 0;
  for (const auto begin = Clock::now(); sent < kMostPackets; ++sent) {
    if (std::chrono::duration<double>(Clock::now() - begin).count() > kSeconds) break;
    if (sent % 4 == 0)
      stranger.Send(fuzzer.ControlPacket(), kCamera, kGvcpPort);
    else
      forger.Send(
          fuzzer.StreamPacket(static_cast<std::uint32_t>(
              kFps * std::chrono::duration<double>(Clock::now() - began).count())),  // they count from one
          ends.from, ends.to);
    while (stranger.Receive(0)) continue;
    if (sent % 16 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(sent, 10'000);
  capture->Signal(SIGINT);
  const std::string output = capture->ReadUntil("stopped_because", 60);
  EXPECT_EQ(capture->Wait(60), 0) << output;
  const std::size_t json_begin = output.rfind("\n{");
  const auto report = JsonFromText(output.substr(json_begin == std::string::npos ? 0 : json_begin + 1));
  EXPECT_GT(report["device"]["transport"]["packets refused"], 1000);
  EXPECT_GE(report["recorded"], 1);
  EXPECT_GE(ReadLightField(scratch_ / "lf").views.size(), 1u);
  EXPECT_TRUE(QueryGigeCamera(kCamera, std::chrono::seconds(5)));
  simulator_->Signal(SIGINT);
  EXPECT_EQ(simulator_->Wait(20), 0);
}

}  // namespace
}  // namespace ulf::test::network_fuzz_long_test
