// The operator display drawn without a window from staged states: pixels where meaning sits, and what keys
// ask of the capture.
#include "coverage/operator/operator_display.h"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "acquisition/error.h"
#include "coverage/operator/run_with_display.h"
#include "coverage/sphere_outline.h"
#include "tests/support/staged_capture.h"

namespace ulf::test {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;

struct Stage {
  explicit Stage(cv::Size size = {1280, 960}, double scale = 1, const StageOptions& options = {})
      : capture(options), surface(size, scale), display(surface, feed, requests) {}
  cv::Mat Show(std::shared_ptr<const CaptureState> state) {
    feed.Publish(std::move(state));
    EXPECT_TRUE(display.Step());
    return surface.Read();
  }
  void Press(Key key, bool shift = false) { surface.Push(KeyPressed{key, shift}); }
  void Type(char32_t character) { surface.Push(Typed{character}); }
  template <typename Request>
  std::vector<Request> Asked() {
    display.Step();
    std::vector<Request> found;
    for (const CaptureRequest& request : requests.Take())
      if (const auto* kind = std::get_if<Request>(&request)) found.push_back(*kind);
    return found;
  }
  Vector2d OnScreen(const Vector2d& img) const {
    return Placement::Letterboxed({capture.camera().width, capture.camera().height}, surface.Size())
        .ScreenFromImg(img);
  }

