// Tests: render/viewer/viewer_state, render/viewer/viewer_camera.
//
// The viewer's camera and switches, without a picture.
#include "render/viewer/viewer_state.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <functional>

#include "core/base/error.h"
#include "render/display/surface.h"
#include "render/fields/field_options.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::test::viewer_state_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;
const cv::Size kScreen(1280, 720);

ViewerCamera SomeCamera() {
  ViewerCamera camera;
  camera.eye_in_world = {0.3, 0.4, 2};
  camera.target_in_world = {0.1, -0.1, 0.2};
  camera.up_in_world = Vector3d(0.1, 1, 0).normalized();
  camera.photograph = CameraModel::Pinhole(96, 72, 80);
  return camera;
}

double Roll(const ViewerCamera& camera) {
  return camera.CamFromWorld().DirectionInSource(Vector3d::UnitX()).dot(camera.up_in_world);
}

Vector3d InCamera(const ViewerCamera& camera, const Vector3d& point) { return camera.CamFromWorld() * point; }

TEST(ViewerCamera, OrbitsRoundItsTargetWithoutRoll) {
  const ViewerCamera camera = SomeCamera();
  for (const double right : {-0.3, 0.0, 0.2})
    for (const double up : {-0.2, 0.0, 0.1}) {
      const ViewerCamera moved = Orbited(camera, right, up);
      EXPECT_NEAR(moved.Distance(), camera.Distance(), 1e-12);
      EXPECT_EQ(moved.target_in_world, camera.target_in_world);
      EXPECT_NEAR(Roll(moved), 0, 1e-12);
      // Where it went, as it saw that itself.
      const Vector3d went = InCamera(camera, moved.eye_in_world);
      if (right != 0) {
        EXPECT_GT(went.x() * right, 0) << right << " " << up;
      } else if (up != 0) {
        EXPECT_LT(went.y() * up, 0) << right << " " << up;
      }
    }
  EXPECT_NEAR(Orbited(Orbited(camera, 0.3, 0), -0.3, 0).eye_in_world.x(), camera.eye_in_world.x(), 1e-12);
}

TEST(ViewerCamera, DoesNotGoOverThePoles) {
  for (const double step : {3.0, -3.0}) {
    ViewerCamera camera = SomeCamera();
    for (int i = 0; i < 100; ++i) camera = Orbited(camera, 0.01, step * kDegree);
    const Vector3d arm = (camera.eye_in_world - camera.target_in_world).normalized();
    const double polar = std::acos(arm.dot(camera.up_in_world));
    EXPECT_NEAR(step > 0 ? polar : M_PI - polar, kLeastPolarRad, 1e-9);
    EXPECT_NEAR(Roll(camera), 0, 1e-9);
  }
}

TEST(ViewerCamera, MovesInAndZooms) {
  const ViewerCamera camera = SomeCamera();
  EXPECT_NEAR(MovedIn(camera, 2.5).Distance(), camera.Distance() / 2.5, 1e-12);
  const double focal_px = camera.ModelFor(kScreen).fx;
  EXPECT_NEAR(Zoomed(camera, 2).ModelFor(kScreen).fx, 2 * focal_px, 1e-9);
  EXPECT_EQ(Zoomed(camera, 1e9).zoom, kMostZoom);
}

TEST(ViewerCamera, APhotographJustFillsAWindowOfAnyShape) {
  const ViewerCamera camera = SomeCamera();  // photographs of 96x72, 80 px
  for (const cv::Size& screen : {cv::Size(960, 720), cv::Size(1920, 720), cv::Size(500, 1500)}) {
    const CameraModel shown = camera.ModelFor(screen);
    EXPECT_EQ(cv::Size(shown.width, shown.height), screen);
    const double across = shown.width / shown.fx / (96.0 / 80), down = shown.height / shown.fy / (72.0 / 80);
    EXPECT_NEAR(std::max(across, down), 1, 1e-12) << screen;
  }
}

