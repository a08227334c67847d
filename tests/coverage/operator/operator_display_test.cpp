// Tests: coverage/operator/operator_display, coverage/operator/subject_tool.
//
// The operator display drawn without a window from staged states: pixels where meaning sits, and what keys
// ask of the capture.
#include "coverage/operator/operator_display.h"

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "coverage/bound/sphere_outline.h"
#include "tests/coverage/operator/display_stage.h"
#include "tests/support/floors.h"

namespace ulf::test::operator_display_test {
namespace {

using Eigen::Vector2d;

cv::Vec3b Pixel(const cv::Mat& picture, const Vector2d& at) {
  return picture.at<cv::Vec3b>(static_cast<int>(at.y()), static_cast<int>(at.x()));
}
bool IsRed(const cv::Vec3b& bgr) { return bgr[2] > 180 && bgr[0] < 90 && bgr[1] < 90; }
bool IsWhite(const cv::Vec3b& bgr) { return std::min({bgr[0], bgr[1], bgr[2]}) > 230; }

// Windows of every shape, and a screen of double density.
struct Screen {
  cv::Size size;
  double scale;
};
const Screen kScreens[] = {
    {{1280, 960}, 1}, {{1280, 720}, 1}, {{700, 1000}, 1}, {{2560, 1440}, 2}, {{500, 300}, 1}};

TEST(OperatorDisplay, RectangleIsWhiteOrRedWhereItIs) {
  for (const Screen& screen : kScreens) {
    Stage stage(screen.size, screen.scale);
    const SafetyRectangle rectangle = SafetyRectangle::Of(stage.capture.camera());
    // Half-way up the sides, where no panel is.
    for (const double x : {rectangle.low.x(), rectangle.high.x()}) {
      const Vector2d at = stage.OnScreen({x, 0.5 * stage.capture.camera().height + 20});
      EXPECT_TRUE(IsWhite(Pixel(stage.Show(stage.capture.At(stage.capture.CameraAt(0, 0))), at)))
          << screen.size << " at " << at.transpose();
      EXPECT_TRUE(IsRed(Pixel(stage.Show(stage.capture.At(stage.capture.CameraAt(0, 0, 1, {0.1, 0.6}))), at)))
          << screen.size << " at " << at.transpose();
    }
  }
}

TEST(OperatorDisplay, RedDotIsAtTheProjectedCamera) {
  for (const Screen& screen : kScreens) {
    Stage stage(screen.size, screen.scale);
    stage.Show(stage.capture.At(stage.capture.CameraAt(10, 5)));
    stage.Type('i');  // the list of what is in order hides half of a small window
    for (const Vector2d& aside : {Vector2d(0, 0), Vector2d(0.15, -0.05), Vector2d(-0.12, 0.08)}) {
      const Rigid3 pose = stage.capture.CameraAt(10, 5, 1, aside);
      const cv::Mat picture = stage.Show(stage.capture.At(pose));
      const Subject& subject = stage.capture.subject();
      const Eigen::Vector3d toward = (pose.OriginInSource() - subject.center_in_world).normalized();
      const Vector2d expected = stage.OnScreen(*stage.capture.camera().ImgFromCam(
          pose * Eigen::Vector3d(subject.center_in_world + subject.radius * toward)));
      // The middle of all red around there.
      Vector2d sum(0, 0);
      double count = 0;
      for (int y = -30; y <= 30; ++y)
        for (int x = -30; x <= 30; ++x) {
          const Vector2d at = expected + Vector2d(x, y);
          if (!IsRed(Pixel(picture, at))) continue;
          sum += Vector2d(std::floor(at.x()) + 0.5, std::floor(at.y()) + 0.5);
          ++count;
        }
      ASSERT_GT(count, 20) << screen.size;
      EXPECT_LT((sum / count - expected).norm(), 1) << screen.size << ", aside " << aside.transpose();
    }
  }
}

TEST(OperatorDisplay, ShowsMessagesForAWhile) {
  constexpr int kFps = 5;  // each picture costs time, and ten seconds are waited for
  Stage stage({1280, 960}, 1, {}, AtFps(kFps));
  const auto quiet = stage.capture.At(stage.capture.CameraAt(0, 0));
  const cv::Rect place(440, 820, 400, 60);
  const cv::Mat before = stage.Show(quiet)(place).clone();
  auto speaking = std::make_shared<CaptureState>(*quiet);
  speaking->said = {"the subject would be behind the camera"};
  speaking->times_said = 1;
  EXPECT_GT(cv::norm(stage.Show(speaking)(place), before, cv::NORM_L1) / static_cast<double>(place.area()),
            5);
  // What is said next stands below it, and does not take its place.
  auto more = std::make_shared<CaptureState>(*speaking);
  more->said.push_back("recording paused, tracking goes on");
  more->times_said = 2;
  const cv::Rect above(500, 824, 280, 14);
  const cv::Mat nothing = stage.Show(speaking)(above).clone();
  const cv::Mat both = stage.Show(more)(above);
  EXPECT_GT(cv::norm(both, nothing, cv::NORM_L1) / static_cast<double>(above.area()), 5);
  for (int i = 0; i < 11 * kFps; ++i) stage.display.Step();
  EXPECT_LT(cv::norm(stage.Show(more)(place), before, cv::NORM_L1) / static_cast<double>(place.area()), 1);
}

// Whatever the rate at which pictures come: ten seconds for words, 0.4 s for the flash.
TEST(OperatorDisplay, TimesCountSecondsNotPictures) {
  for (const int fps : {4, 10}) {
    Stage stage({960, 720}, 1, {}, AtFps(fps));
    const auto held = stage.capture.At(stage.capture.CameraAt(0, 0));
    const auto left = stage.capture.At(stage.capture.CameraAt(0, 0, 1, {0.1, 0.6}));
    const auto flashes = [&] { return IsRed(Pixel(stage.surface.Read(), {2, 360})); };
    const auto wait = [&](double seconds) {
      for (int i = 0; i < std::lround(seconds * fps); ++i) stage.display.Step();
    };
    stage.Show(held);
    stage.Show(left);
    wait(0.3);
    EXPECT_TRUE(flashes()) << fps << " a second";
    wait(0.2);
    EXPECT_FALSE(flashes()) << fps << " a second";

    const cv::Rect words(280, 580, 400, 60);
    const cv::Mat before = stage.surface.Read()(words).clone();
    const auto speaks = [&] {
      return cv::norm(stage.surface.Read()(words), before, cv::NORM_L1) / words.area() > 2;
    };
    auto speaking = std::make_shared<CaptureState>(*left);
    speaking->said = {"the subject would be behind the camera"};
    speaking->times_said = 1;
    EXPECT_FALSE(speaks());
    stage.Show(speaking);
    wait(9.8);
    EXPECT_TRUE(speaks()) << fps << " a second";
    wait(0.4);
    EXPECT_FALSE(speaks()) << fps << " a second";
  }
}

// Where the first view comes at once, what is not in order is still read.
TEST(OperatorDisplay, ShowsFailedChecksDespiteAView) {
  for (const bool in_order : {true, false}) {
    Stage stage;
    auto state = stage.capture.Record(stage.capture.CameraAt(0, 0));
    auto none = std::make_shared<CaptureState>(*state);
    none->preflight.clear();
    const cv::Rect place(12, 60, 300, 60);
    const cv::Mat without = stage.Show(none)(place).clone();
    auto checked = std::make_shared<CaptureState>(*state);
    ASSERT_FALSE(checked->preflight.empty());
    if (!in_order) checked->preflight[0].in_order = false;
    const double shown =
        cv::norm(stage.Show(checked)(place), without, cv::NORM_L1) / static_cast<double>(place.area());
    if (in_order)
      EXPECT_LT(shown, 1);
    else
      EXPECT_GT(shown, 20);
  }
}

// The picture's pixel with paint over it, as far as one wire line or rim may be off.
void ExpectPainted(const cv::Mat& picture, const Vector2d& at, const Rgba& color, const std::string& what) {
  // The most frequent colour around: lines are thin.
  std::vector<cv::Vec3b> around;
  for (int y = -7; y <= 7; ++y)
    for (int x = -7; x <= 7; ++x) around.push_back(Pixel(picture, at + Vector2d(x, y)));
  cv::Vec3d median;
  for (int c = 0; c < 3; ++c) {
    std::nth_element(around.begin(), around.begin() + static_cast<long>(around.size() / 2), around.end(),
                     [c](const cv::Vec3b& a, const cv::Vec3b& b) { return a[c] < b[c]; });
    median[c] = around[around.size() / 2][c];
  }
  const cv::Vec3d paint(color.b, color.g, color.r);
  const double dark = StagedCapture::kGrey * (1 - 110 / 255.0) + 27 * 110 / 255.0;  // the uncovered sphere
  const cv::Vec3d expected = 0.72 * paint + (1 - 0.72) * cv::Vec3d::all(dark);
  EXPECT_LT(cv::norm(median - expected), 12) << what << ": " << median << " in place of " << expected;
}

TEST(OperatorDisplay, OnlyDiscsAreColouredByDistance) {
  Stage stage({1280, 960}, 1, {.threshold_px = 30});  // discs larger than what is drawn on them
  stage.capture.Record(stage.capture.CameraAt(6, 4, 1));
  const Subject& subject = stage.capture.subject();
  const auto first = stage.capture.At(stage.capture.CameraAt(0, 0));
  const DistanceColors limits(*first->coverage, 1, Palette::Standard());
  const Eigen::Vector3d toward =
      (first->coverage->views()[0].center_in_world - subject.center_in_world).normalized();
  for (const double present :
       {1.0, limits.farthest_recorded(), limits.nearest_recorded(), std::sqrt(limits.farthest_recorded())}) {
    const Rigid3 pose = stage.capture.CameraAt(0, 0, present);
    const cv::Mat picture = stage.Show(stage.capture.At(pose));
    // Beside the view's own dot.
    const Vector2d at = stage.OnScreen(*stage.capture.camera().ImgFromCam(
                            pose * Eigen::Vector3d(subject.center_in_world + subject.radius * toward))) +
                        Vector2d(9, 9);
    ExpectPainted(picture, at,
                  Palette::Standard().OfNearer(
                      DistanceColors(*first->coverage, present, Palette::Standard()).Nearer(1.0)),
                  fmt::format("at {}", present));
  }
  // Far from the only view the sphere is dark, not coloured.
  const cv::Mat picture = stage.Show(first);
  const Eigen::Vector3d bare =
      (stage.capture.CameraAt(-23, -15).OriginInSource() - subject.center_in_world).normalized();
  const cv::Vec3b pixel =
      Pixel(picture,
            stage.OnScreen(*stage.capture.camera().ImgFromCam(
                *first->cam_from_world * Eigen::Vector3d(subject.center_in_world + subject.radius * bare))));
  EXPECT_LT(*std::max_element(pixel.val, pixel.val + 3) - *std::min_element(pixel.val, pixel.val + 3), 12);
}

TEST(OperatorDisplay, TheSecondPaletteIsUsedOnRequest) {
  Stage stage({1280, 960}, 1, {.threshold_px = 30});  // discs larger than what is drawn on them
  stage.capture.Record(stage.capture.CameraAt(6, 4, 1));
  const auto state = stage.capture.At(stage.capture.CameraAt(0, 0));
  const Subject& subject = stage.capture.subject();
  const Eigen::Vector3d toward =
      (state->coverage->views()[0].center_in_world - subject.center_in_world).normalized();
  const Vector2d at =
      stage.OnScreen(*stage.capture.camera().ImgFromCam(
          *state->cam_from_world * Eigen::Vector3d(subject.center_in_world + subject.radius * toward))) +
      Vector2d(9, 9);
  ExpectPainted(stage.Show(state), at, Palette::Standard().same, "standard");
  stage.Type('p');
  ExpectPainted(stage.Show(state), at, Palette::ForColourBlind().same, "for the colour-blind");
}

TEST(OperatorDisplay, FrameFlashesWhenTheSubjectLeaves) {
  for (const Screen& screen : {kScreens[0], kScreens[4]}) {
    Stage stage(screen.size, screen.scale);
    const auto held = stage.capture.At(stage.capture.CameraAt(0, 0));
    const auto left = stage.capture.At(stage.capture.CameraAt(0, 0, 1, {0.1, 0.6}));
    const auto frame_is_red = [&](const cv::Mat& picture) {
      const double middle = 0.5 * screen.size.height;
      return IsRed(Pixel(picture, {2, middle})) && IsRed(Pixel(picture, {screen.size.width - 3.0, middle})) &&
             IsRed(Pixel(picture, {0.5 * screen.size.width, screen.size.height - 3.0}));
    };
    EXPECT_FALSE(frame_is_red(stage.Show(held))) << screen.size;
    EXPECT_TRUE(frame_is_red(stage.Show(left))) << screen.size;
    for (int i = 0; i < 15; ++i) stage.display.Step();
    EXPECT_FALSE(frame_is_red(stage.Show(std::make_shared<CaptureState>(*left)))) << "it only flashes";
    stage.Show(held);
    EXPECT_TRUE(frame_is_red(stage.Show(std::make_shared<CaptureState>(*left)))) << "each time";
  }
}

TEST(OperatorDisplay, TheKeysAreShownAndGoAgain) {
  Stage stage;
  const auto state = stage.capture.At(stage.capture.CameraAt(0, 0));
  const cv::Rect middle(480, 200, 320, 500);
  const cv::Mat without = stage.Show(state)(middle).clone();
  const auto differs = [&](const cv::Mat& picture) {
    return cv::norm(picture(middle), without, cv::NORM_L1) / static_cast<double>(middle.area()) > 20;
  };
  const auto show = [&] { return stage.Show(std::make_shared<CaptureState>(*state)); };
  stage.Type('?');
  EXPECT_TRUE(differs(show()));
  stage.Press(Key::kEscape);
  EXPECT_FALSE(differs(show()));
  stage.Press(Key::kF1);
  EXPECT_TRUE(differs(show()));
  stage.Press(Key::kF1);
  EXPECT_FALSE(differs(show()));
}

TEST(OperatorDisplay, LegendShowsThePaletteAndHides) {
  Stage stage;
  stage.capture.Record(stage.capture.CameraAt(0, 0));
  const auto state = stage.capture.At(stage.capture.CameraAt(0, 0));
  const auto color_at = [&](const cv::Mat& picture, const Vector2d& at) {
    return cv::Vec3d(Pixel(picture, at));
  };
  const auto bgr = [](const Rgba& color) { return cv::Vec3d(color.b, color.g, color.r); };
  const auto show = [&] { return stage.Show(std::make_shared<CaptureState>(*state)); };
  // The bar is under the first line of a panel of one mark, in the lower left corner.
  const double y = 960 - 12 - 100 + 10 + 20 + 8;
  for (const bool colour_blind : {false, true}) {
    const Palette& palette = colour_blind ? Palette::ForColourBlind() : Palette::Standard();
    const cv::Mat picture = show();
    EXPECT_LT(cv::norm(color_at(picture, {24, y}) - bgr(palette.nearer)), 25) << picture.size();
    EXPECT_LT(cv::norm(color_at(picture, {137, y}) - bgr(palette.same)), 25);
    EXPECT_LT(cv::norm(color_at(picture, {250, y}) - bgr(palette.farther)), 25);
    stage.Type('p');
  }
  stage.Type('p');
  stage.Type('p');
  stage.Type('l');
  EXPECT_LT(cv::norm(color_at(show(), {24, y}) - cv::Vec3d::all(StagedCapture::kGrey)), 3) << "gone";
}

TEST(OperatorDisplay, NothingIsDrawnOnTheSphereWhenLost) {
  Stage stage({1280, 960});
  stage.capture.RecordRows(-10, 10, -10, 10, 5);
  stage.Show(stage.capture.At(stage.capture.CameraAt(0, 0)));
  const cv::Mat picture = stage.Show(stage.capture.Lost());
  // The live picture is even: below the word and above the advice nothing but it may be seen.
  const cv::Rect below_the_word(200, 560, 880, 220);
  const cv::Mat difference = cv::abs(picture(below_the_word) - cv::Scalar::all(StagedCapture::kGrey));
  double most = 0;
  cv::minMaxLoc(difference.reshape(1), nullptr, &most);
  EXPECT_LE(most, 2);
  // The word itself is there.
  int red = 0;
  for (int y = 380; y < 480; ++y)
    for (int x = 540; x < 740; ++x)
      red += picture.at<cv::Vec3b>(y, x)[2] > 200 && picture.at<cv::Vec3b>(y, x)[1] < 120;
  EXPECT_GT(red, 200);
}

TEST(OperatorDisplay, LivePictureIsShownAsItIs) {
  StageOptions options;
  options.rendered = true;
  Stage stage({640, 480}, 1, options);
  stage.Type('l');
  auto state = stage.capture.Lost();
  const cv::Mat picture = stage.Show(state);
  const cv::Rect free(60, 300, 500, 60);
  EXPECT_LT(cv::norm(picture(free), state->live.pixels(free), cv::NORM_INF), 2);
}

TEST(OperatorDisplay, KeysAskTheCapture) {
  Stage stage;
  stage.Show(stage.capture.At(stage.capture.CameraAt(0, 0)));
  stage.Type(' ');
  const auto paused = stage.Asked<SetRecording>();
  ASSERT_EQ(paused.size(), 1u);
  EXPECT_FALSE(paused[0].on);
  stage.Press(Key::kF11);
  EXPECT_EQ(stage.Asked<FinishCapture>().size(), 0u);
  EXPECT_TRUE(stage.surface.full_screen());
  stage.Type('q');
  EXPECT_EQ(stage.Asked<FinishCapture>().size(), 1u);
  EXPECT_FALSE(stage.display.Step());
}

TEST(OperatorDisplay, ACaptureBeginsByKey) {
  Stage stage;
  auto waiting = stage.capture.At(stage.capture.CameraAt(0, 0));
  waiting->waits_to_begin = true;
  waiting->recording = false;
  stage.Show(waiting);
  const auto begins = [&](bool although_checks_fail) {
    const auto asked = stage.Asked<SetRecording>();
    ASSERT_EQ(asked.size(), 1u);
    EXPECT_TRUE(asked[0].on);
    EXPECT_EQ(asked[0].although_checks_fail, although_checks_fail);
    stage.Show(std::make_shared<CaptureState>(*waiting));
  };
  stage.Press(Key::kEnter);
  begins(false);
  stage.Press(Key::kEnter, true);
  begins(true);
  // A display that goes away before: nobody can begin any more.
  EXPECT_TRUE(stage.display.Detach());
  const auto asked = stage.requests.Take();
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_TRUE(std::get<SetRecording>(asked[0]).although_checks_fail);
  auto begun = std::make_shared<CaptureState>(*waiting);
  begun->waits_to_begin = false;
  begun->recording = true;
  stage.Show(begun);
  stage.Press(Key::kEnter);
  EXPECT_TRUE(stage.Asked<SetRecording>().empty()) << "Enter pauses nothing";
  EXPECT_TRUE(stage.display.Detach());
  EXPECT_TRUE(stage.requests.Take().empty()) << "it has begun";
}

TEST(OperatorDisplay, DetachingEarlyStartsTheRecording) {
  Stage stage;
  EXPECT_TRUE(stage.display.Detach());
  const auto asked = stage.requests.Take();
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_TRUE(std::get<SetRecording>(asked[0]).on);
  EXPECT_TRUE(std::get<SetRecording>(asked[0]).although_checks_fail);
}

TEST(OperatorDisplay, TheProposedSphereIsTakenByKey) {
  Stage stage;
  auto state = stage.capture.At(stage.capture.CameraAt(0, 0));
  stage.Show(state);
  stage.Type('g');
  EXPECT_TRUE(stage.Asked<PlaceSphere>().empty()) << "none is proposed";
  state = std::make_shared<CaptureState>(*state);
  state->proposed_subject = Subject{{0.01, 0.02, 0.03}, 0.1};
  stage.Show(state);
  stage.Type('g');
  const auto placed = stage.Asked<PlaceSphere>();
  ASSERT_EQ(placed.size(), 1u);
  EXPECT_EQ(placed[0].subject, *state->proposed_subject);
}

TEST(OperatorDisplay, IgnoresKeysBeforeTheFirstFrame) {
  Stage stage;
  for (const char32_t key : {U' ', U's', U'r', U'c', U'w', U'?', U'p'}) stage.Type(key);
  stage.Press(Key::kUp);
  stage.surface.Push(WheelTurned{1});
  stage.surface.Push(MouseMoved{{10, 10}});
  EXPECT_TRUE(stage.display.Step());
  EXPECT_TRUE(stage.requests.Take().empty());
  stage.surface.Push(CloseAsked{});
  EXPECT_FALSE(stage.display.Step());
  EXPECT_EQ(stage.requests.Take().size(), 1u);
}

TEST(OperatorDisplay, AWindowWithoutAreaDrawsNothing) {
  class Iconified : public OffscreenSurface {
   public:
    Iconified() : OffscreenSurface({64, 48}) {}
    cv::Size Size() const override { return iconified ? cv::Size() : OffscreenSurface::Size(); }
    void Present() override { ++presented; }
    bool iconified = true;
    int presented = 0;
  } surface;
  const StagedCapture capture;
  CaptureFeed feed;
  CaptureRequests requests;
  OperatorDisplay display(surface, feed, requests);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(display.Step());
    feed.Publish(capture.At(capture.CameraAt(i, 0)));
  }
  EXPECT_EQ(surface.presented, 0);
  surface.iconified = false;
  EXPECT_TRUE(display.Step());
  EXPECT_EQ(surface.presented, 1);
}

// ---- the subject tool

TEST(SubjectTool, RefinesTheSphereByKeysWheelAndDrag) {
  Stage stage;
  const auto state = stage.capture.At(stage.capture.CameraAt(0, 0, 1));
  const Subject before = *state->subject;
  stage.Show(state);
  stage.Type('s');
  const auto paused = stage.Asked<SetRecording>();
  ASSERT_EQ(paused.size(), 1u);
  EXPECT_FALSE(paused[0].on);
  for (int i = 0; i < 5; ++i) stage.Press(Key::kUp);     // 1.02 each: farther
  stage.surface.Push(WheelTurned{-2, false});            // and two back
  for (int i = 0; i < 4; ++i) stage.Press(Key::kRight);  // larger
  stage.surface.Push(WheelTurned{-1, true});             // and one back
  EXPECT_TRUE(stage.Asked<PlaceSphere>().empty()) << "a draft is nobody's business";
  stage.Press(Key::kEnter);
  stage.display.Step();
  const auto requests = stage.requests.Take();
  ASSERT_EQ(requests.size(), 2u);
  const Subject after = std::get<PlaceSphere>(requests[0]).subject;
  EXPECT_TRUE(std::get<SetRecording>(requests[1]).on);
  const Eigen::Vector3d camera = state->cam_from_world->OriginInSource();
  EXPECT_NEAR((after.center_in_world - camera).norm(), std::pow(1.02, 3), 1e-9);
  EXPECT_NEAR(after.radius, before.radius * std::pow(1.02, 3 + 3), 1e-9);
  EXPECT_LT((after.center_in_world - camera)
                .normalized()
                .cross((before.center_in_world - camera).normalized())
                .norm(),
            1e-9);
}

TEST(SubjectTool, DraggingMovesTheSphereWithTheMouse) {
  Stage stage;
  const auto state = stage.capture.At(stage.capture.CameraAt(0, 0, 1));
  stage.Show(state);
  stage.Type('s');
  stage.surface.Push(MouseMoved{{600, 500}});
  stage.surface.Push(MouseButton{0, true});
  stage.surface.Push(MouseMoved{{640, 480}});
  stage.surface.Push(MouseButton{0, false});
  stage.surface.Push(MouseMoved{{900, 900}});
  stage.Press(Key::kEnter);
  const auto placed = stage.Asked<PlaceSphere>();
  ASSERT_EQ(placed.size(), 1u);
  const auto at = [&](const Subject& subject) {
    return stage.OnScreen(*state->camera.ImgFromCam(*state->cam_from_world * subject.center_in_world));
  };
  EXPECT_LT((at(placed[0].subject) - at(*state->subject) - Vector2d(40, -20)).norm(), 1.5);
}

TEST(SubjectTool, LeavingItChangesNothing) {
  Stage stage;
  stage.Show(stage.capture.At(stage.capture.CameraAt(0, 0)));
  stage.Type('s');
  stage.Press(Key::kUp);
  stage.Press(Key::kEscape);
  stage.display.Step();
  for (const CaptureRequest& request : stage.requests.Take())
    EXPECT_TRUE(std::holds_alternative<SetRecording>(request));
}

// A corrected map moves the capture's subject: what the person has done so far moves along.
TEST(SubjectTool, DraftFollowsTheCorrectedMap) {
  Stage stage;
  const auto state = stage.capture.At(stage.capture.CameraAt(0, 0));
  stage.Show(state);
  stage.Type('s');
  stage.Press(Key::kRight);  // larger
  stage.Show(std::make_shared<CaptureState>(*state));
  auto corrected = std::make_shared<CaptureState>(*state);
  const Eigen::Vector3d moved(0.02, 0, 0.01);
  corrected->subject->center_in_world += moved;
  stage.Show(corrected);
  stage.Press(Key::kEnter);
  const auto placed = stage.Asked<PlaceSphere>();
  ASSERT_EQ(placed.size(), 1u);
  EXPECT_LT((placed[0].subject.center_in_world - state->subject->center_in_world - moved).norm(), 1e-9);
  EXPECT_NEAR(placed[0].subject.radius, 1.02 * state->subject->radius, 1e-9);
}

TEST(SubjectTool, LeavingKeepsASubjectFoundMeanwhile) {
  Stage stage;
  const auto state = stage.capture.At(stage.capture.CameraAt(0, 0));
  stage.Show(state);
  for (const bool answered : {false, true}) {
    stage.Type('s');
    stage.Type('c');
    EXPECT_EQ(stage.Asked<FindSubject>().size(), 1u);
    if (answered) {
      auto found = std::make_shared<CaptureState>(*state);
      found->subject->radius *= 1.2;
      stage.Show(found);
    }
    stage.Press(Key::kEscape);
    const auto placed = stage.Asked<PlaceSphere>();
    ASSERT_EQ(placed.size(), 1u) << answered;
    EXPECT_EQ(placed[0].subject, *state->subject);
    stage.Show(std::make_shared<CaptureState>(*state));
  }
}

TEST(SubjectTool, AsksForASubjectAndTakesTheFoundOne) {
  Stage stage;
  auto bare = stage.capture.At(stage.capture.CameraAt(0, 0));
  bare->subject.reset();
  bare->coverage.reset();
  bare->recording = false;
  stage.Show(bare);
  stage.Type('s');
  EXPECT_EQ(stage.Asked<FindSubject>().size(), 1u);
  stage.Show(stage.capture.At(stage.capture.CameraAt(0, 0)));
  stage.Press(Key::kUp);
  stage.Press(Key::kEnter);
  EXPECT_EQ(stage.Asked<PlaceSphere>().size(), 1u);
}

}  // namespace
}  // namespace ulf::test::operator_display_test
