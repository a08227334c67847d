// Tests: acquisition/link/link_facts.
//
// What is said of a link without a trial: each thing that is not in order, and the one remedy beside it.
#include "acquisition/link/link_facts.h"

#include <gmock/gmock.h>

namespace ulf::acquisition::link_facts_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A camera of 2.6 MB a frame at gigabit Ethernet.
struct GigabitLink {
  DeviceInfo camera{.uri = "aravis:192.0.2.7",
                    .maker = {},
                    .model = {},
                    .serial = {},
                    .bus = "GigEVision",
                    .problem = {},
                    .address = "192.0.2.7"};
  LinkPath path{.network = NetworkLink{.interface = "eth0", .mtu = 9000, .bytes_per_s = 125e6},
                .usb = {},
                .usb_memory_mb = {}};
  DeviceStatistics counted;
  double fps = 30, packet_size = 8000, buffer = 6e6;
  std::optional<double> limit, exposure_us;

  LinkFacts Facts() {
    counted.transport = {
        {TransportFigure::kPayloadBytes, 2.6e6},     {TransportFigure::kSetFps, fps},
        {TransportFigure::kPacketSize, packet_size}, {TransportFigure::kResends, 1},
        {TransportFigure::kSocketBufferAsked, 6e6},  {TransportFigure::kSocketBuffer, buffer}};
    if (exposure_us) counted.transport.emplace_back(TransportFigure::kExposureUs, *exposure_us);
    if (limit) counted.transport.emplace_back(TransportFigure::kThroughputLimit, *limit);
    return DescribeLink(camera, path, counted);
  }
  // The only fact that is not in order.
  LinkFact Wrong() {
    LinkFact wrong;
    for (const LinkFact& fact : Facts().facts)
      if (!fact.in_order) {
        EXPECT_EQ(wrong.name, "") << "besides " << fact.name;
        wrong = fact;
      }
    return wrong;
  }
};

GigabitLink OnUsb(const char* port, int megabits, std::optional<int> memory_mb) {
  GigabitLink setup;
  setup.camera.bus = "USB3Vision";
  setup.camera.address.clear();
  setup.path = {
      .network = {},
      .usb =
          UsbCameraPlace{
              .maker = {}, .model = {}, .serial = {}, .node = {}, .port = port, .megabits = megabits},
      .usb_memory_mb = memory_mb};
  return setup;
}

TEST(LinkFacts, AGoodLinkHasNothingToMend) {
  GigabitLink setup;
  EXPECT_EQ(setup.Wrong().name, "");
  EXPECT_NEAR(*setup.Facts().most_fps, MostGigeFps(125e6, 2.6e6, 8000), 1e-9);
  EXPECT_EQ(setup.Facts().facts.front().value, "eth0 to 192.0.2.7: 1000 Mbit/s, MTU 9000");
}

TEST(LinkFacts, RateBeyondTheLinkNamesTheHighestSafeOne) {
  GigabitLink setup;
  setup.fps = 60;
  const LinkFact rate = setup.Wrong();
  EXPECT_EQ(rate.name, "rate");
  const double advised = std::atof(rate.advice.c_str() + std::string("fps=").size());
  EXPECT_LT(advised, *setup.Facts().most_fps);
  EXPECT_GT(advised, 0.9 * *setup.Facts().most_fps);
  setup.fps = advised;
  EXPECT_EQ(setup.Wrong().name, "") << "as advised";
}

TEST(LinkFacts, JumboFramesAreAdvisedWhereSufficient) {
  GigabitLink setup;
  setup.path.network->mtu = 1500;
  setup.packet_size = 1500;
  // Between what small and large packets leave of the wire.
  setup.fps = (MostGigeFps(125e6, 2.6e6, 1500) + MostGigeFps(125e6, 2.6e6, 9000)) / 2;
  EXPECT_THAT(setup.Wrong().advice, HasSubstr("ip link set eth0 mtu 9000"));
  setup.fps = 60;
  EXPECT_THAT(setup.Wrong().advice, Not(HasSubstr("mtu")));
}

TEST(LinkFacts, NamePacketsTheInterfaceDoesNotPass) {
  GigabitLink setup;
  setup.path.network->mtu = 1500;
  const LinkFact packets = setup.Wrong();
  EXPECT_EQ(packets.name, "packets");
  EXPECT_THAT(packets.advice, AllOf(HasSubstr("packet_size=1500"), HasSubstr("ip link set eth0 mtu 9000")));
}

TEST(LinkFacts, SmallReceiveBufferNamesTheSetting) {
  GigabitLink setup;
  setup.buffer = 3e6;
  EXPECT_EQ(setup.Wrong().name, "") << "a frame fits";
  setup.buffer = 212992;
  setup.path.most_buffer = 212992;
  const LinkFact buffer = setup.Wrong();
  EXPECT_EQ(buffer.name, "receive buffer");
  EXPECT_THAT(buffer.value, HasSubstr("the system allows 0.2"));
  EXPECT_THAT(buffer.advice, HasSubstr("sysctl net.core.rmem_max=6000000"));
}

TEST(LinkFacts, ThrottledCameraNamesTheSufficientLimit) {
  GigabitLink setup;
  setup.limit = 30e6;
  const LinkFact limit = setup.Wrong();
  EXPECT_EQ(limit.name, "camera's limit");
  const double advised = std::atof(limit.advice.c_str() + std::string("throughput_limit=").size());
  EXPECT_GE(advised, 30 * 2.6e6);
  setup.limit = advised;
  EXPECT_EQ(setup.Wrong().name, "") << "as advised";
}

