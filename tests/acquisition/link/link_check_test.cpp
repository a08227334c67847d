// Tests: acquisition/link/link_check, acquisition/link/host_link, commands/camera/devices_command.
//
// Links that carry what a camera sends, that are too slow for it, or that do not pass its packets: loopback
// behind the kernel's own limits (tc). What the check advises is followed, and then nothing is lost.
#include "acquisition/link/link_check.h"

#include <fmt/format.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "acquisition/link/host_link.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "tests/acquisition/aravis/edited_camera.h"
#include "tests/support/child_process.h"
#include "tests/support/test_paths.h"

namespace ulf::test::link_check_test {
namespace {

namespace fs = std::filesystem;
using acquisition::CheckLink;
using acquisition::LinkReport;
using acquisition::LinkTrial;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class LinkCheck : public CameraInNamespace {
 protected:
  void TearDown() override {
    std::system("tc qdisc del dev lo root 2>/dev/null");
    if (changed_mtu_) SetMtu("65536");
  }

  bool SetMtu(const std::string& bytes) {
    changed_mtu_ = true;
    return std::system(("ip link set lo mtu " + bytes).c_str()) == 0;
  }

  static bool Limit(const std::string& qdisc) {
    return std::system(("tc qdisc replace dev lo root " + qdisc).c_str()) == 0;
  }

  static std::string ValueOf(const LinkReport& report, const std::string& name) {
    for (const auto& fact : report.facts)
      if (fact.name == name) return fact.value;
    return "";
  }

  // `settings` replace those of the URI.
  static LinkTrial Stream(const std::string& uri, const std::string& settings, double seconds) {
    DeviceUri with = DeviceUri::Parse(uri);
    for (const auto& [option, value] : DeviceUri::Parse("aravis:?" + settings).options)
      with.Set(option, value);
    return CheckLink(with.Text(), {.seconds = seconds, .packet_sizes = {}, .most_rates = 0}).trials.front();
  }

 private:
  bool changed_mtu_ = false;
};

TEST_F(LinkCheck, AGoodLinkCarriesWhatIsAskedFor) {
  StartCamera();
  const LinkReport report =
      CheckLink("aravis:T1?roi=512x512+0+0&fps=20", {.seconds = 0.8, .first_frame_s = 2});
  EXPECT_TRUE(report.Holds());
  EXPECT_FALSE(report.remedy);
  ASSERT_EQ(report.trials.size(), 1u);
  EXPECT_GT(report.trials[0].whole, 10u);
  EXPECT_NEAR(report.trials[0].fps, 20, 5);
  EXPECT_EQ(report.payload_bytes, 512 * 512);
  EXPECT_THAT(ValueOf(report, "link"), AllOf(HasSubstr("lo to 127.0.0.1"), HasSubstr("MTU 65536")));
  EXPECT_THAT(ValueOf(report, "packets"), HasSubstr("bytes"));
  EXPECT_EQ(report.camera.address, "127.0.0.1");
}

TEST_F(LinkCheck, NamedRateLosesNothingOnASlowLink) {
  StartCamera();
  // Room for two frames: the third is lost in part.
  if (!Limit("tbf rate 40mbit burst 64kb latency 15ms")) GTEST_SKIP() << "tc or its token bucket is not here";
  // Eight megabytes a second into five.
  const std::string uri = "aravis:T1?roi=256x256+0+0&fps=120";
  const LinkReport report = CheckLink(uri, {.seconds = 0.8, .first_frame_s = 2});
  EXPECT_TRUE(report.trials.front().LostFrames());
  ASSERT_TRUE(report.remedy) << report.trials.size() << " trials";
  ASSERT_THAT(*report.remedy, StartsWith("fps="));
  const double fps = std::atof(report.remedy->c_str() + 4);
  EXPECT_LT(fps, 77) << "what five megabytes a second carry";
  EXPECT_GT(fps, 15) << "and not much less";
  const LinkTrial with = Stream(uri, *report.remedy, 3);
  EXPECT_FALSE(with.LostFrames());
  EXPECT_FALSE(with.TooSlow()) << with.fps;
  EXPECT_TRUE(Stream(uri, "", 1.5).LostFrames()) << "as before without it";
}

// A sender that waits for its link loses nothing, and sends less than was asked for.
TEST_F(LinkCheck, ACameraThatTheLinkHoldsBackIsTooSlow) {
  StartCamera();
  if (!Limit("tbf rate 40mbit burst 64kb latency 500ms"))
    GTEST_SKIP() << "tc or its token bucket is not here";
  // A computer that does other work holds the camera back, too, or loses frames: one quiet check is enough.
  LinkReport report;
  const auto was_disturbed = [&] {
    return !report.camera_limit.empty() || !report.remedy || !report.remedy->starts_with("fps=");
  };
  for (int i = 0; i < 4 && (i == 0 || was_disturbed()); ++i)
    report = CheckLink("aravis:T1?roi=512x512+0+0&fps=40", {.seconds = 0.8, .first_frame_s = 2});
  EXPECT_TRUE(report.trials.front().TooSlow()) << report.trials.front().fps;
  EXPECT_EQ(report.camera_limit, "") << "its packets come all the time";
  ASSERT_TRUE(report.remedy);
  EXPECT_THAT(*report.remedy, StartsWith("fps="));
}

TEST_F(LinkCheck, FindsSmallerPacketsWhenLargeOnesFail) {
  StartCamera();
  // A bucket drops what is larger than itself.
  if (!Limit("tbf rate 4gbit burst 2500 latency 200ms")) GTEST_SKIP() << "tc or its token bucket is not here";
  const std::string uri = "aravis:T1?roi=512x512+0+0&fps=5&packet_size=8000";
  const LinkReport report = CheckLink(uri, {.seconds = 0.8, .first_frame_s = 2});
  EXPECT_EQ(report.trials.front().whole, 0u);
  ASSERT_TRUE(report.remedy);
  EXPECT_THAT(*report.remedy, StartsWith("packet_size=1"));
  const LinkTrial with = Stream(uri, *report.remedy, 3);
  EXPECT_FALSE(with.LostFrames());
  EXPECT_FALSE(with.TooSlow()) << with.fps;
}

// The simulated camera keeps the pause between packets, and a limit of its own.
class LinkOfSimulated : public LinkCheck {
 protected:
  void Serve() {
    GigeServerOptions options;
    options.simulation.width = options.simulation.height = 512;
    options.simulation.noise = false;
    options.simulation.format = SensorFormat::kMono8;
    options.loop = 4;
    server_ = std::make_unique<SimulatedGigeCamera>(options);
  }
  void TearDown() override {
    server_.reset();
    LinkCheck::TearDown();
  }

