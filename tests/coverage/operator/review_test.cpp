// Tests: coverage/operator/review, coverage/operator/key_actions.
//
// Looking at what is recorded while the capture goes on, in the display and apart from it.
#include "coverage/operator/review.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <thread>

#include "acquisition/simulator/simulated_board.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/coverage/operator/display_stage.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::review_test {
namespace {

// ---- review in the display

TEST(Review, AtTheLiveCameraEqualsTheLivePicture) {
  Stage stage(kSmall, 1, kRendered);
  const Rigid3 pose = stage.capture.CameraAt(2, 1);
  for (const auto& [azimuth, elevation] :
       {std::pair{2.0, 1.0}, {8.0, 1.0}, {-4.0, 1.0}, {2.0, 7.0}, {2.0, -5.0}})
    stage.Show(stage.capture.Record(stage.capture.CameraAt(azimuth, elevation)));
  const auto state = stage.capture.At(pose);
  stage.Type('r');
  EXPECT_GT(Likeness(stage.Show(state), state->live.pixels, kBeside), 26);
  // Where nothing near has been recorded the review is wrong, and looks so.
  const auto elsewhere = stage.capture.At(stage.capture.CameraAt(45, 1));
  EXPECT_LT(Likeness(stage.Show(elsewhere), elsewhere->live.pixels, kBeside), 20);
}

TEST(Review, WipeShowsLiveOnTheLeftAndRecordedOnTheRight) {
  Stage stage(kSmall, 1, kRendered);
  stage.Show(stage.capture.Record(stage.capture.CameraAt(0, 0)));
  const auto state = stage.capture.At(stage.capture.CameraAt(20, 0));
  stage.Type('r');
  const cv::Mat recorded = stage.Show(state).clone();
  stage.Type('w');
  const cv::Mat& live = state->live.pixels;
  const auto expect_divided_at = [&](const cv::Mat& picture, int x) {
    const cv::Rect left(x - 90, 90, 80, 70), right(x + 10, 90, 80, 70);
    EXPECT_LT(cv::norm(picture(left), live(left), cv::NORM_INF), 2) << "live, left of " << x;
    EXPECT_LT(cv::norm(picture(right), recorded(right), cv::NORM_INF), 2) << "recorded, right of " << x;
    EXPECT_LT(Likeness(recorded, live, right), 25) << "where they differ";
  };
  expect_divided_at(stage.Show(state), 320);
  for (int i = 0; i < 2; ++i) stage.Type('.');  // a twentieth of the width each
  expect_divided_at(stage.Show(state), 384);
  for (int i = 0; i < 4; ++i) stage.Type(',');
  expect_divided_at(stage.Show(state), 256);
}

TEST(Review, BlinkShowsLiveAndRecordedByTurns) {
  Stage stage(kSmall, 1, kRendered);
  stage.Show(stage.capture.Record(stage.capture.CameraAt(0, 0)));
  const auto state = stage.capture.At(stage.capture.CameraAt(20, 0));
  stage.Type('r');
  const cv::Mat recorded = stage.Show(state).clone();
  stage.Type('b');
  std::string turns;  // L, R
  for (int i = 0; i < 48; ++i) {
    const cv::Mat picture = stage.Show(state);
    const bool live = cv::norm(picture(kAbove), state->live.pixels(kAbove), cv::NORM_INF) < 2;
    const bool review = cv::norm(picture(kAbove), recorded(kAbove), cv::NORM_INF) < 2;
    ASSERT_NE(live, review) << "frame " << i;
    turns += live ? 'L' : 'R';
  }
  // Half a second each, at thirty frames a second.
  const std::string half_l(15, 'L'), half_r(15, 'R');
  EXPECT_NE(turns.find("R" + half_l + "R"), std::string::npos) << turns;
  EXPECT_NE(turns.find("L" + half_r + "L"), std::string::npos) << turns;
  EXPECT_EQ(turns.find(half_l + "L"), std::string::npos) << turns;
  EXPECT_EQ(turns.find(half_r + "R"), std::string::npos) << turns;
  stage.Type('b');
  for (int i = 0; i < 16; ++i)
    EXPECT_LT(cv::norm(stage.Show(state)(kAbove), recorded(kAbove), cv::NORM_INF), 2) << "blinks no more";
}

// Views that look different from one another.
class Looking : public ::testing::Test {
 protected:
  explicit Looking(const DisplayOptions& options = AtFps(30)) : stage_(kSmall, 1, kRendered, options) {
    for (const double azimuth : {-24.0, -12.0, 0.0, 12.0, 24.0}) {
      const auto state = stage_.capture.Record(stage_.capture.CameraAt(azimuth, 0));
      stage_.Show(state);
      seen_[azimuth] = state->live.pixels.clone();
    }
  }
  // Which of them it is.
  double ShownIn(const cv::Mat& picture) const {
    double best = 0, shown = 100;
    for (const auto& [azimuth, view] : seen_)
      if (const double likeness = Likeness(picture, view); likeness > best) best = likeness, shown = azimuth;
    EXPECT_GT(best, 20) << "none of them is shown";
    return shown;
  }
  Stage stage_;
  std::map<double, cv::Mat> seen_;
};

TEST_F(Looking, ByMouseOrbitsTheSubject) {
  const auto state = stage_.capture.At(stage_.capture.CameraAt(0, 0));
  stage_.Show(state);
  stage_.Type('r');
  EXPECT_EQ(ShownIn(stage_.Show(state)), 0);
  const auto drag = [&](double from_x, double to_x) {
    stage_.surface.Push(MouseMoved{{from_x, 200}});
    stage_.surface.Push(MouseButton{0, true});
    stage_.surface.Push(MouseMoved{{to_x, 200}});
    stage_.surface.Push(MouseButton{0, false});
    stage_.surface.Push(MouseMoved{{10, 10}});  // that is no drag any more
  };
  drag(300, 252);  // a quarter of a degree a pixel: the subject turns left, the camera goes right
  EXPECT_EQ(ShownIn(stage_.Show(state)), 12);
  drag(100, 196);
  EXPECT_EQ(ShownIn(stage_.Show(state)), -12);
  // Nearer: the same view, larger.
  const cv::Mat before = stage_.Show(state);
  stage_.surface.Push(WheelTurned{6});
  EXPECT_LT(Likeness(stage_.Show(state), before), 20);
}

// A board in a hand before the camera, metres; its own pose is what moves the virtual camera.
constexpr const char* kHeld = "charuco:7x5:30:22:DICT_5X5_100";

class LookingByMarker : public Looking {
 protected:
  LookingByMarker() : Looking(AtFps(30, {.marker = kHeld})) {
    BoardSceneOptions options;
    options.board = Board::Parse(kHeld);
    options.camera = stage_.capture.camera();
    board_ = std::make_unique<BoardScene>(options);
  }
  // Turned about its upright middle axis, half a metre away.
  std::shared_ptr<CaptureState> Held(double turned_deg, double distance_mm = 500) {
    auto state = stage_.capture.At(stage_.capture.CameraAt(5, 5));
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(Radians(turned_deg), Eigen::Vector3d::UnitY()).toRotationMatrix();
    const Eigen::Vector3d middle = 1000 * MarkerSpec::Parse(kHeld).Middle();
    const Rigid3 cam_from_board{Eigen::Quaterniond(turn), Eigen::Vector3d(0, 0, distance_mm) - turn * middle};
    state->live = {board_->Render(cam_from_board, 1), Transfer::kLinear};
    state->device_time_s = ++time_s_;
    return state;
  }
  std::unique_ptr<BoardScene> board_;
  double time_s_ = 1000;
};

TEST_F(LookingByMarker, BoardStandsForTheSubject) {
  for (const char32_t key : {U'r', U'c', U'c'}) stage_.Type(key);
  EXPECT_EQ(ShownIn(stage_.Show(Held(0))), 0) << "as it is held first, the views are seen from their middle";
  EXPECT_EQ(ShownIn(stage_.Show(Held(12))), 12);
  EXPECT_EQ(ShownIn(stage_.Show(Held(-12))), -12);
  const cv::Mat before = stage_.Show(Held(0));
  EXPECT_LT(Likeness(stage_.Show(Held(0, 350)), before), 20) << "nearer is nearer";
  // Put away: the last picture stays, and the display says what to do.
  const cv::Mat last = stage_.Show(Held(12)).clone();
  auto away = stage_.capture.At(stage_.capture.CameraAt(5, 5));
  away->device_time_s = ++time_s_;
  const cv::Mat without = stage_.Show(away);
  EXPECT_LT(cv::norm(without(kMiddle), last(kMiddle), cv::NORM_INF), 2);
  const cv::Rect words(120, 420, 400, 50);
  EXPECT_GT(cv::norm(without(words), last(words), cv::NORM_L1) / static_cast<double>(words.area()), 5);
}

TEST(Review, TakenBackViewsLeaveAtOnceWhileItIsOpen) {
  Stage stage(kSmall);
  // Each view is an even colour.
  const auto record = [&](double azimuth, const cv::Scalar& color) {
    const auto state = stage.capture.Record(stage.capture.CameraAt(azimuth, 0));
    RecordedFrame view = *state->newest_view;
    view.frame.image.pixels = cv::Mat(kSmall, CV_8UC3, color);
    state->newest_view = std::make_shared<RecordedFrame>(view);
    stage.Show(state);
  };
  record(0, {200, 60, 60});
  record(20, {60, 60, 200});
  stage.Type('r');
  const auto middle_from = [&](double azimuth) {
    return cv::mean(stage.Show(stage.capture.At(stage.capture.CameraAt(azimuth, 0)))(kAbove));
  };
  EXPECT_GT(middle_from(20)[2], 150);
  stage.capture.TakeBack(2);
  EXPECT_NEAR(middle_from(20)[2], 60, 3);
  EXPECT_NEAR(middle_from(20)[0], 200, 3);
  stage.capture.TakeBack(1);
  const auto nothing = middle_from(20);
  EXPECT_NEAR(nothing[0], StagedCapture::kGrey, 2) << "the live picture, and that nothing is recorded";
}

// What a display sees of three views that an earlier session recorded; their light field lies in `dir`.
std::shared_ptr<CaptureState> Resumed(Stage& stage, const std::filesystem::path& dir) {
  CaptureHeader header;
  header.camera = stage.capture.camera();
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  for (const double azimuth : {-6.0, 0.0, 6.0}) {
    const auto recorded = stage.capture.Record(stage.capture.CameraAt(azimuth, 0));
    View view;
    view.cam_from_world = *recorded->cam_from_world;
    writer.AddView(recorded->newest_view->frame, view);
  }
  auto state = stage.capture.At(stage.capture.CameraAt(0, 0));
  state->newest_view.reset();
  state->light_field = dir;
  return state;
}

TEST(Review, ShowsViewsRecordedBeforeResuming) {
  Stage stage(kSmall, 1, kRendered);
  const ScratchFolder scratch;
  const auto state = Resumed(stage, scratch / "lf");
  stage.Show(state);
  stage.Type('r');
  double likeness = 0;
  for (int i = 0; i < 500 && likeness < 24; ++i) {
    likeness = Likeness(stage.Show(state), state->live.pixels, kBeside);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_GT(likeness, 24);
}

TEST(Review, SaysWhatItCannotShow) {
  Stage stage(kSmall);  // of even grey
  const ScratchFolder scratch;
  const auto state = Resumed(stage, scratch / "lf");
  std::filesystem::remove(scratch / "lf/images/000002.png");
  stage.Show(state);
  stage.Type('r');
  const cv::Rect above_the_instruction(170, 340, 300, 90);
  const auto coloured = [&] {
    std::vector<cv::Mat> bgr;
    cv::split(stage.Show(state)(above_the_instruction), bgr);
    return cv::countNonZero(bgr[2] > bgr[0] + 60);
  };
  EXPECT_EQ(coloured(), 0);
  int most = 0;
  for (int i = 0; i < 500 && most < 100; ++i) {
    most = coloured();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_GE(most, 100);
}

// ---- the virtual camera

TEST(VirtualCamera, OrbitGoesWhereTheKeysSay) {
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

TEST(VirtualCamera, FollowsASubjectThatIsPlacedAnew) {
  StagedCapture capture;
  for (const double azimuth : {-10.0, 0.0, 10.0}) capture.Record(capture.CameraAt(azimuth, 0));
  const auto state = capture.At(capture.CameraAt(0, 0));
  Review review;
  review.Open(*state);
  for (int i = 0; i < 5; ++i) review.Handle(KeyPressed{Key::kRight}, *state);
  const Eigen::Vector3d before = review.CameraNow(*state)->cam_from_world.OriginInSource();
  const Subject moved{capture.subject().center_in_world + Eigen::Vector3d(0.1, 0.05, -0.08),
                      0.7 * capture.subject().radius};
  const Rigid3 live = capture.CameraAt(0, 0);
  capture.PlaceSubject(moved);
  const auto now = capture.At(live);
  const auto aims_at_it = [&](const Rigid3& cam_from_world) {
    const Eigen::Vector3d in_cam = cam_from_world * moved.center_in_world;
    return in_cam.z() > 0 && in_cam.head<2>().norm() < 1e-9;
  };
  const Rigid3 anew = review.CameraNow(*now)->cam_from_world;
  EXPECT_LT((anew.OriginInSource() - before).norm(), 1e-9) << "the camera stays where it was";
  EXPECT_TRUE(aims_at_it(anew));
  // And goes round the new one, in the new one's angles.
  review.Handle(KeyPressed{Key::kRight}, *now);
  const Rigid3 further = review.CameraNow(*now)->cam_from_world;
  EXPECT_TRUE(aims_at_it(further));
  EXPECT_NEAR((further.OriginInSource() - moved.center_in_world).norm(),
              (before - moved.center_in_world).norm(), 1e-9);
  const CapFrame& frame = *now->coverage->frame();
  EXPECT_NEAR(frame.Of((further.OriginInSource() - moved.center_in_world).normalized()).azimuth,
              frame.Of((before - moved.center_in_world).normalized()).azimuth + Radians(2), 1e-9);
}

TEST_F(LookingByMarker, BoardFollowsANewlyPlacedSubject) {
  Review review(kHeld);
  const auto state = Held(0);
  review.Open(*state);
  for (int i = 0; i < 2; ++i) review.Handle(Typed{U'c'}, *state);
  ASSERT_TRUE(review.CameraNow(*state));
  const Subject moved{stage_.capture.subject().center_in_world + Eigen::Vector3d(0.1, 0.05, -0.08), 0.1};
  stage_.capture.PlaceSubject(moved);
  // The board is out of sight meanwhile: what it showed last counts.
  auto now = stage_.capture.At(stage_.capture.CameraAt(5, 5));
  now->device_time_s = ++time_s_;
  const auto camera = review.CameraNow(*now);
  ASSERT_TRUE(camera);
  EXPECT_FALSE(review.marker_is_seen());
  const Eigen::Vector3d in_cam = camera->cam_from_world * moved.center_in_world;
  EXPECT_LT(in_cam.head<2>().norm(), 1e-9) << "aimed at the new one";
  std::vector<double> distances;
  for (const CriterionView& view : now->coverage->views())
    distances.push_back((view.center_in_world - moved.center_in_world).norm());
  std::sort(distances.begin(), distances.end());
  EXPECT_NEAR(in_cam.z(), distances[2], 1e-6) << "from as far as the views are";
}

}  // namespace
}  // namespace ulf::test::review_test