TEST(LinkFacts, AUsb2PortIsNamedWhereItIsTooSlow) {
  GigabitLink setup = OnUsb("2-1", 480, 16);
  bool port_is_wrong = false;
  for (const LinkFact& fact : setup.Facts().facts)
    if (fact.name == "port") {
      port_is_wrong = !fact.in_order;
      EXPECT_THAT(fact.advice, HasSubstr("USB 3 port"));
    }
  EXPECT_TRUE(port_is_wrong) << "30 frames of 2.6 MB";
  setup.path.usb->megabits = 5000;
  EXPECT_EQ(setup.Wrong().name, "");
}

TEST(LinkFacts, LostFramesNameTheCheckThatFindsTheRemedy) {
  GigabitLink setup;
  EXPECT_FALSE(LostSoFar(setup.camera, setup.counted)) << "before the first frame";
  setup.counted.delivered = 400;
  setup.counted.incomplete = 1;
  EXPECT_TRUE(LostSoFar(setup.camera, setup.counted)->in_order) << "the first of a stream may be lost";
  setup.counted.missing = 9;
  EXPECT_FALSE(LostSoFar(setup.camera, setup.counted)->in_order);
  EXPECT_THAT(LostSoFar(setup.camera, setup.counted)->advice,
              HasSubstr("ulf devices --check 'aravis:192.0.2.7"));
  setup.camera.address.clear();
  setup.camera.bus = "simulated";
  EXPECT_FALSE(LostSoFar(setup.camera, setup.counted)) << "it has no link";
}

TEST(LinkFacts, CameraIsTheLimitByItsSettingOrLink) {
  LinkFacts facts;
  EXPECT_EQ(CameraLimitText(20, facts), "") << "nothing is known";
  facts.set_fps = 60;
  facts.most_fps = 25;
  EXPECT_EQ(CameraLimitText(24, facts), "") << "as many as the link carries";
  facts.most_fps = 100;
  EXPECT_THAT(CameraLimitText(24, facts), HasSubstr("24 frames a second where the link carries 100"));
  facts.most_fps = 25;
  facts.set_fps = 24;
  EXPECT_THAT(CameraLimitText(23.9, facts), HasSubstr("allows 24 frames a second"));
}

TEST(LinkFacts, CameraSendingLessThanSetIsTheLimit) {
  LinkFacts facts;
  facts.set_fps = 30;
  EXPECT_THAT(CameraLimitText(10, facts), HasSubstr("sent 10 of the 30 frames a second that it is set to"));
  facts.busy_share = 0.95;
  EXPECT_EQ(CameraLimitText(10, facts), "") << "packets come all the time: the link may be full";
  facts.exposure_s = 0.02;
  EXPECT_EQ(CameraLimitText(10, facts), "") << "it would allow 50";
  facts.exposure_s = 0.1;
  EXPECT_THAT(CameraLimitText(10, facts),
              HasSubstr("its exposure time of 100 ms allows at most 10 frames a second"));
  facts.exposure_s = 0.06;
  EXPECT_THAT(CameraLimitText(10, facts), HasSubstr("exposure time of 60 ms allows at most 16.67"))
      << "it reads out afterwards";
}

TEST(LinkFacts, ARateIsNotHigherThanTheExposureAllows) {
  GigabitLink setup;
  setup.fps = 100;
  EXPECT_EQ(setup.Wrong().name, "rate");
  setup.exposure_us = 100'000;
  EXPECT_EQ(setup.Wrong().name, "");
  EXPECT_EQ(setup.Facts().set_fps, 100);
  EXPECT_THAT(setup.Facts().facts.back().value,
              HasSubstr("is set to 100.0, of which its exposure time allows 10.0"));
}

TEST(LinkFacts, NeighboursCountByTheirLinksRate) {
  GigabitLink setup = OnUsb("2-1.1", 5000, {});
  const auto beside_it = [&] {
    for (const LinkFact& fact : setup.Facts().facts)
      if (fact.name == "beside it") return fact;
    return LinkFact{};
  };
  EXPECT_EQ(beside_it().name, "") << "alone";
  setup.path.usb_neighbours = {
      {.name = "Disk", .port = "2-2", .megabits = 10000, .hub = {}, .hub_megabits = 0}};
  EXPECT_THAT(beside_it().value, AllOf(HasSubstr("Disk (port 2-2, 10000 Mbit/s) at the same controller"),
                                       Not(HasSubstr("hub"))));
  EXPECT_THAT(beside_it().advice, HasSubstr("check such cameras together"));
  setup.path.usb_neighbours.push_back(
      {.name = "Webcam", .port = "2-1.2", .megabits = 480, .hub = "2-1", .hub_megabits = 5000});
  EXPECT_THAT(beside_it().value,
              HasSubstr("about 400 MB/s for all, this camera is set to 78.0, the others can take 40"));
  EXPECT_THAT(beside_it().advice, Not(HasSubstr("a port of the computer"))) << "78 and 40 of 400";
  setup.path.usb_neighbours.back().megabits = 5000;
  EXPECT_THAT(beside_it().advice, HasSubstr("a port of the computer for each"));
}

TEST(LinkRate, CountsHeadersAndGaps) {
  // Gigabit Ethernet at its ordinary packets: 117 to 120 of its 125 megabytes a second are pictures.
  const double megabytes = 640 * 480 * MostGigeFps(125e6, 640 * 480, 1500) / 1e6;
  EXPECT_GT(megabytes, 117);
  EXPECT_LT(megabytes, 120);
  EXPECT_GT(MostGigeFps(125e6, 640 * 480, 9000), MostGigeFps(125e6, 640 * 480, 1500));
  EXPECT_EQ(MostGigeFps(125e6, 640 * 480, 20), 0);
}

}  // namespace
}  // namespace ulf::acquisition::link_facts_test