  std::unique_ptr<SimulatedGigeCamera> server_;
};

TEST_F(LinkOfSimulated, SpreadsPacketsForASmallSwitch) {
  Serve();
  // Five megabytes a second, of which the camera sends 1.3; but of a frame of 262 KB at once only 82 pass.
  if (!Limit("tbf rate 40mbit burst 32kb latency 10ms")) GTEST_SKIP() << "tc or its token bucket is not here";
  const std::string uri = "aravis:127.0.0.1?format=Mono8&fps=5&resend=off";
  const LinkReport report = CheckLink(uri, {.seconds = 1, .first_frame_s = 2, .packet_sizes = {}});
  EXPECT_TRUE(report.trials.front().LostFrames());
  ASSERT_TRUE(report.remedy) << report.trials.size() << " trials";
  EXPECT_THAT(*report.remedy, StartsWith("packet_delay_ns="));
  // Packets of a sender that other tests hold up come in bunches: one of three tries must be without a loss.
  LinkTrial with = Stream(uri, *report.remedy, 2);
  for (int again = 0; again < 2 && with.incomplete + with.missing > 0; ++again)
    with = Stream(uri, *report.remedy, 2);
  EXPECT_EQ(with.incomplete + with.missing, 0u);
  EXPECT_NEAR(with.fps, 5, 1);
}

TEST_F(LinkOfSimulated, NamesTheSufficientThroughputLimit) {
  Serve();
  const std::string uri = "aravis:127.0.0.1?format=Mono8&fps=10&throughput_limit=1000000";
  const LinkReport report = CheckLink(uri, {.seconds = 1, .first_frame_s = 2});
  EXPECT_TRUE(report.trials.front().TooSlow()) << report.trials.front().fps;
  EXPECT_FALSE(report.trials.front().LostFrames());
  ASSERT_TRUE(report.remedy);
  EXPECT_THAT(*report.remedy, StartsWith("throughput_limit="));
  EXPECT_THAT(ValueOf(report, "camera's limit"), HasSubstr("1.0 MB/s"));
  EXPECT_NEAR(Stream(uri, *report.remedy, 2).fps, 10, 1);
}

// A camera that says 30 frames a second and sends ten.
class SlowCamera : public EditedCamera {
 protected:
  void Serve(const std::string& rate) {
    ReplaceNode("Float", "AcquisitionFrameRate", rate);
    Add(Constant("Thirty", 30) + Register("RateReg", "0x10b0") +
        "<Integer Name=\"RealPeriod\"><pValue>PeriodReg</pValue></Integer>");
    Start();
    OpenFeatures(kCamera)->Set("RealPeriod", "100000");
  }
  static inline const std::string kTen = kCamera + "?format=Mono8&roi=64x64+0+0";
};

TEST_F(SlowCamera, IsNamedAsTheLimit) {
  Serve("<Float Name=\"AcquisitionFrameRate\"><pValue>Thirty</pValue></Float>");
  const LinkReport report = CheckLink(kTen, {.seconds = 1, .first_frame_s = 2});
  EXPECT_TRUE(report.Holds()) << "nobody asked for more";
  EXPECT_FALSE(report.remedy);
  EXPECT_EQ(report.trials.size(), 1u);
  EXPECT_NEAR(report.trials.front().fps, 10, 2);
  EXPECT_THAT(report.camera_limit, HasSubstr("of the 30 frames a second that it is set to"));
  const auto run = RunUlf("devices --check '" + kTen + "' --seconds 1");
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("the camera is set to 30"), HasSubstr("less than it is set to")));
  // It cannot be told another rate.
  const LinkReport asked = CheckLink(kTen + "&fps=30", {.seconds = 1, .first_frame_s = 2});
  EXPECT_FALSE(asked.Holds());
  EXPECT_EQ(asked.trials.size(), 1u) << "what it refuses is no trial";
  EXPECT_THAT(asked.camera_limit, HasSubstr("of the 30"));
}

