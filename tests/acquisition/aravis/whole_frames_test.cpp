// Tests: acquisition/aravis/aravis_frames.
//
// Which frames came whole: those whose packets all came and are as many as the leader's width and
// height need, however much room there was. The camera waits at a line, and the test sends its frames
// packet by packet.
#include <gmock/gmock.h>

#include "tests/acquisition/aravis/edited_camera.h"
#include "tests/support/gige_packets.h"

namespace ulf::test::whole_frames_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr std::uint32_t kSide = 64, kBlock = 576 - 36, kBlocks = (kSide * kSide + kBlock - 1) / kBlock;

// What a frame leaves out or says otherwise.
struct Sent {
  const char* what;
  std::uint32_t rows = kSide;          // as its leader says
  std::uint32_t without = 99;          // the packet that is lost: 0 is the leader, kBlocks + 1 the trailer
  std::uint32_t ends_after = kBlocks;  // blocks, then the trailer
  std::uint32_t short_by = 0;          // bytes of the last block
  bool is_whole = false;
};

class WholeFrames : public EditedCamera {
 protected:
  // The pixel at (x, y) is 3 x + 5 y.
  void Send(const Sent& sent) {
    ++id_;
    const auto send = [&](std::uint32_t number, const Packet& packet) {
      if (number != sent.without) forger_->Send(packet, ends_.from, ends_.to);
    };
    send(0, Plain(1, id_, 0, Leader(kSide, sent.rows)));
    for (std::uint32_t block = 1; block <= sent.ends_after; ++block) {
      std::uint32_t end = std::min(kSide * kSide, block * kBlock);
      if (block == sent.ends_after) end -= sent.short_by;
      Packet pixels;
      for (std::uint32_t at = (block - 1) * kBlock; at < end; ++at)
        pixels.push_back(static_cast<std::uint8_t>(3 * (at % kSide) + 5 * (at / kSide)));
      send(block, Plain(3, id_, block, pixels));
    }
    send(sent.ends_after + 1, Plain(2, id_, sent.ends_after + 1, Words({1, sent.rows})));
  }

  void ExpectEach(const std::string& payload) {
    Replace("<Formula>W*H*((F&gt;&gt;16)&amp;0xFF)/8</Formula>", "<Formula>" + payload + "</Formula>");
    Start();
    const auto device = OpenDriver(kCamera + "?format=Mono8&roi=64x64+0+0&trigger=Line0&packet_size=576");
    device->Start();
    ends_ = AskStreamEnds("127.0.0.1");
    forger_.emplace();
    const Sent good{.what = "whole", .is_whole = true};
    for (const Sent& sent : {good, Sent{.what = "a packet is lost", .without = 4},
                             Sent{.what = "the first is lost", .without = 1},
                             Sent{.what = "the last is lost", .without = kBlocks},
                             Sent{.what = "the trailer is lost", .without = kBlocks + 1},
                             Sent{.what = "the trailer comes early", .ends_after = 4},
                             Sent{.what = "no packet but the ends", .ends_after = 0},
                             Sent{.what = "one byte short", .short_by = 1},
                             Sent{.what = "of half the rows", .rows = kSide / 2}, good}) {
      SCOPED_TRACE(sent.what);
      Send(sent);
      if (!sent.is_whole) Send(good);  // the next closes it
      for (const bool is_whole : sent.is_whole ? std::vector{true} : std::vector{false, true}) {
        const auto frame = device->Next(5s);
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->status, is_whole ? FrameStatus::kComplete : FrameStatus::kIncomplete);
        if (is_whole) {
          EXPECT_EQ(frame->image.pixels.at<std::uint8_t>(63, 61), (3 * 61 + 5 * 63) % 256);
        }
      }
    }
    EXPECT_THAT(Said(*device), Contains(HasSubstr("was set to 64x64 Mono8")));
  }

  std::optional<Forger> forger_;  // opened where the camera is, in the namespace
  StreamEnds ends_{};
  std::uint16_t id_ = 0;
};

TEST_F(WholeFrames, AreToldByPacketsWhenTheRoomFits) { ExpectEach("W*H"); }
TEST_F(WholeFrames, AreToldByPacketsWhenRoomIsLarger) { ExpectEach("2048*2048"); }
TEST_F(WholeFrames, AreToldByPacketsWhenRoomIsTooSmall) { ExpectEach("W"); }

}  // namespace
}  // namespace ulf::test::whole_frames_test