  StagedCapture capture;
  OffscreenSurface surface;
  CaptureFeed feed;
  CaptureRequests requests;
  OperatorDisplay display;
};

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

TEST(OperatorDisplay, RedDotIsWithinAPixelOfTheProjectedCamera) {
  for (const Screen& screen : kScreens)
    for (const Vector2d& aside : {Vector2d(0, 0), Vector2d(0.15, -0.05), Vector2d(-0.12, 0.08)}) {
      Stage stage(screen.size, screen.scale);
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

TEST(OperatorDisplay, WhatTheCaptureSaysIsShownForAWhile) {
  Stage stage;
  const auto quiet = stage.capture.At(stage.capture.CameraAt(0, 0));
  const cv::Rect place(440, 820, 400, 60);
  const cv::Mat before = stage.Show(quiet)(place).clone();
  auto speaking = std::make_shared<CaptureState>(*quiet);
  speaking->said = "the subject would be behind the camera";
  EXPECT_GT(cv::norm(stage.Show(speaking)(place), before, cv::NORM_L1) / static_cast<double>(place.area()),
            5);
  for (int i = 0; i < 310; ++i) stage.display.Step();
  EXPECT_LT(cv::norm(stage.Show(speaking)(place), before, cv::NORM_L1) / static_cast<double>(place.area()),
            1);
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

TEST(OperatorDisplay, DiscsAreColouredByDistanceAndNothingElseIs) {
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
    ExpectPainted(picture, at, DistanceColors(*first->coverage, present, Palette::Standard()).OfDistance(1),
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
  stage.Press(Key::kBackspace);
  EXPECT_EQ(stage.Asked<TakeBackLast>().size(), 1u);
  stage.Press(Key::kF11);
  EXPECT_EQ(stage.Asked<FinishCapture>().size(), 0u);
  EXPECT_TRUE(stage.surface.full_screen());
  stage.Type('q');
  EXPECT_EQ(stage.Asked<FinishCapture>().size(), 1u);
  EXPECT_FALSE(stage.display.Step());
}

TEST(OperatorDisplay, BeforeTheFirstFrameKeysDoNothingAndClosingWorks) {
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
  Stage stage;
  stage.surface.Resize({1, 1}, 1);
  EXPECT_TRUE(stage.display.Step());
  stage.Show(stage.capture.At(stage.capture.CameraAt(0, 0)));
}

// ---- the subject tool

TEST(SubjectTool, RefinesDistanceAndRadiusByKeysWheelAndDragAndAsksOnce) {
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
  EXPECT_TRUE(stage.Asked<PlaceSubject>().empty()) << "a draft is nobody's business";
  stage.Press(Key::kEnter);
  stage.display.Step();
  const auto requests = stage.requests.Take();
  ASSERT_EQ(requests.size(), 2u);
  const Subject after = std::get<PlaceSubject>(requests[0]).subject;
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
  const auto placed = stage.Asked<PlaceSubject>();
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

TEST(SubjectTool, WithoutASubjectAsksForOneAndTakesWhatIsFound) {
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
  EXPECT_EQ(stage.Asked<PlaceSubject>().size(), 1u);
}

double Sharpness(const cv::Mat& picture, const cv::Rect& where) {
  cv::Mat gray, edges;
  cv::cvtColor(picture(where), gray, cv::COLOR_BGR2GRAY);
  cv::Laplacian(gray, edges, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(edges, mean, deviation);
  return deviation[0];
}

TEST(AugmentedAperture, IsSharpestWhereTheSubjectIs) {
  StageOptions options;
  options.rendered = true;
  const OffscreenSurface surface({64, 64});
  const StagedCapture capture(options);
  SpreadPictures spread;
  for (const double elevation : {-4.0, 0.0, 4.0})
    for (const double azimuth : {-6.0, -3.0, 3.0, 6.0})
      spread.Offer(*capture.At(capture.CameraAt(azimuth, elevation)));
  ASSERT_EQ(spread.pictures().size(), 12u);
  std::vector<WeightedPicture> pictures;
  for (const PosedPicture& picture : spread.pictures()) pictures.push_back({&picture, 1});
  Reprojection reprojection;
  const Rigid3 pose = capture.CameraAt(0, 0);
  const CameraModel camera = capture.camera().ScaledTo(480, 360);
  const Eigen::Vector3d from = pose.OriginInSource(), to = capture.subject().center_in_world;
  const auto sharpness_at = [&](double distance) {
    reprojection.Draw(camera, pose, from + distance * (to - from), pictures);
    return Sharpness(reprojection.Read(), cv::Rect(200, 140, 80, 80));
  };
  const double sharp = std::max({sharpness_at(0.9), sharpness_at(0.95), sharpness_at(1.0)});
  for (const double off : {0.6, 0.75, 1.3, 1.6})
    EXPECT_GT(sharp, 1.3 * sharpness_at(off)) << "focused at " << off;
}

// ---- review

TEST(Review, FromTheLiveCameraShowsWhatTheLivePictureShows) {
  StageOptions options;
  options.rendered = true;
  Stage stage({640, 480}, 1, options);
  const Rigid3 pose = stage.capture.CameraAt(2, 1);
  for (const auto& [azimuth, elevation] :
       {std::pair{2.0, 1.0}, {8.0, 1.0}, {-4.0, 1.0}, {2.0, 7.0}, {2.0, -5.0}})
    stage.Show(stage.capture.Record(stage.capture.CameraAt(azimuth, elevation)));
  const auto state = stage.capture.At(pose);
  stage.Type('r');
  const cv::Mat picture = stage.Show(state);
  const cv::Rect middle(230, 160, 180, 160);  // the subject, and what no panel hides
  EXPECT_GT(cv::PSNR(picture(middle), state->live.pixels(middle)), 26);
  // Where nothing near has been recorded the review is wrong, and looks so.
  const auto elsewhere = stage.capture.At(stage.capture.CameraAt(45, 1));
  EXPECT_LT(cv::PSNR(stage.Show(elsewhere)(middle), elsewhere->live.pixels(middle)), 20);
}

TEST(Review, WipeShowsLiveOnTheLeftAndRecordedOnTheRight) {
  StageOptions options;
  options.rendered = true;
  Stage stage({640, 480}, 1, options);
  stage.Show(stage.capture.Record(stage.capture.CameraAt(0, 0)));
  const auto state = stage.capture.At(stage.capture.CameraAt(20, 0));
  stage.Type('r');
  stage.Type('w');
  const cv::Mat picture = stage.Show(state);
  const cv::Rect left(230, 160, 80, 130), right(330, 160, 80, 130);
  EXPECT_LT(cv::norm(picture(left), state->live.pixels(left), cv::NORM_INF), 2);
  EXPECT_LT(cv::PSNR(picture(right), state->live.pixels(right)), 25);
}

TEST(Review, OrbitGoesWhereTheKeysSay) {
  StagedCapture capture;
  capture.Record(capture.CameraAt(0, 0));
  const auto state = capture.At(capture.CameraAt(0, 0));
  Review review;
  review.Open(*state);
  for (int i = 0; i < 5; ++i) review.Handle(KeyPressed{Key::kRight}, *state);
  for (int i = 0; i < 2; ++i) review.Handle(KeyPressed{Key::kUp}, *state);
  EXPECT_EQ(review.control(), Review::Control::kMouseAndKeys);
  const auto there = review.CameraNow(*state);
  ASSERT_TRUE(there);
  const Rigid3 expected = capture.CameraAt(10, 4);
  EXPECT_LT((there->cam_from_world.OriginInSource() - expected.OriginInSource()).norm(), 1e-6);
  EXPECT_EQ(there->camera.distortion, Distortion::kNone);
}

TEST(Review, TakenBackViewsAreGone) {
  StagedCapture capture;
  RecordedPictures recorded;
  for (const double azimuth : {0.0, 5.0, 10.0}) recorded.Add(*capture.Record(capture.CameraAt(azimuth, 0)));
  EXPECT_EQ(recorded.pictures().size(), 3u);
  auto state = capture.At(capture.CameraAt(0, 0));
  auto fewer = std::make_shared<CoverageMap>(*state->coverage);
  const std::vector<CriterionView> left{state->coverage->views()[0], state->coverage->views()[2]};
  fewer->SetViews(left);
  state->coverage = fewer;
  state->view_ids = {1, 3};
  recorded.Follow(*state);
  ASSERT_EQ(recorded.pictures().size(), 2u);
  EXPECT_LT((recorded.pictures().at(3).cam_from_world.OriginInSource() - left[1].center_in_world).norm(),
            1e-9);
}

TEST(SpreadPictures, StayFewAndFarApart) {
  StagedCapture capture;
  SpreadPictures spread(12);
  for (int i = 0; i < 400; ++i)
    spread.Offer(*capture.At(capture.CameraAt(-30 + 0.15 * i, 10 * std::sin(0.05 * i))));
  EXPECT_LE(spread.pictures().size(), 12u);
  EXPECT_GE(spread.pictures().size(), 6u);
}

// ---- the two threads

TEST(RunWithDisplay, WithoutADisplayTheCaptureGoesOnAndThatIsSaid) {
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
}

std::unique_ptr<Surface> Small() { return std::make_unique<OffscreenSurface>(cv::Size(320, 240)); }

TEST(RunWithDisplay, ClosingTheWindowAsksTheCaptureToFinishAndWaitsForIt) {
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

TEST(RunWithDisplay, TheEndOfTheCaptureIsTheEndOfTheDisplay) {
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

TEST(RunWithDisplay, WhatTheCaptureThrowsComesOut) {
  CaptureFeed feed;
  CaptureRequests requests;
  EXPECT_THROW(RunWithDisplay(Small, {}, feed, requests, [] { throw Error("the disk"); }), Error);
}

TEST(RunWithDisplay, ADisplayThatBreaksDoesNotBreakTheCapture) {
  CaptureFeed feed;
  CaptureRequests requests;
  class Breaking : public OffscreenSurface {
   public:
    Breaking() : OffscreenSurface(cv::Size(320, 240)) {}
    void Present() override { throw Error("the driver is gone"); }
  };
  bool captured = false;
  ::testing::internal::CaptureStderr();
  RunWithDisplay([] { return std::make_unique<Breaking>(); }, {}, feed, requests,
                 [&] {
                   std::this_thread::sleep_for(std::chrono::milliseconds(300));
                   captured = true;
                 });
  EXPECT_TRUE(captured);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("the driver is gone"));
}

}  // namespace
}  // namespace ulf::test
