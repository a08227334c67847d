// Tests: coverage/session/turn_back.
//
// A person who is told to turn, and does so, looks where the camera looked when its position was known.
#include "coverage/session/turn_back.h"

#include <gmock/gmock.h>

#include "coverage/operator/instruction.h"
#include "coverage/operator/overlay.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/test_paths.h"

namespace ulf::test::turn_back_test {
namespace {

using Eigen::Vector2d;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

// The same place, aimed at what the camera has at this place of its picture.
Rigid3 AimedAt(const Rigid3& cam_from_world, const Vector2d& img) {
  const Vector3d at = cam_from_world.OriginInSource();
  return LookAt(at, at + cam_from_world.DirectionInSource(*kCamera.RayFromImg(img)),
                cam_from_world.DirectionInSource(-Vector3d::UnitY()));
}

CameraTurn Between(const Rigid3& then, const Rigid3& now) {
  return {now.rotation * then.rotation.conjugate(), true};
}

const Rigid3 kThen = PoseAt(20, 10);
const Vector2d kMiddle(0.5 * kCamera.width, 0.5 * kCamera.height);

// Whoever aims at something on the right of the picture has turned right, and is to turn left.
TEST(TurnBack, WordsSayTheWayBack) {
  struct Case {
    Vector2d aimed_at;
    const char *words, *not_words;
  };
  const double third = kCamera.width / 3.0;
  for (const Case& c :
       {Case{kMiddle + Vector2d(third, 0), "left", "right"},
        Case{kMiddle - Vector2d(third, 0), "right", "left"}, Case{kMiddle + Vector2d(0, third), "up", "down"},
        Case{kMiddle - Vector2d(0, third), "down", "up"}}) {
    const Rigid3 now = AimedAt(kThen, c.aimed_at);
    EXPECT_THAT(TurnBackInWords(Between(kThen, now)),
                AllOf(StartsWith("turn "), HasSubstr(c.words), Not(HasSubstr(c.not_words))));
  }
  EXPECT_EQ(TurnBackInWords(Between(kThen, kThen)), "");
  EXPECT_EQ(TurnBackInWords(Between(kThen, AimedAt(kThen, kMiddle + Vector2d(8, 0)))), "") << "near enough";
  EXPECT_THAT(TurnBackInWords(Between(kThen, Turned(kThen, 180))), HasSubstr("180°"));
}

// Told degrees that are done, in the order in which they are told, the camera looks there.
TEST(TurnBack, FollowingTheWordsFindsTheViewAgain) {
  for (const double right : {-0.4, 0.0, 0.45})
    for (const double down : {-0.3, 0.0, 0.2}) {
      Rigid3 now = AimedAt(kThen, kMiddle + kCamera.width * Vector2d(right, down));
      now = AimedAt(now, kMiddle + kCamera.width * Vector2d(right, 0));  // farther than a picture is wide
      const std::string words = TurnBackInWords(Between(kThen, now));
      const auto told = [&](const char* forward, const char* backward) {
        for (const auto& [word, sign] : {std::pair(forward, 1.0), {backward, -1.0}})
          if (const std::size_t at = words.find(word); at != words.npos) {
            const std::size_t number = words.rfind(' ', words.rfind(' ', at) - 1) + 1;
            return sign * std::stod(words.substr(number));
          }
        return 0.0;
      };
      // Turned right, what was ahead goes to the left; then the head is lowered.
      const auto turn = [](double degrees, const Vector3d& axis) {
        return Eigen::Quaterniond(Eigen::AngleAxisd(Radians(degrees), axis));
      };
      const Eigen::Quaterniond after = turn(told("down", "up"), Vector3d::UnitX()) *
                                       turn(-told("right", "left"), Vector3d::UnitY()) * now.rotation;
      const Vector3d ahead_then = kThen.DirectionInSource(Vector3d::UnitZ());
      EXPECT_LT(Degrees(AngleBetween(after * ahead_then, Vector3d::UnitZ())), 3) << words;
    }
}

TEST(TurnBack, DrawsThePastPictureInThePresentOne) {
  const Rigid3 now = AimedAt(kThen, kMiddle + Vector2d(60, -30));
  // What the camera had in the corners of its picture, far away.
  std::vector<Vector2d> drawn;
  for (const auto& line : FormerFrameOutline(Between(kThen, now), kCamera))
    drawn.insert(drawn.end(), line.begin(), line.end());
  for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(kCamera.width, 0),
                                 Vector2d(kCamera.width, kCamera.height), Vector2d(0, kCamera.height)}) {
    const Vector3d far = kThen.OriginInSource() + 1e7 * kThen.DirectionInSource(*kCamera.RayFromImg(corner));
    const auto img = kCamera.ImgFromCam(now * far);
    ASSERT_TRUE(img);
    double nearest = 1e9;
    for (const Vector2d& at : drawn) nearest = std::min(nearest, (at - *img).norm());
    EXPECT_LT(nearest, 0.01);
  }
  EXPECT_THAT(FormerFrameOutline(Between(kThen, Turned(kThen, 180)), kCamera), IsEmpty()) << "behind";
}