TEST(ViewerCamera, BeginsInTheMiddleOfTheViewpoints) {
  const auto scene = MakeScene({.viewpoints = CapViewpoints(60, 0.4, 2.0)});
  const ViewerCamera camera = StartingCamera(*scene);
  EXPECT_NEAR(camera.Distance(), 2, 1e-6);
  EXPECT_GT(camera.eye_in_world.normalized().z(), std::cos(0.1));
  // Views from straight above: the light field's up says nothing, the pictures' does.
  auto above = *scene;
  above.up_in_world = Vector3d::UnitZ();
  const ViewerCamera from_above = StartingCamera(above);
  EXPECT_LT(std::abs(from_above.up_in_world.z()), 0.5);
  EXPECT_NEAR(from_above.up_in_world.norm(), 1, 1e-12);
}

TEST(ViewerCamera, FindsTheNearestView) {
  const auto scene = MakeScene({.viewpoints = GridViewpoints(5, 5, 0.2, 2.0)});
  ViewerCamera camera = StartingCamera(*scene);
  camera.eye_in_world = Vector3d(0.17, -0.22, 1.9);
  EXPECT_EQ(AtNearestView(camera, *scene).eye_in_world, Vector3d(0.2, -0.2, 2));
}

ViewerInput SomeInput() {
  ViewerState state;
  state.camera = SomeCamera();
  state.focus_in_world = {0.1, 0, 0};
  return ViewerInput(state, 2, 0.2);
}

void Press(ViewerInput& input, const std::string& keys) {
  for (const InputEvent& event : KeysFromNames(keys)) input.Handle(event, kScreen);
}

// A key, and what of the state it changes.
TEST(ViewerInput, EachKeySwitchesOneThing) {
  struct Case {
    std::string key;
    std::function<void(ViewerState&)> does;
  };
  const auto turned = [](double right, double up) {
    return [=](ViewerState& s) { s.camera = Orbited(s.camera, right * 2 * kDegree, up * 2 * kDegree); };
  };
  const auto panned = [](double right, double up) {
    return [=](ViewerState& s) { s.camera = Panned(s.camera, 0.03 * right, 0.03 * up); };
  };
  for (const Case& c : {
           Case{"Left", turned(-1, 0)},
           Case{"Right", turned(1, 0)},
           Case{"Up", turned(0, 1)},
           Case{"Down", turned(0, -1)},
           Case{"Shift+Left", panned(-1, 0)},
           Case{"Shift+Up", panned(0, 1)},
           Case{"PageUp", [](ViewerState& s) { s.camera = MovedIn(s.camera, 1.05); }},
           Case{"PageDown", [](ViewerState& s) { s.camera = MovedIn(s.camera, 1 / 1.05); }},
           Case{"+", [](ViewerState& s) { s.camera = Zoomed(s.camera, 1.05); }},
           Case{"-", [](ViewerState& s) { s.camera = Zoomed(s.camera, 1 / 1.05); }},
           Case{"2", [](ViewerState& s) { s.field.kind = FieldKind::kLinear; }},
           Case{"5", [](ViewerState& s) { s.field.kind = FieldKind::kNearest; }},
           Case{"f", [](ViewerState& s) { s.field.kind = FieldKind::kLinear; }},
           Case{"l", [](ViewerState& s) { s.field.level = 2; }},
           Case{"p", [](ViewerState& s) { s.proxy = 1; }},
           Case{"b", [](ViewerState& s) { s.shows_field = true; }},
           Case{"M", [](ViewerState& s) { s.shows_mesh = true; }},  // whatever Caps Lock says
           Case{"c", [](ViewerState& s) { s.shows_doubt = true; }},
           Case{"w", [](ViewerState& s) { s.shows_gizmo = false; }},
           Case{"t", [](ViewerState& s) { s.shows_texts = false; }},
           Case{"?", [](ViewerState& s) { s.shows_keys = true; }},
           Case{"e", [](ViewerState& s) { s.exposure_stops = 0.25; }},
           Case{"o", [](ViewerState& s) { s.aperture = 0.2; }},
           Case{"x", [](ViewerState& s) { s.aperture = 0.2; }},
           Case{"u",
                [](ViewerState& s) {
                  s.focus_in_world =
                      s.camera.eye_in_world + 1.03 * (s.focus_in_world - s.camera.eye_in_world);
                }},
           Case{"d", [](ViewerState& s) { s.exposure_stops = -0.25; }},
       }) {
    ViewerInput input = SomeInput();
    ViewerState expected = input.state();
    c.does(expected);
    ASSERT_NE(expected, input.state()) << c.key;
    Press(input, c.key);
    EXPECT_EQ(input.state(), expected) << c.key;
    EXPECT_TRUE(input.TakeRequests().empty()) << c.key;
  }
}

