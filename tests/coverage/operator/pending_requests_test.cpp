// Tests: coverage/operator/pending_requests, coverage/operator/subject_tool.
//
// Keys that come faster than states: what is asked of the capture is what the person wanted.
#include "coverage/operator/pending_requests.h"

#include <gmock/gmock.h>

#include <deque>
#include <random>

#include "tests/coverage/operator/display_stage.h"
#include "tests/support/floors.h"

namespace ulf::test::pending_requests_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Enough of a state for keys: a camera that is tracked, and a subject before it.
std::shared_ptr<CaptureState> Tracked() {
  auto state = std::make_shared<CaptureState>();
  state->camera = CameraModel::Pinhole(640, 480, 600);
  state->tracking = TrackState::kTracking;
  state->cam_from_world = LookAt({0.3, -0.2, 0}, {0.1, 0.1, 1.2}, -Eigen::Vector3d::UnitY());
  state->subject = Subject{{0, 0, 1.1}, 0.15};
  return state;
}

// As a session: what is asked is answered in its order, some of it before every state, and states are seen
// late.
class LateCapture {
 public:
  void Take(CaptureRequests& requests) {
    for (CaptureRequest& request : requests.Take()) waiting_.push_back(std::move(request));
  }
  void Answer(std::size_t count) {
    for (; count > 0 && !waiting_.empty(); --count, waiting_.pop_front(), ++usual_.requests_answered) {
      if (const auto* asked = std::get_if<SetRecording>(&waiting_.front())) usual_.recording = asked->on;
      if (const auto* asked = std::get_if<PlaceSphere>(&waiting_.front())) usual_.subject = asked->subject;
    }
  }
  std::shared_ptr<const CaptureState> Now() const { return std::make_shared<CaptureState>(usual_); }
  bool recording() const { return usual_.recording; }

 private:
  CaptureState usual_ = *Tracked();
  std::deque<CaptureRequest> waiting_;
};

// A display that nobody sees, which is quick.
class Iconified : public OffscreenSurface {
 public:
  Iconified() : OffscreenSurface({64, 48}) {}
  cv::Size Size() const override { return {}; }
};

// A person at it.
struct Desk {
  void Show(std::shared_ptr<const CaptureState> state) {
    feed.Publish(std::move(state));
    display.Step();
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
  Iconified surface;
  CaptureFeed feed;
  CaptureRequests requests;
  OperatorDisplay display{surface, feed, requests};
};

class Keyboard {
 public:
  Keyboard() { Catch(1000, true); }

  // Whether it records after these keys and Escape. `lag`: how much is answered after a key, and whether a
  // state comes then, is by chance; null: all, and at once.
  bool RecordsAfter(const std::string& keys, std::mt19937* lag = nullptr) {
    for (const char key : keys + "e") {
      desk_.surface.Push(key == 'e'    ? InputEvent(KeyPressed{Key::kEscape})
                         : key == '\n' ? InputEvent(KeyPressed{Key::kEnter})
                                       : InputEvent(Typed{static_cast<char32_t>(key)}));
      desk_.display.Step();
      const std::size_t answered = lag ? (*lag)() % 2 : 1000;
      Catch(answered, !lag || (*lag)() % 3 == 0);
    }
    Catch(1000, true);
    const bool recording = capture_.recording();
    if (!recording) {  // as it was
      desk_.requests.Push(SetRecording{true});
      Catch(1000, true);
    }
    return recording;
  }