TEST_F(SlowCamera, ItsExposureTimeIsNamedAsTheCause) {
  Serve(
      "<Float Name=\"AcquisitionFrameRate\"><pValue>RateInteger</pValue><Min>1</Min><Max>100</Max></Float>"
      "<Integer Name=\"RateInteger\"><pValue>RateReg</pValue></Integer>");
  const LinkReport report =
      CheckLink(kTen + "&fps=30&exposure_us=90000", {.seconds = 1, .confirmed_times = 1, .first_frame_s = 2});
  EXPECT_FALSE(report.trials.front().LostFrames());
  EXPECT_THAT(report.camera_limit,
              HasSubstr("its exposure time of 90 ms allows at most 11.11 frames a second"));
  ASSERT_TRUE(report.remedy);
  EXPECT_NEAR(std::atof(report.remedy->c_str() + 4), 10, 2) << *report.remedy;
}

// Each advice is followed for a minute: no frame may be lost, and as many must come as it promises. Behind
// each limit stands the link or the camera that it is about.
class LinkAdvice : public LinkOfSimulated {
 protected:
  // `limit`: of the token bucket; null: none.
  void Follow(const std::string& situation, const char* limit, const std::string& asked,
              const std::string& advice) {
    Serve();
    if (limit && !Limit(limit)) GTEST_SKIP() << "tc or its token bucket is not here";
    const std::string uri = "aravis:127.0.0.1?format=Mono8&resend=off&" + asked;
    const LinkReport report =
        CheckLink(uri, {.seconds = 4, .first_frame_s = 3, .packet_sizes = {4000, 1500, 576}});
    EXPECT_FALSE(report.trials.front().Held()) << "nothing is to be mended";
    ASSERT_TRUE(report.remedy) << report.trials.size() << " trials";
    EXPECT_THAT(*report.remedy, StartsWith(advice));
    const LinkTrial minute = Stream(uri, *report.remedy, 60);
    fmt::print("{}: '{}', a minute at {:.1f} frames a second: {} lost of {}\n", situation, *report.remedy,
               minute.fps, minute.incomplete + minute.missing,
               minute.whole + minute.incomplete + minute.missing);
    EXPECT_FALSE(minute.LostFrames());
    EXPECT_FALSE(minute.TooSlow()) << minute.fps << " of " << minute.asked_fps;
  }
};

