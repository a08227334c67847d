// Tests: coverage/session/watch/mistake_watch, coverage/session/capture_session,
// commands/capture/capture_report.
//
// The gallery of docs/capture.md#mistakes through the whole program: each mistake in captures of different
// scenes, seeds and motions, ten good captures, and recordings by others. Prints how many were noticed, after
// how many seconds, and how many false alarms there were; what is asked for is all and none.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <vector>

#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::mistakes_long_test {
namespace {

using nlohmann::json;
using ::testing::Key;

struct SimulatedCapture {
  const char* scene;
  const char* motion;
  int seed;
};
// Nothing was settled on these seeds.
constexpr std::array<SimulatedCapture, 10> kGood{{{"studio", "", 201},
                                                  {"easel", "&speed_deg_s=20", 202},
                                                  {"wall", "", 203},
                                                  {"gloss", "&row_deg=4", 204},
                                                  {"glass", "&look_away=0", 205},
                                                  {"plant", "&dolly=1.3", 206},
                                                  {"room", "", 207},
                                                  {"picture", "&speed_deg_s=8", 208},
                                                  {"branch", "&sways_s=0", 209},
                                                  {"studio", "&fps=30&exposure_us=8000&gain_db=3", 210}}};
constexpr std::array<SimulatedCapture, 4> kMistaken{{{"studio", "", 221},
                                                     {"easel", "&speed_deg_s=20", 222},
                                                     {"plant", "&dolly=1.3", 223},
                                                     {"room", "&dolly=2", 224}}};
// Rooms whose pictures differ in brightness, so that the exposure moves by more than an eighth within two
// seconds; in the others it moves by 4 to 6 % all in all, which nobody sees.
constexpr std::array<SimulatedCapture, 4> kUnevenlyLit{{{"room", "&dolly=2", 224},
                                                        {"room", "&dolly=2", 225},
                                                        {"room", "&dolly=2&speed_deg_s=20", 226},
                                                        {"room", "&dolly=1.6", 227}}};

// The mistakes that a capture's summary has: names, and the second in which each was said.
std::map<std::string, double> NoticedBy(const std::string& arguments) {
  const ScratchFolder scratch;
  const CommandResult run =
      RunUlf("capture " + arguments + " --headless --json --no-geometry -o " + (scratch / "lf").string());
  EXPECT_LE(run.exit_code, 1) << run.errors;  // 1: nothing was recorded
  std::map<std::string, double> noticed;
  if (run.output.empty()) {
    ADD_FAILURE() << arguments << ": " << run.errors;
    return noticed;
  }
  const json report = JsonFromText(run.output);
  for (const json& mistake : report["mistakes"]) {
    noticed[mistake["name"]] = mistake["first_s"];
    printf("  %s: %.1f s: %s\n", arguments.c_str(), mistake["first_s"].get<double>(),
           mistake["finding"].get<std::string>().c_str());
    std::fflush(stdout);
  }
  return noticed;
}

std::string Uri(const SimulatedCapture& capture, const std::string& more, int seconds = 25) {
  return fmt::format("'sim:{}?seed={}{}{}' --max-seconds {}", capture.scene, capture.seed, capture.motion,
                     more, seconds);
}

// How many of the captures name exactly this mistake, when, and how many name others.
void NoticesInAll(const std::string& more, const std::string& name, const std::set<std::string>& also = {},
                  std::span<const SimulatedCapture> captures = kMistaken, int capture_s = 25) {
  int others = 0;
  std::vector<double> seconds;
  for (const SimulatedCapture& capture : captures) {
    std::map<std::string, double> noticed = NoticedBy(Uri(capture, more, capture_s));
    const bool is_noticed = noticed.contains(name);
    if (is_noticed) seconds.push_back(noticed[name]);
    noticed.erase(name);
    for (const std::string& known : also) noticed.erase(known);
    others += !noticed.empty();
    EXPECT_TRUE(is_noticed) << capture.scene << " " << capture.seed << more;
    EXPECT_THAT(noticed, ::testing::IsEmpty()) << capture.scene << " " << capture.seed << more;
  }
  printf(
      "%s (%s): noticed in %zu of %zu captures, after %.1f s (median; %.1f s at most), other mistakes in "
      "%d\n",
      name.c_str(), more.c_str(), seconds.size(), captures.size(), seconds.empty() ? 0 : Median(seconds),
      seconds.empty() ? 0 : *std::ranges::max_element(seconds), others);
}

TEST(MistakesLong, TenGoodCapturesHaveNone) {
  int alarms = 0;
  constexpr int kSeconds = 75;  // looks away and rests among them
  for (const SimulatedCapture& capture : kGood) {
    const auto noticed = NoticedBy(Uri(capture, "", kSeconds));
    alarms += !noticed.empty();
    EXPECT_THAT(noticed, ::testing::IsEmpty()) << capture.scene << " " << capture.seed;
  }
  printf("false alarms: %d of %zu good captures\n", alarms, kGood.size());
}

// The camera stands before a turntable, and other exposures are taken on purpose.
TEST(MistakesLong, ATurntableAndExposureBracketsAreNone) {
  EXPECT_THAT(
      NoticedBy("'sim:turntable?seed=211' --turntable charuco:5x5:54:40:DICT_4X4_50 --max-seconds 25"),
      ::testing::IsEmpty());
  EXPECT_THAT(NoticedBy("'sim:lightbox?seed=212' --bracket 3x2EV --max-seconds 25"), ::testing::IsEmpty());
}

TEST(MistakesLong, OutOfFocusIsNoticed) { NoticesInAll("&fault=defocus=8", "out of focus"); }
TEST(MistakesLong, AutoExposureThatIsToldIsNoticed) {
  NoticesInAll("&fault=auto_exposure=told", "auto exposure");
}
TEST(MistakesLong, AutoExposureThatIsNotToldIsNoticed) {
  NoticesInAll("&fault=auto_exposure=untold", "auto exposure", {}, kUnevenlyLit);
}
TEST(MistakesLong, HuntingAutoFocusIsNoticed) { NoticesInAll("&fault=hunting=5:1.6", "auto focus hunts"); }
TEST(MistakesLong, RollingShutterIsNoticed) { NoticesInAll("&readout_ms=25", "rolling shutter"); }
TEST(MistakesLong, FlickerOf100HertzIsNoticed) { NoticesInAll("&fault=flicker=100:0.4", "flickering lamps"); }
TEST(MistakesLong, FlickerOf50HertzIsNoticed) { NoticesInAll("&fault=flicker=50:0.2", "flickering lamps"); }
TEST(MistakesLong, FlickerInBandsIsNoticed) {
  NoticesInAll("&readout_ms=20&fault=flicker=100:0.4", "flickering lamps", {"rolling shutter"});
}
TEST(MistakesLong, UnsteadyLightIsNoticed) { NoticesInAll("&fault=drift=12", "unsteady light"); }
// In a large room the scene takes long to move on beneath a place of the picture, ten times.
TEST(MistakesLong, DustOnTheLensIsNoticed) {
  constexpr int kSeconds = 45;
  NoticesInAll("&fault=dust=6", "dust on the lens", {}, kMistaken, kSeconds);
}
TEST(MistakesLong, AnotherLensIsNoticed) { NoticesInAll("&fault=lens=0.85", "wrong lens"); }

// By others. The kitchen was taken with automatic exposure and under a rolling shutter: to say so is right.
// The scan's exposure is automatic, too, but changes so little at once that nothing need be said of it.
TEST(MistakesLong, RecordingsByOthersHaveWhatTheyHave) {
  ULF_NEED_TEST_DATA(kitchen, "handheld_kitchen");
  EXPECT_THAT(NoticedBy("'replay:" + kitchen.string() + "?glob=*.color.jpg' --no-subject --calibration " +
                        (kitchen / "intrinsics.txt").string()),
              ::testing::ElementsAre(Key("auto exposure"), Key("rolling shutter")));
  ULF_NEED_TEST_DATA(scan, "scan_synthetic");
  EXPECT_THAT(NoticedBy("replay:" + scan.string() + " --no-subject --calibration " +
                        (scan / "intrinsics.txt").string()),
              ::testing::AnyOf(::testing::IsEmpty(), ::testing::ElementsAre(Key("auto exposure"))));
}

}  // namespace
}  // namespace ulf::test::mistakes_long_test
