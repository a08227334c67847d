// Tests: coverage/operator/run_with_display.
//
// A capture in one thread and its display in the other: how each of them ends.
#include "coverage/operator/run_with_display.h"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"

namespace ulf::test::run_with_display_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(RunWithDisplay, GoesOnWithoutADisplayAndSaysSo) {
  CaptureFeed feed;
  CaptureRequests requests;
  const StagedCapture capture;
  bool captured = false;
  ::testing::internal::CaptureStderr();
  RunWithDisplay([]() -> std::unique_ptr<Surface> { throw Error("no window: the reason"); }, {}, feed,
                 requests,
                 [&] {
                   feed.Publish(capture.At(capture.CameraAt(0, 0)));
                   captured = true;
                 });
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_TRUE(captured);
  EXPECT_EQ(feed.Newest(), nullptr) << "pictures are kept for nobody";
  EXPECT_THAT(said, HasSubstr("the reason"));
  EXPECT_THAT(said, HasSubstr("without the operator display"));
  const auto asked = requests.Take();
  ASSERT_EQ(asked.size(), 1u) << "there is nobody who could begin";
  EXPECT_TRUE(std::get<SetRecording>(asked[0]).although_checks_fail);
}

std::unique_ptr<Surface> Small() { return std::make_unique<OffscreenSurface>(cv::Size(320, 240)); }