TEST(ViewerInput, CyclesThroughFieldsLevelsAndProxies) {
  ViewerInput input = SomeInput();
  const ViewerState start = input.state();
  const auto press = [&](const std::string& keys) { Press(input, keys); };
  std::vector<FieldKind> fields;
  for (int i = 0; i < 4; ++i) press("f"), fields.push_back(input.state().field.kind);
  EXPECT_THAT(fields, ::testing::ElementsAre(FieldKind::kLinear, FieldKind::kLumigraph, FieldKind::kNearest,
                                             FieldKind::kSubdivision));
  press("4,f");
  EXPECT_EQ(input.state().field.kind, FieldKind::kNearest);
  std::vector<int> levels;
  for (int i = 0; i < 4; ++i) press("l"), levels.push_back(input.state().field.level);
  EXPECT_THAT(levels, ::testing::ElementsAre(1, 2, 3, 1)) << "first back to subdivision";
  press("p,p,Left,PageUp,Shift+Up,+");
  EXPECT_EQ(input.state().proxy, 0);
  EXPECT_NE(input.state().camera, start.camera);
  press("Home");
  EXPECT_EQ(input.state().camera, start.camera);
  EXPECT_THROW(KeysFromNames("b,Elsewhere"), Refusal);
}

TEST(ViewerInput, DraggedPointFollowsTheMouse) {
  for (const int button : {0, 1}) {
    ViewerInput input = SomeInput();
    const ViewerCamera before = input.state().camera;
    input.Handle(MouseMoved{{600, 300}}, kScreen);
    input.Handle(MouseMoved{{620, 310}}, kScreen);
    EXPECT_EQ(input.state().camera, before) << "no button, no drag";
    input.Handle(MouseButton{button, true}, kScreen);
    input.Handle(MouseMoved{{630, 316}}, kScreen);
    const ViewerCamera after = input.state().camera;
    // Of a drag to the side the target itself, of an orbit what lies before it.
    const Vector3d nearer = before.target_in_world + 0.2 * (before.eye_in_world - before.target_in_world);
    const Vector3d point = button == 0 ? nearer : before.target_in_world;
    const Vector2d went = *after.ModelFor(kScreen).ImgFromCam(InCamera(after, point)) -
                          *before.ModelFor(kScreen).ImgFromCam(InCamera(before, point));
    if (button == 1) {
      EXPECT_LT((went - Vector2d(10, 6)).norm(), 1e-6) << went;
    }
    EXPECT_GT(went.x(), 1);
    EXPECT_GT(went.y(), 1);
    input.Handle(MouseButton{button, false}, kScreen);
    input.Handle(MouseMoved{{700, 400}}, kScreen);
    EXPECT_EQ(input.state().camera, after);
  }
  ViewerInput input = SomeInput();
  const double distance = input.state().camera.Distance();
  input.Handle(WheelTurned{1, false}, kScreen);
  EXPECT_LT(input.state().camera.Distance(), distance);
  input.Handle(WheelTurned{1, true}, kScreen);
  EXPECT_GT(input.state().camera.zoom, 1);
}

TEST(ViewerInput, AClickFocusesAndADragDoesNot) {
  const auto focused_at = [](ViewerInput& input) {
    std::vector<Vector2d> at;
    for (const ViewerRequest& request : input.TakeRequests())
      if (request.what == ViewerRequest::kFocus) at.push_back(request.img);
    return at;
  };
  ViewerInput input = SomeInput();
  const ViewerCamera before = input.state().camera;
  const auto click = [&](int button, const Vector2d& slip) {
    input.Handle(MouseMoved{{600, 300}}, kScreen);
    input.Handle(MouseButton{button, true}, kScreen);
    input.Handle(MouseMoved{Vector2d(600, 300) + slip}, kScreen);
    input.Handle(MouseButton{button, false}, kScreen);
  };
  click(0, {2, -1});
  EXPECT_THAT(focused_at(input), ::testing::ElementsAre(Vector2d(602, 299)));
  EXPECT_EQ(input.state().camera, before) << "a hand is never quite still";
  click(1, {0, 0});
  EXPECT_TRUE(focused_at(input).empty()) << "the right button";
  click(0, {9, 0});
  EXPECT_TRUE(focused_at(input).empty());
  EXPECT_NE(input.state().camera, before);
  Press(input, "r");
  EXPECT_THAT(focused_at(input), ::testing::ElementsAre(Vector2d(640, 360)));
}