// A source that is lost after some frames and knows how the camera is turned.
class TurningSource : public DriftingSource {
 public:
  explicit TurningSource(int lost_from, const Rigid3& looks)
      : DriftingSource({}), lost_from_(lost_from), looks_(looks) {}
  Track Step(const Frame& frame) override {
    Track track = DriftingSource::Step(frame);
    if (++frames_ <= lost_from_) return track;
    Track lost;
    lost.state = lost_from_ > 0 ? TrackState::kLost : TrackState::kInitializing;
    lost.turn = looks_.rotation;
    lost.features = 500;
    lost.start =
        StartProgress{.obstacle = StartObstacle::kTooFewMatches, .matches = 20, .matches_needed = 60};
    if (lost_from_ > 0) lost.start.reset();
    return lost;
  }

 private:
  const int lost_from_;
  int frames_ = 0;
  const Rigid3 looks_;
};

std::vector<SharedCaptureState> StatesOf(PoseSource& poses, std::vector<PlanarShot> shots) {
  const ScratchFolder scratch;
  PlanarDevice device(std::move(shots));
  device.Start();
  std::vector<SharedCaptureState> states;
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& state) { states.push_back(state); };
  RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), Options(), hooks);
  return states;
}

TEST(TurnBack, LostCaptureTellsItInWordsAndPicture) {
  const Rigid3 turned_right = AimedAt(PoseAt(4, 0), {2.2 * kCamera.width, kMiddle.y()});
  TurningSource poses(3, turned_right);
  const auto states = StatesOf(poses, {{PoseAt(0, 0)}, {PoseAt(2, 0)}, {PoseAt(4, 0)}, {PoseAt(5, 0)}});
  EXPECT_FALSE(states[2]->turned);
  const CaptureState& lost = *states[3];
  ASSERT_TRUE(lost.turned && lost.turned->reference_has_pose);
  EXPECT_THAT(lost.tracking_words,
              AllOf(StartsWith("position lost"), HasSubstr("° left to where it looked last")));
  EXPECT_EQ(InWords(InstructionFor(lost), lost), lost.tracking_words);
  // An arrow at the left.
  std::vector<Polygon> heads;
  for (const OverlayShape& shape : MakeOverlay(lost))
    if (const auto* head = std::get_if<Polygon>(&shape)) heads.push_back(*head);
  ASSERT_FALSE(heads.empty());
  EXPECT_LT(heads.back().img[0].x(), 0.3 * kCamera.width);
  EXPECT_EQ(heads.back().color, Palette::Standard().guide);
}

TEST(TurnBack, TurningWithoutAMapAsksToMoveSideways) {
  TurningSource poses(0, AimedAt(Rigid3{}, kMiddle + Vector2d(80, 0)));
  const auto states = StatesOf(poses, {{PoseAt(0, 0)}, {PoseAt(0, 0)}});
  const CaptureState& start = *states.back();
  ASSERT_TRUE(start.turned);
  EXPECT_FALSE(start.turned->reference_has_pose);
  EXPECT_EQ(start.tracking_words, "the camera only turns: move it sideways");
  EXPECT_TRUE(IsPureRotation(start.tracking, start.start, start.turned));
}

}  // namespace
}  // namespace ulf::test::turn_back_test
