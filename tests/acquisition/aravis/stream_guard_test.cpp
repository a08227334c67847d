// Tests: acquisition/aravis/stream_guard.
//
// What the guard before a stream's socket lets through, packet by packet: a frame of 100,000 bytes in packets
// of 576 and of 9,000.
#include "acquisition/aravis/stream_guard.h"

#include <gmock/gmock.h>

#include "tests/support/floors.h"
#include "tests/support/gige_packets.h"

namespace ulf::test::stream_guard_test {
namespace {

constexpr std::uint32_t kPayload = 100'000;
constexpr std::uint32_t kPlainHeaders = 36, kExtendedHeaders = 48;  // with those of IP and UDP

std::uint32_t Blocks(std::uint32_t packet_bytes, std::uint32_t headers) {
  return (kPayload + packet_bytes - headers - 1) / (packet_bytes - headers);
}

struct Case {
  std::string what;
  Packet packet;
  bool passes;
};

std::vector<Case> Cases(std::uint32_t packet_bytes) {
  const std::uint32_t plain = Blocks(packet_bytes, kPlainHeaders),
                      extended = Blocks(packet_bytes, kExtendedHeaders);
  const Packet full(packet_bytes - kPlainHeaders), extended_full(packet_bytes - kExtendedHeaders),
      leader = Leader(400, 250);
  Packet too_long = Plain(3, 9, 1, full);
  too_long.push_back(0);
  std::vector<Case> cases{
      {"leader", Plain(1, 9, 0, leader), true},
      {"extended leader", Extended(1, 9, 0, leader), true},
      {"leader with chunks", Plain(1, 9, 0, Leader(400, 250, 0x01080001, 0x4001)), true},
      {"leader, two bytes a pixel", Plain(1, 9, 0, Leader(200, 250, 0x01100005)), true},
      {"payload", Plain(3, 9, 1, full), true},
      {"last payload", Plain(3, 9, plain, {1}), true},
      {"last extended payload", Extended(3, 9, extended, extended_full), true},
      {"trailer", Plain(2, 9, plain + 1, Words({1, 250})), true},
      {"early trailer", Plain(2, 9, 1, Words({1, 250})), true},
      {"extended trailer", Extended(2, 9, extended + 1, Words({1, 250})), true},

      {"trailer beyond the payload", Plain(2, 9, plain + 2), false},
      {"extended trailer beyond the payload", Extended(2, 9, extended + 2), false},
      {"trailer of a frame without packets", Plain(2, 9, 0), false},
      {"payload beyond the last", Plain(3, 9, plain + 1, full), false},
      {"extended payload beyond the last", Extended(3, 9, extended + 1, extended_full), false},
      {"payload before the first", Plain(3, 9, 0, full), false},
      {"payload longer than was negotiated", too_long, false},
      {"leader with a number", Plain(1, 9, 1, leader), false},
      {"leader one pixel wider than a packet may say", Plain(1, 9, 0, Leader(0x10000, 1)), false},
      {"extended leader one row higher than that", Extended(1, 9, 0, Leader(1, 0x10000)), false},
      {"leader of one row too many", Plain(1, 9, 0, Leader(400, 251)), false},
      {"leader of one column too many", Plain(1, 9, 0, Leader(401, 250)), false},
      {"leader, two bytes a pixel, one row too many", Plain(1, 9, 0, Leader(200, 251, 0x01100005)), false},
      {"leader of no bits a pixel", Plain(1, 9, 0, Leader(400, 250, 0x01000001)), false},
      {"leader of raw data", Plain(1, 9, 0, Leader(400, 250, 0x01080001, 2)), false},
      {"leader of unknown data", Plain(1, 9, 0, Leader(400, 250, 0x01080001, 0)), false},
      {"leader of one part", Plain(1, 9, 1, MultipartLeader(1, kPayload)), false},
      {"part", Plain(7, 9, 1, full), false},
      {"all in one", Plain(4, 9, 0, full), false},
      {"H.264", Plain(5, 9, 1, full), false},
      {"unknown kind", Plain(0x33, 9, 1, full), false},
      {"extended unknown kind", Extended(0, 9, 1), false}};
  // One byte shorter than the kind must be.
  const std::pair<const char*, Packet> shortest[] = {{"leader", Plain(1, 9, 0, leader)},
                                                     {"extended leader", Extended(1, 9, 0, leader)},
                                                     {"header", Plain(2, 9, 1)},
                                                     {"extended header", Extended(2, 9, 1)}};
  for (const auto& [what, whole] : shortest)
    cases.push_back(
        {fmt::format("{} without its last byte", what), Packet(whole.begin(), whole.end() - 1), false});
  return cases;
}

TEST(StreamGuard, PassesWhatFitsAndCountsTheRest) {
  for (const std::uint32_t packet_bytes : {576u, 9000u}) {
    const UdpSocket camera, receiver;
    const StreamGuard guard(receiver.fd(), {.camera = "127.0.0.1",
                                            .source_port = camera.Port(),
                                            .payload_bytes = kPayload,
                                            .packet_bytes = packet_bytes});
    std::uint64_t refused = 0;
    for (const auto& [what, packet, passes] : Cases(packet_bytes)) {
      SCOPED_TRACE(what);
      camera.Send(packet, "127.0.0.1", receiver.Port());
      const auto got = receiver.Receive(0);  // on loopback it is there when it is sent
      EXPECT_EQ(got.has_value(), passes);
      if (got) {
        EXPECT_EQ(*got, packet);
      }
      if (!passes) ++refused;
      EXPECT_EQ(guard.Refused(), refused);
    }
  }
}

TEST(StreamGuard, LetsNobodyElseIn) {
  const UdpSocket camera, other_port, other_address("127.0.0.77"), receiver;
  StreamGuard guard(
      receiver.fd(),
      {.camera = "127.0.0.1", .source_port = camera.Port(), .payload_bytes = kPayload, .packet_bytes = 1500});
  const auto arrives = [&](const UdpSocket& from) {
    from.Send(Plain(1, 9, 0, Leader(400, 250)), "127.0.0.1", receiver.Port());
    return receiver.Receive(0).has_value();
  };
  EXPECT_TRUE(arrives(camera));
  EXPECT_FALSE(arrives(other_port));
  EXPECT_FALSE(arrives(other_address));
  EXPECT_EQ(guard.Refused(), 2u);
  guard.AllowAnyPort();
  EXPECT_TRUE(arrives(camera));
  EXPECT_TRUE(arrives(other_port)) << "of a camera that tells the wrong one";
  EXPECT_FALSE(arrives(other_address));
  EXPECT_EQ(guard.Refused(), 3u);
}

TEST(StreamGuard, RefusesSizesThatCarryNothing) {
  const UdpSocket receiver;
  EXPECT_THROW(StreamGuard(receiver.fd(), {.camera = "127.0.0.1", .payload_bytes = 10, .packet_bytes = 48}),
               Error);
  EXPECT_THROW(StreamGuard(receiver.fd(), {.camera = "127.0.0.1", .payload_bytes = 0, .packet_bytes = 1500}),
               Error);
  EXPECT_THROW(StreamGuard(receiver.fd(), {.camera = "camera", .payload_bytes = 10, .packet_bytes = 1500}),
               Error);
}

}  // namespace
}  // namespace ulf::test::stream_guard_test