TEST(ViewerInput, ApertureOpensFromTheLeastVisibleSize) {
  ViewerInput input = SomeInput();
  EXPECT_FALSE(input.state().OpenAperture());
  Press(input, "i");
  EXPECT_EQ(input.state().aperture, 0) << "closed it cannot get narrower";
  Press(input, "o,o");
  EXPECT_NEAR(input.state().aperture, 0.25, 1e-12);
  EXPECT_EQ(input.state().OpenAperture()->focus_in_world, input.state().focus_in_world);
  Press(input, "x");
  EXPECT_FALSE(input.state().OpenAperture());
  Press(input, "x");
  EXPECT_NEAR(input.state().aperture, 0.25, 1e-12) << "as it was";
  Press(input, "i,i");
  EXPECT_EQ(input.state().aperture, 0);
  input.Handle(WheelTurned{2, false, true}, kScreen);
  EXPECT_NEAR(input.state().aperture, 0.25, 1e-12);
  input.Handle(WheelTurned{1000, false, true}, kScreen);
  EXPECT_LT(input.state().aperture, 100);
  // What is in focus stays at its pixel while it goes nearer and farther.
  const Vector3d focus = InCamera(input.state().camera, input.state().focus_in_world);
  Press(input, "j,j,j");
  const Vector3d nearer = InCamera(input.state().camera, input.state().focus_in_world);
  EXPECT_LT(nearer.z(), 0.95 * focus.z());
  EXPECT_LT((nearer.normalized() - focus.normalized()).norm(), 1e-12);
}

TEST(ViewerCamera, LooksAheadAlongItsMovement) {
  const ViewerCamera camera = SomeCamera();
  const ViewerCamera orbiting = Orbited(camera, 0.01, 0.005);
  const auto apart = [](const ViewerCamera& a, const ViewerCamera& b) {
    return (a.eye_in_world - b.eye_in_world).norm();
  };
  const ViewerCamera later = Orbited(camera, 0.06, 0.03);
  EXPECT_LT(apart(Extrapolated(camera, orbiting, 5), later), 0.05 * apart(camera, later));
  EXPECT_NEAR(Extrapolated(camera, orbiting, 5).Distance(), camera.Distance(), 1e-9);
  EXPECT_LT(apart(Extrapolated(camera, MovedIn(camera, 1.02), 4), MovedIn(camera, std::pow(1.02, 5))), 1e-9);
  EXPECT_LT(apart(Extrapolated(camera, Panned(camera, 0.01, 0), 4), Panned(camera, 0.05, 0)), 1e-9);
  // After a jump it stays within sight.
  const ViewerCamera jumped = MovedIn(Orbited(camera, 2, 0), 30);
  EXPECT_LT(Extrapolated(camera, jumped, 10).Distance(), 4.01 * jumped.Distance());
}

TEST(ViewerInput, RequestsAreTakenOnce) {
  ViewerInput input = SomeInput();
  for (const InputEvent& event : KeysFromNames("s,k,n,g,q")) input.Handle(event, kScreen);
  input.Handle(CloseAsked{}, kScreen);
  std::vector<ViewerRequest::What> requests;
  for (const ViewerRequest& request : input.TakeRequests()) requests.push_back(request.what);
  EXPECT_THAT(requests, ::testing::ElementsAre(ViewerRequest::kScreenshot, ViewerRequest::kKeyframe,
                                               ViewerRequest::kNearestView, ViewerRequest::kFullScreen,
                                               ViewerRequest::kLeave, ViewerRequest::kLeave));
  EXPECT_TRUE(input.TakeRequests().empty());
}

}  // namespace
}  // namespace ulf::test::viewer_state_test
