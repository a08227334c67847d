// A camera that loses some of its frames, taken from for a while: what came of them, against the truth.
//
//   lossy_camera link SHARE SEED      GigE Vision behind a link that loses this share of the packets
//   lossy_camera webcam SHARE SEED    a webcam that loses, marks as damaged or cuts this share of the frames
//   lossy_camera holes BYTES SEED     a webcam with so many bytes missing from every third JPEG
//   lossy_camera KIND                 says whether this machine can
//
// A process of its own each time: the link needs a network of its own, the webcam a library loaded first.
// Writes `whole W could C others N uncounted U damaged D said S`: frames given as complete; frames that could
// have been (of a webcam: that were sent whole between the first and the last of them); frames that were not,
// and how many of those between the first and the last no statistic counts; complete ones with wrong pixels;
// whether anything tells of what is not there. Exits with 3 and a reason where the machine cannot.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>

#include "acquisition/device/device.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/gige/gige_relay.h"
#include "core/frames/pixel_format.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/v4l2_camera.h"

namespace ulf::test {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr int kCannot = 3;
constexpr double kSeconds = 1.2;

struct Taken {
  std::set<std::uint64_t> whole;
  std::uint64_t damaged = 0;
  DeviceStatistics statistics;
  std::vector<DeviceEvent> events;
};

template <typename IsRight>
Taken TakeFor(double seconds, Device& device, const IsRight& is_right) {
  Taken taken;
  device.Start();
  const auto begin = Clock::now();
  while (std::chrono::duration<double>(Clock::now() - begin).count() < seconds) {
    const auto frame = device.Next(milliseconds(100));
    if (!frame || frame->status != FrameStatus::kComplete) continue;
    taken.whole.insert(frame->id);
    taken.damaged += !is_right(*frame);
  }
  device.Stop();
  taken.statistics = device.Statistics();
  taken.events = device.TakeEvents();
  return taken;
}

// Without `is_sent_whole` all are. Before the first complete frame and after the last the statistics alone
// know of others: where hardly any is complete, one that happens to be says nothing of the rest.
void Print(const Taken& taken, const std::function<bool(std::uint64_t)>& is_sent_whole = {}) {
  const DeviceStatistics& s = taken.statistics;
  const std::uint64_t all = taken.whole.empty() ? 0 : *taken.whole.rbegin() - *taken.whole.begin() + 1;
  const std::uint64_t between = all - taken.whole.size(), counted = s.incomplete + s.missing + s.dropped;
  const std::uint64_t others = std::max(between, counted);
  std::uint64_t could = is_sent_whole ? 0 : taken.whole.size() + others;
  if (is_sent_whole)
    for (std::uint64_t i = 0; i < all; ++i) could += is_sent_whole(*taken.whole.begin() + i);
  fmt::print("whole {} could {} others {} uncounted {} damaged {} said {}\n", taken.whole.size(), could,
             others, between > counted ? between - counted : 0, taken.damaged,
             int{!taken.whole.empty() || counted > 0 || !taken.events.empty()});
  fmt::print("delivered {} incomplete {} missing {} dropped {}\n", s.delivered, s.incomplete, s.missing,
             s.dropped);
  for (const DeviceEvent& event : taken.events) fmt::print("{}\n", event.text);
}

int TakeOverLink(double lost_share, unsigned seed) {
  ChildProcess camera({FAKE_GIGE_CAMERA, "T1", "0", "127.0.0.1"});
  if (camera.ReadUntil("ready", 20).find("ready") == std::string::npos) return 1;
  const GigeRelay relay(
      {.camera = "127.0.0.1", .address = "127.0.0.5", .faults = {.lost = lost_share}, .seed = seed});
  const auto device =
      OpenDevice("aravis:127.0.0.5?format=Mono8&packet_size=1400&fps=50&roi=320x240+0+0&queue=16");
  const auto is_right = [](const Frame& frame) {
    for (int y = 0; y < frame.image.height(); ++y)
      for (int x = 0; x < frame.image.width(); ++x)
        if (frame.image.pixels.at<std::uint8_t>(y, x) != static_cast<std::uint8_t>(3 * x + 5 * y))
          return false;
    return true;
  };
  Print(TakeFor(kSeconds, *device, is_right));
  const GigeRelayStatistics r = relay.Statistics();
  fmt::print("link: {} frames, {} packets, {} lost, {} asked for again, {} sent again\n", r.frames, r.packets,
             r.lost, r.resend_requests, r.resent);
  return 0;
}

// A number of its own for every frame, from 0 to 1.
double Chance(unsigned seed, std::uint64_t frame) {
  std::mt19937_64 random(seed * 1000003 + frame);
  random.discard(4);
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

std::unique_ptr<Device> OpenWebcam() { return OpenDevice("v4l2:/dev/video0?settle=0&queue=16"); }

int TakeFromWebcam(double lost_share, unsigned seed) {
  const EmulatedMode mode{.width = 160, .height = 120};
  const EmulatedV4l2Camera camera(
      {.modes = {mode}, .fate = [=](std::uint32_t sequence) {
         constexpr std::array kFates{EmulatedFate::kLost, EmulatedFate::kDamaged, EmulatedFate::kCut};
         const double chance = Chance(seed, sequence);
         return chance < lost_share ? kFates[static_cast<std::size_t>(3 * chance / lost_share)]
                                    : EmulatedFate::kArrives;
       }});
  const auto device = OpenWebcam();
  const auto is_right = [&](const Frame& frame) {
    const auto bytes = EmulatedV4l2Camera::Ramp(mode, static_cast<std::uint32_t>(frame.id));
    const Image expected = ImageFromBytes(*PixelFormatByName("YUYV"), 160, 120, bytes.data(), bytes.size());
    return cv::norm(frame.image.pixels, expected.pixels, cv::NORM_INF) == 0;
  };
  Print(TakeFor(kSeconds, *device, is_right),
        [&](std::uint64_t frame) { return Chance(seed, frame) >= lost_share; });
  return 0;
}

// Something like a room: light and shade on several scales, edges, and a little noise.
cv::Mat Picture(unsigned seed) {
  cv::RNG random(seed);
  cv::Mat picture = cv::Mat::zeros(480, 640, CV_8UC3);
  for (int i = 0; i < 200; ++i) {
    const cv::Rect rectangle(random.uniform(-50, 640), random.uniform(-50, 480), random.uniform(5, 150),
                             random.uniform(5, 150));
    cv::rectangle(picture, rectangle,
                  cv::Scalar(random.uniform(0, 256), random.uniform(0, 256), random.uniform(0, 256)), -1);
  }
  cv::GaussianBlur(picture, picture, {}, 1);
  cv::Mat noise(picture.size(), CV_8UC3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 12);
  return picture + noise;
}

int TakeJpegsWithHoles(std::size_t missing_bytes, unsigned seed) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", Picture(seed), jpeg, {cv::IMWRITE_JPEG_QUALITY, 85});
  const auto is_holed = [](std::uint64_t frame) { return frame % 3 == 2; };
  const EmulatedV4l2Camera camera(
      {.modes = {{.fourcc = V4L2_PIX_FMT_MJPEG, .width = 640, .height = 480, .fps = {50}}},
       .render = [&](const EmulatedMode&, std::uint32_t sequence) {
         std::vector<std::uint8_t> sent = jpeg;
         if (!is_holed(sequence)) return sent;
         // Behind the tables, in what the picture is coded as.
         constexpr std::size_t kHeader = 700, kEnd = 2;
         const auto room = static_cast<double>(jpeg.size() - kHeader - kEnd - missing_bytes);
         const auto at = sent.begin() + kHeader + static_cast<std::ptrdiff_t>(room * Chance(seed, sequence));
         sent.erase(at, at + static_cast<std::ptrdiff_t>(missing_bytes));
         return sent;
       }});
  const auto device = OpenWebcam();
  Print(TakeFor(kSeconds, *device, [&](const Frame& frame) { return !is_holed(frame.id); }),
        [&](std::uint64_t frame) { return !is_holed(frame); });
  fmt::print("a JPEG has {} bytes\n", jpeg.size());
  return 0;
}

int Run(const std::string& kind, double how_much, unsigned seed) {
  const auto why_not = kind == "link" ? EnterLoopbackNamespace() : NoV4l2Emulation();
  if (why_not) {
    fmt::print("{}\n", *why_not);
    return kCannot;
  }
  if (how_much < 0) return 0;
  if (kind == "link") return TakeOverLink(how_much, seed);
  if (kind == "webcam") return TakeFromWebcam(how_much, seed);
  return TakeJpegsWithHoles(static_cast<std::size_t>(how_much), seed);
}

}  // namespace
}  // namespace ulf::test

int main(int count, char** arguments) {
  try {
    return ulf::test::Run(count > 1 ? arguments[1] : "", count > 2 ? std::atof(arguments[2]) : -1,
                          count > 3 ? static_cast<unsigned>(std::atoi(arguments[3])) : 1);
  } catch (const std::exception& error) {
    fmt::print("{}\n", error.what());
    return 1;
  }
}