 private:
  void Catch(std::size_t answered, bool state_comes) {
    capture_.Take(desk_.requests);
    capture_.Answer(answered);
    if (state_comes) desk_.feed.Publish(capture_.Now());
    desk_.display.Step();
  }
  Desk desk_;
  LateCapture capture_;
};

TEST(PendingRequests, KeysMeanTheSameForLateStates) {
  Keyboard keyboard;
  std::mt19937 random(7);
  int recording = 0;
  constexpr int kScripts = 200;
  for (int i = 0; i < kScripts; ++i) {
    std::string keys;
    for (int length = 2 + static_cast<int>(random() % 7); length > 0; --length)
      keys += "  ssse\n"[random() % 7];
    const bool at_once = keyboard.RecordsAfter(keys);
    recording += at_once;
    EXPECT_EQ(keyboard.RecordsAfter(keys, &random), at_once) << "'" << keys << "'";
  }
  EXPECT_GT(recording, kScripts / 5);
  EXPECT_LT(recording, kScripts * 4 / 5) << "the test shows nothing";
}

TEST(PendingRequests, PauseOutlastsTheSubjectTool) {
  Keyboard keyboard;
  EXPECT_TRUE(keyboard.RecordsAfter("ss")) << "as it was before";
  EXPECT_FALSE(keyboard.RecordsAfter("s  s")) << "gone on, and paused again";
  EXPECT_TRUE(keyboard.RecordsAfter("s s"));
  EXPECT_FALSE(keyboard.RecordsAfter(" ss")) << "it was paused before";
}

TEST(PendingRequests, QuickPressesTakeBackViewsInTurn) {
  Desk desk;
  const auto state = Tracked();
  state->view_ids = {1, 2, 3};
  desk.Show(state);
  for (int i = 0; i < 2; ++i) desk.Press(Key::kBackspace);
  std::vector<int> taken;
  for (const TakeBackViews& asked : desk.Asked<TakeBackViews>())
    taken.insert(taken.end(), asked.ids.begin(), asked.ids.end());
  EXPECT_THAT(taken, ElementsAre(3, 2)) << "those that were on the screen";
  for (int i = 0; i < 3; ++i) desk.Press(Key::kBackspace);
  const auto rest = desk.Asked<TakeBackViews>();
  ASSERT_EQ(rest.size(), 1u) << "there are three";
  EXPECT_THAT(rest[0].ids, ElementsAre(1));
}

TEST(PendingRequests, PlacedSubjectIsTheDraftAtOnce) {
  Desk desk;
  const auto state = Tracked();
  desk.Show(state);
  desk.Type('s');
  for (int i = 0; i < 3; ++i) desk.Press(Key::kRight);
  desk.Press(Key::kEnter);
  desk.Type('s');  // no state has come in between
  desk.Press(Key::kRight);
  desk.Press(Key::kEnter);
  const auto placed = desk.Asked<PlaceSphere>();
  ASSERT_EQ(placed.size(), 2u);
  EXPECT_NEAR(placed[1].subject.radius, state->subject->radius * std::pow(1.02, 4), 1e-12);
  // What the capture refuses is not kept.
  auto refused = std::make_shared<CaptureState>(*state);
  refused->requests_answered = 100;
  desk.Show(refused);
  desk.Type('s');
  desk.Press(Key::kRight);
  desk.Press(Key::kEnter);
  const auto again = desk.Asked<PlaceSphere>();
  ASSERT_EQ(again.size(), 1u);
  EXPECT_NEAR(again[0].subject.radius, state->subject->radius * 1.02, 1e-12);
}

TEST(PendingRequests, CapsLockChangesNothing) {
  Desk desk;
  desk.Show(Tracked());
  desk.Type(U'S');
  EXPECT_EQ(desk.Asked<SetRecording>().size(), 1u) << "the subject tool is open";
  desk.Type(U'Q');
  EXPECT_EQ(desk.Asked<FinishCapture>().size(), 1u);
}

// ---- with a keyboard alone

TEST(SubjectTool, ShiftArrowsMoveTheSphereInThePicture) {
  Desk desk;
  const auto state = Tracked();
  state->requests_answered = 1000;  // as soon as they are asked
  const Rigid3& pose = *state->cam_from_world;
  const auto img_of = [&](const Subject& subject) {
    return *state->camera.ImgFromCam(pose * subject.center_in_world);
  };
  struct Case {
    Key key;
    Eigen::Vector2d way;
  };
  for (const Case& c : {Case{Key::kLeft, {-1, 0}}, Case{Key::kRight, {1, 0}}, Case{Key::kUp, {0, -1}},
                        Case{Key::kDown, {0, 1}}}) {
    desk.Show(std::make_shared<CaptureState>(*state));
    desk.Type('s');
    for (int i = 0; i < 4; ++i) desk.Press(c.key, true);
    desk.Press(Key::kEnter);
    const auto placed = desk.Asked<PlaceSphere>();
    ASSERT_EQ(placed.size(), 1u);
    const Eigen::Vector2d moved = img_of(placed[0].subject) - img_of(*state->subject);
    EXPECT_LT((moved - 0.04 * state->camera.width * c.way).norm(), 1) << c.way.transpose();
    EXPECT_EQ(placed[0].subject.radius, state->subject->radius);
    EXPECT_NEAR((pose * placed[0].subject.center_in_world).z(), (pose * state->subject->center_in_world).z(),
                1e-9)
        << "as deep as before";
  }
}

TEST(PendingRequests, DeleteTakesBackTheViewThatIsMarked) {
  Stage stage({640, 480});
  stage.capture.RecordRows(-10, 10, -5, 5, 5);  // 1 to 5, 6 to 10, 11 to 15
  const Rigid3 pose = stage.capture.CameraAt(4.4, 0.7);
  const auto state = stage.capture.At(pose);
  for (const auto& recorded : stage.capture.recorded()) {
    stage.feed.Publish(recorded);
    stage.display.Step();
  }
  stage.Show(state);
  stage.Type('r');
  cv::Mat picture = stage.Show(std::make_shared<CaptureState>(*state));
  stage.Press(Key::kDelete);
  EXPECT_THAT(stage.Asked<TakeBackViews>(), IsEmpty()) << "nobody has seen yet what is marked";
  const auto look = [&] {
    for (int frame = 0; frame < 15; ++frame) picture = stage.Show(std::make_shared<CaptureState>(*state));
  };
  look();
  const Eigen::Vector3d center = stage.capture.subject().center_in_world;
  const Eigen::Vector3d direction = (state->coverage->views()[8].center_in_world - center).normalized();
  const Eigen::Vector2d at = stage.OnScreen(*stage.capture.camera().ImgFromCam(
      pose * Eigen::Vector3d(center + stage.capture.subject().radius * direction)));
  const auto pixel = picture.at<cv::Vec3b>(static_cast<int>(at.y()), static_cast<int>(at.x()));
  const Rgba& guide = Palette::Standard().guide;
  EXPECT_LT(cv::norm(cv::Vec3d(pixel) - cv::Vec3d(guide.b, guide.g, guide.r)), 12) << pixel;

  // Twice before the next is marked: one.
  stage.Press(Key::kDelete);
  stage.Press(Key::kBackspace);
  const auto taken = stage.Asked<TakeBackViews>();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_THAT(taken[0].ids, ElementsAre(9));
  // The state still has it, the next press means another one.
  look();
  stage.Press(Key::kDelete);
  const auto next = stage.Asked<TakeBackViews>();
  ASSERT_EQ(next.size(), 1u);
  EXPECT_THAT(next[0].ids, ElementsAre(14)) << "the second nearest in direction";
  EXPECT_THAT(stage.Asked<TakeBackLast>(), IsEmpty());
}

TEST(PendingRequests, NothingIsMarkedWithoutACamera) {
  Desk desk;
  const auto state = Tracked();
  state->view_ids = {1, 2, 3};
  desk.Show(state);
  desk.Type('r');
  auto lost = std::make_shared<CaptureState>(*state);
  lost->cam_from_world.reset();
  desk.Show(lost);
  desk.Press(Key::kDelete);
  desk.Press(Key::kBackspace);
  EXPECT_THAT(desk.Asked<TakeBackViews>(), IsEmpty());
}

}  // namespace
}  // namespace ulf::test::pending_requests_test