TEST_F(LinkAdvice, NamesALowerRateOnASlowLink) {
  Follow("slow link", "tbf rate 40mbit burst 300kb latency 60ms", "roi=256x256+0+0&fps=120", "fps=");
}
TEST_F(LinkAdvice, NamesSmallerPacketsWhenLargeOnesFail) {
  Follow("small packets", "tbf rate 4gbit burst 2500 latency 200ms", "fps=5&packet_size=8000",
         "packet_size=1500");
}
TEST_F(LinkAdvice, NamesAPacketDelayForASmallSwitch) {
  Follow("small switch", "tbf rate 40mbit burst 32kb latency 10ms", "fps=5", "packet_delay_ns=");
}
TEST_F(LinkAdvice, NamesAHigherLimitOnAThrottledCamera) {
  Follow("camera's limit", nullptr, "fps=10&throughput_limit=1000000", "throughput_limit=");
}
TEST_F(LinkAdvice, NamesAReceiveBufferThatHoldsAFrame) {
  Follow("receive buffer", nullptr, "fps=30&socket_buffer=20000", "socket_buffer=");
}

// The advice is a command for the system: it is run.
TEST_F(LinkAdvice, NamesAnInterfaceForJumboFrames) {
  Serve();
  if (!SetMtu("1500")) GTEST_SKIP() << "the interface's MTU cannot be changed here";
  const std::string uri = "aravis:127.0.0.1?format=Mono8&resend=off&fps=10&packet_size=8000";
  const auto packets = [&](double seconds) {
    const LinkReport report = CheckLink(uri, {.seconds = seconds, .first_frame_s = 3, .packet_sizes = {}});
    EXPECT_FALSE(report.trials.front().LostFrames());
    for (const auto& fact : report.facts)
      if (fact.name == "packets") return fact;
    return acquisition::LinkFact{};
  };
  const acquisition::LinkFact small = packets(2);
  EXPECT_FALSE(small.in_order) << small.value;
  const std::size_t begin = small.advice.find("'ip link set lo mtu 9000'");
  ASSERT_NE(begin, std::string::npos) << small.advice;
  const std::string command = small.advice.substr(begin + 1, small.advice.find('\'', begin + 1) - begin - 1);
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  EXPECT_TRUE(packets(60).in_order);
}

TEST_F(LinkOfSimulated, NamesPacketsAboveTheMtu) {
  Serve();
  if (!SetMtu("1500")) GTEST_SKIP() << "the interface's MTU cannot be changed here";
  EXPECT_EQ(acquisition::NetworkLinkTo("127.0.0.1")->mtu, 1500);
  const LinkReport report = CheckLink("aravis:127.0.0.1?format=Mono8&fps=10&packet_size=8000",
                                      {.seconds = 0.5, .first_frame_s = 3, .packet_sizes = {}});
  EXPECT_THAT(ValueOf(report, "packets"), HasSubstr("more than the MTU of 1500 passes"));
  EXPECT_THAT(ValueOf(report, "link"), HasSubstr("MTU 1500"));
}

TEST(HostLink, IsFoundByTheAddressAlone) {
  EXPECT_FALSE(acquisition::NetworkLinkTo("no address"));
  ASSERT_TRUE(acquisition::NetworkLinkTo("127.0.0.1"));
  EXPECT_EQ(acquisition::NetworkLinkTo("127.0.0.1")->interface, "lo");
  EXPECT_FALSE(acquisition::NetworkLinkTo("127.0.0.1")->bytes_per_s) << "it has no wire";
}

TEST(DevicesCheck, TheCommandSaysWhetherTheLinkHolds) {
  const auto run = RunUlf("devices --check 'sim:studio?width=64&height=48&fps=20' --seconds 0.5 --json");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto report = JsonFromText(run.output);
  EXPECT_TRUE(report["holds"]);
  EXPECT_EQ(report["trials"].size(), 1u);
  EXPECT_EQ(report["verdict"], "the link carries what the camera sends");
  EXPECT_THAT(RunUlf("devices --check 'sim:studio?width=64&height=48' --seconds 0.5").output,
              AllOf(HasSubstr("as asked for"), HasSubstr("none lost"), HasSubstr("result")));
  EXPECT_EQ(RunUlf("devices --seconds 3").exit_code, 2);
  const ScratchFolder scratch;
  fs::create_directories(scratch / "frames");
  const auto none = RunUlf("devices --check replay:" + (scratch / "frames").string());
  EXPECT_NE(none.exit_code, 0);
}

}  // namespace
}  // namespace ulf::test::link_check_test