TEST(RunWithDisplay, ClosingTheWindowFinishesTheCapture) {
  CaptureFeed feed;
  CaptureRequests requests;
  bool finished = false, waited_for = false;
  const auto closes_at_once = [] {
    auto surface = std::make_unique<OffscreenSurface>(cv::Size(320, 240));
    surface->Push(CloseAsked{});
    return surface;
  };
  RunWithDisplay(closes_at_once, {}, feed, requests, [&] {
    for (int i = 0; i < 1000 && !finished; ++i) {
      for (const CaptureRequest& request : requests.Take())
        finished = finished || std::holds_alternative<FinishCapture>(request);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // closing a light field takes its time
    waited_for = true;
  });
  EXPECT_TRUE(finished);
  EXPECT_TRUE(waited_for);
}

TEST(RunWithDisplay, EndsTheDisplayWithTheCapture) {
  CaptureFeed feed;
  CaptureRequests requests;
  const StagedCapture capture;
  int published = 0;
  RunWithDisplay(Small, {}, feed, requests, [&] {
    for (; published < 10; ++published) {
      feed.Publish(capture.At(capture.CameraAt(published, 0)));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  EXPECT_EQ(published, 10);
  EXPECT_TRUE(requests.Take().empty());
}

// Until it is let go.
class StuckSurface : public OffscreenSurface {
 public:
  StuckSurface(std::atomic<int>& presented, const std::atomic<bool>& let_go, std::atomic<bool>& gave_up)
      : OffscreenSurface(cv::Size(320, 240)), presented_(presented), let_go_(let_go), gave_up_(gave_up) {}
  void Present() override {
    OffscreenSurface::Present();
    ++presented_;
    const auto since = Clock::now();
    while (!let_go_ && !gave_up_) {
      std::this_thread::sleep_for(1ms);
      gave_up_ = Clock::now() - since > 20s;
    }
  }

 private:
  std::atomic<int>& presented_;
  const std::atomic<bool>& let_go_;
  std::atomic<bool>& gave_up_;
};

TEST(RunWithDisplay, StuckDisplayDelaysNothing) {
  CaptureFeed feed;
  CaptureRequests requests;
  const StagedCapture capture;
  std::atomic<int> presented = 0;
  std::atomic<bool> let_go = false, gave_up = false;
  constexpr int kFrames = 50;
  RunWithDisplay([&] { return std::make_unique<StuckSurface>(presented, let_go, gave_up); }, {}, feed,
                 requests,
                 [&] {
                   const auto state = capture.At(capture.CameraAt(0, 0));
                   feed.Publish(state);
                   while (presented == 0) std::this_thread::sleep_for(1ms);
                   for (int frame = 0; frame < kFrames; ++frame)
                     feed.Publish(std::make_shared<CaptureState>(*state));
                   EXPECT_EQ(presented, 1) << "all this while one picture was on its way";
                   let_go = true;
                 });
  EXPECT_FALSE(gave_up);
  EXPECT_LT(presented, kFrames / 2) << "what nobody has seen in time is not shown late";
}

TEST(RunWithDisplay, RethrowsWhatTheCaptureThrows) {
  CaptureFeed feed;
  CaptureRequests requests;
  EXPECT_THROW(RunWithDisplay(Small, {}, feed, requests, [] { throw Error("the disk"); }), Error);
}

// While it is made, by a marker that does not exist, or with its first picture: before the capture has
// published a state.
TEST(RunWithDisplay, CaptureSurvivesABrokenDisplay) {
  class Breaking : public OffscreenSurface {
   public:
    Breaking() : OffscreenSurface(cv::Size(320, 240)) {}
    void Present() override { throw Error("the driver is gone"); }
  };
  struct Case {
    const char* marker;
    const char* said;
  };
  for (const Case& c : {Case{"", "the driver is gone"}, Case{"none such", "none such"}}) {
    CaptureFeed feed;
    CaptureRequests requests;
    DisplayOptions options;
    options.marker = c.marker;
    bool captured = false;
    ::testing::internal::CaptureStderr();
    RunWithDisplay([] { return std::make_unique<Breaking>(); }, options, feed, requests,
                   [&] {
                     std::this_thread::sleep_for(300ms);
                     captured = true;
                   });
    EXPECT_TRUE(captured);
    EXPECT_THAT(::testing::internal::GetCapturedStderr(),
                AllOf(HasSubstr(c.said), HasSubstr("the capture goes on without it")));
    const auto asked = requests.Take();
    ASSERT_EQ(asked.size(), 1u) << "there is nobody who could begin";
    EXPECT_TRUE(std::get<SetRecording>(asked[0]).on);
    EXPECT_TRUE(std::get<SetRecording>(asked[0]).although_checks_fail);
  }
}

std::shared_ptr<CaptureState> Grey() {
  auto state = std::make_shared<CaptureState>();
  state->camera = CameraModel::Pinhole(64, 48, 60);
  state->live.transfer = Transfer::kSrgb;
  state->live.pixels = cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(128));
  return state;
}

// Presses a key when it is told to.
class Obedient : public OffscreenSurface {
 public:
  explicit Obedient(std::atomic<bool>& press) : OffscreenSurface(cv::Size(320, 240)), press_(press) {}
  std::vector<InputEvent> TakeEvents(double patience_s) override {
    if (press_.exchange(false)) Push(Typed{U' '});
    return OffscreenSurface::TakeEvents(patience_s);
  }

 private:
  std::atomic<bool>& press_;
};

TEST(RunWithDisplay, CoveredCapIsShownUntilAKey) {
  CaptureFeed feed;
  CaptureRequests requests;
  std::atomic<bool> press = false, closed = false, pressed_after_closing = false;
  std::thread person([&] {
    while (!closed) std::this_thread::sleep_for(5ms);
    std::this_thread::sleep_for(300ms);
    pressed_after_closing = true;
    press = true;
  });
  const auto begun = Clock::now();
  RunWithDisplay([&] { return std::make_unique<Obedient>(press); }, {}, feed, requests,
                 [&] {
                   const auto state = Grey();
                   state->ended = StoppedBecause::kCovered;
                   feed.Publish(state);
                   closed = true;
                 });
  EXPECT_TRUE(pressed_after_closing) << "the window has not waited for the key";
  EXPECT_LT(Clock::now() - begun, 2500ms) << "it has waited for more than the key";
  EXPECT_TRUE(requests.Take().empty()) << "there is nobody left to ask";
  person.join();
}

TEST(RunWithDisplay, EndsWithoutAKeyPress) {
  CaptureFeed feed;
  CaptureRequests requests;
  for (const auto& [why, least, most] :
       {std::tuple{StoppedBecause::kCovered, 2900ms, 5000ms}, {StoppedBecause::kFrames, 0ms, 2500ms}}) {
    CaptureFeed feed_of_one;
    const auto begun = Clock::now();
    RunWithDisplay(Small, {}, feed_of_one, requests, [&, why = why] {
      const auto state = Grey();
      state->ended = why;
      feed_of_one.Publish(state);
    });
    EXPECT_GE(Clock::now() - begun, least) << Name(why);
    EXPECT_LT(Clock::now() - begun, most) << Name(why);
  }
}

// After some frames as if its display server had ended. What is touched then is remembered.
class Dying : public OffscreenSurface {
 public:
  Dying(std::string keys, std::atomic<bool>& dead, bool& given_back)
      : OffscreenSurface(cv::Size(320, 240)), keys_(std::move(keys)), dead_(dead), given_back_(given_back) {}
  ~Dying() override { given_back_ = true; }
  std::vector<InputEvent> TakeEvents(double patience_s) override {
    constexpr int kFramesOfLife = 10;
    dead_ = ++frames_ > kFramesOfLife;
    if (dead_) throw SurfaceGone("the display server has ended");
    if (frames_ == kFramesOfLife / 2)
      for (const char key : keys_) Push(Typed{static_cast<char32_t>(key)});
    return OffscreenSurface::TakeEvents(patience_s);
  }

 private:
  std::string keys_;
  std::atomic<bool>& dead_;
  bool& given_back_;
  int frames_ = 0;
};

TEST(RunWithDisplay, LosingTheSurfaceResumesRecording) {
  struct Case {
    const char* keys;
    std::optional<bool> last_asked;
    bool said;
  };
  for (const Case& c : {Case{"", {}, false}, Case{"s", true, false}, Case{" ", false, true}}) {
    CaptureFeed feed;
    CaptureRequests requests;
    std::atomic<bool> dead = false;
    bool given_back = false, captured = false;
    ::testing::internal::CaptureStderr();
    RunWithDisplay([&] { return std::make_unique<Dying>(c.keys, dead, given_back); }, {}, feed, requests,
                   [&] {
                     const auto patience = Clock::now() + 30s;
                     while (!dead && Clock::now() < patience) {
                       feed.Publish(Grey());
                       std::this_thread::sleep_for(10ms);
                     }
                     std::this_thread::sleep_for(200ms);  // it goes on
                     captured = true;
                   });
    std::optional<bool> last_asked;
    for (const CaptureRequest& request : requests.Take())
      if (const auto* asked = std::get_if<SetRecording>(&request)) last_asked = asked->on;
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_TRUE(captured);
    EXPECT_FALSE(given_back) << "it is touched to be given back";
    EXPECT_EQ(last_asked, c.last_asked) << "'" << c.keys << "'";
    EXPECT_THAT(said, HasSubstr("is gone (the display server has ended); the capture goes on without it"));
    if (c.said)
      EXPECT_THAT(said, HasSubstr("recording stays paused"));
    else
      EXPECT_THAT(said, Not(HasSubstr("paused")));
  }
}

}  // namespace
}  // namespace ulf::test::run_with_display_test
