// Tests: render/viewer/viewer, render/viewer/viewer_files.
//
// The viewer on a picture without a window: what each switch does to it.
#include "render/viewer/viewer.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <chrono>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/display/surface.h"
#include "render/output/path_files.h"
#include "render/output/picture_files.h"
#include "render/viewer/viewer_files.h"
#include "tests/render/scenes/disc_masks.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::viewer_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const SceneSpec kSpec{
    .viewpoints = GridViewpoints(7, 7, 0.15, 2.0), .width = 192, .height = 144, .focal_px = 160};
constexpr int kMiddleView = 24;

OfferedProxy PlaneAt(const std::string& name, double z) {
  return {name, [z] { return std::make_shared<PlaneProxy>(Subject{{0, 0, z}, 0.3}); }};
}

// Nothing but the picture, until something is switched.
struct Stage {
  explicit Stage(cv::Size size = {192, 144}, std::shared_ptr<const RenderScene> the_scene = MakeScene(kSpec),
                 ViewerOptions options = {})
      : surface(size), scene(std::move(the_scene)), viewer(surface, scene, WithProxies(std::move(options))) {
    Press("t,w");
    Stand(scene->views[kMiddleView].center_in_world);
  }
  static ViewerOptions WithProxies(ViewerOptions options) {
    if (options.proxies.empty()) options.proxies = {PlaneAt("plane", 0), PlaneAt("elsewhere", 1)};
    if (!options.seconds) options.reduces_motion = false;  // whatever this machine takes
    return options;
  }
  cv::Mat Press(const std::string& keys) {
    for (const InputEvent& key : KeysFromNames(keys)) {
      surface.Push(key);
      EXPECT_TRUE(viewer.Step(0));
    }
    return Now();
  }
  cv::Mat Stand(const Vector3d& eye) {
    ViewerCamera camera = viewer.state().camera;
    camera.eye_in_world = eye;
    viewer.Place(camera);
    return Now();
  }
  cv::Mat Now() {
    do EXPECT_TRUE(viewer.Step(0));
    while (viewer.loading());
    surface.Bind();
    return surface.Read();
  }
  OffscreenSurface surface;
  std::shared_ptr<const RenderScene> scene;
  Viewer viewer;
};

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * 3);
}

cv::Scalar ColorOf(const SceneView& view) {
  const cv::Vec3f bgr = ViewColor(view.id);
  return {255.0 * SrgbFromLinear(bgr[0]), 255.0 * SrgbFromLinear(bgr[1]), 255.0 * SrgbFromLinear(bgr[2])};
}

TEST(Viewer, LinearFieldAtAViewpointIsThePhotograph) {
  Stage stage;
  const SceneView& view = stage.scene->views[kMiddleView];
  const cv::Mat photograph = view.Srgb8();
  EXPECT_GT(MeanDifference(stage.Stand(view.center_in_world + Vector3d(0.07, 0.06, 0)), photograph), 1.4);
  stage.Press("2");
  EXPECT_LT(MeanDifference(stage.Press("n"), photograph), 1);
  const cv::Mat field = stage.Press("b");
  EXPECT_LT(MeanDifference(field, cv::Mat(field.size(), CV_8UC3, ColorOf(view))), 1);
  EXPECT_LT(MeanDifference(stage.Press("b"), photograph), 1) << "and back";
}

// Shown without reading back what `ulf render` reads back, the same.
TEST(Viewer, ShowsWhatRenderWrites) {
  Stage stage;
  for (const char* keys : {"Right,Up", "3", "1,p", "o,o,o,o,o", "u,u,u,u", "x,e,e,d"}) {
    const cv::Mat shown = stage.Press(keys);
    const ViewerState& state = stage.viewer.state();
    const auto proxy = state.proxy == 0 ? PlaneAt("", 0).make() : PlaneAt("", 1).make();
    GlRenderer renderer(WithProxy(*stage.scene, proxy),
                        {.field = state.field, .aperture = state.OpenAperture()});
    const Rendering truth =
        renderer.Render(state.camera.ModelFor(stage.surface.Size()), state.camera.CamFromWorld());
    EXPECT_LE(cv::norm(shown, DisplaySrgb8(truth.linear, state.exposure_stops), cv::NORM_INF), 1) << keys;
  }
  EXPECT_EQ(stage.viewer.state().exposure_stops, 0.25);
}

// A lens that is wide open makes what is off its focal plane soft: there, and there only.
TEST(Viewer, ClickFocusesTheApertureOnTheProxy) {
  Stage stage;
  const cv::Mat closed = stage.Stand({0.02, 0.03, 2});
  stage.Press("o,o,o");
  EXPECT_LT(MeanDifference(stage.Now(), closed), 2) << "the subject's centre is on the plane";
  stage.Press("j,j,j,j,j,j,j,j,j,j,j,j,j,j,j,j");
  const cv::Mat soft = stage.Now();
  EXPECT_GT(MeanDifference(soft, closed), 4);
  stage.surface.Push(MouseMoved{{60, 40}});
  stage.surface.Push(MouseButton{0, true});
  stage.surface.Push(MouseButton{0, false});
  EXPECT_LT(MeanDifference(stage.Now(), closed), 2);
  const ViewerCamera& camera = stage.viewer.state().camera;
  EXPECT_NEAR(stage.viewer.state().focus_in_world.dot(camera.eye_in_world.normalized()), 0, 1e-5);
  const auto img = camera.ModelFor(stage.surface.Size())
                       .ImgFromCam(camera.CamFromWorld() * stage.viewer.state().focus_in_world);
  EXPECT_LT((*img - Vector2d(60, 40)).norm(), 1e-3);
}

TEST(Viewer, StripesWhereConfidenceIsLowAndNowhereElse) {
  Stage stage;
  stage.Press("PageUp,PageUp,PageUp,PageUp");
  const cv::Mat plain = stage.Now();
  EXPECT_LT(MeanDifference(stage.Press("c"), plain), 1) << "amid the views";
  const cv::Mat doubtful = stage.Stand({1.2, 0.1, 2});
  EXPECT_GT(MeanDifference(doubtful, stage.Press("c")), 20) << "outside the hull";
}

TEST(Viewer, DrawsWhenSomethingHasChangedAndNotOtherwise) {
  Stage stage;
  stage.Now();
  const int before = stage.viewer.frames();
  for (int i = 0; i < 3; ++i) stage.viewer.Step(0);
  stage.surface.Push(MouseMoved{{20, 30}});
  stage.viewer.Step(0);
  EXPECT_EQ(stage.viewer.frames(), before);
  for (int i = 0; i < 5; ++i) stage.surface.Push(KeyPressed{Key::kLeft});
  stage.viewer.Step(0);
  EXPECT_EQ(stage.viewer.frames(), before + 1) << "what comes together is drawn once";
  stage.surface.Resize({100, 200}, 2);
  stage.viewer.Step(0);
  EXPECT_EQ(stage.viewer.frames(), before + 2);
  stage.surface.Push(KeyPressed{Key::kF11});
  stage.viewer.Step(0);
  EXPECT_TRUE(stage.surface.full_screen());
  stage.surface.Push(CloseAsked{});
  EXPECT_FALSE(stage.viewer.Step(0));
}

// However slow frames are: every look at the clock takes so long.
struct SlowClock {
  double now = 0, seconds_a_look = 0;
};

TEST(Viewer, DrawsSmallerInMotionWhenFramesAreSlow) {
  SlowClock clock;
  ViewerOptions options;
  options.seconds = [&] { return clock.now += clock.seconds_a_look; };
  Stage stage({192, 144}, MakeScene(kSpec), options);
  const cv::Mat full = stage.Press("Left");
  clock.seconds_a_look = 0.05;
  const auto move = [&](Key key) {
    stage.surface.Push(KeyPressed{key});
    stage.viewer.Step(0);
    return stage.viewer.drawn_size();
  };
  for (int i = 0; i < 6; ++i) move(i % 2 ? Key::kLeft : Key::kRight);
  EXPECT_EQ(stage.viewer.drawn_size(), cv::Size(48, 36)) << "a quarter at least";
  clock.seconds_a_look = 0;
  move(Key::kRight);
  move(Key::kLeft);
  const int frames = stage.viewer.frames();
  const auto read = [&] {
    stage.surface.Bind();
    return stage.surface.Read();
  };
  const double apart = MeanDifference(read(), full);
  EXPECT_GT(apart, 0.5);
  EXPECT_LT(apart, 12) << "the same, blurred";
  stage.viewer.Step(0);
  EXPECT_EQ(stage.viewer.frames(), frames) << "it may move on";
  clock.now += 0.25;
  stage.viewer.Step(0);
  EXPECT_EQ(stage.viewer.drawn_size(), cv::Size(192, 144));
  EXPECT_LE(cv::norm(read(), full, cv::NORM_INF), 1);
  EXPECT_EQ(stage.viewer.frames(), frames + 1);
  stage.viewer.Step(0);
  EXPECT_EQ(stage.viewer.frames(), frames + 1);
  for (int i = 0; i < 8; ++i) move(i % 2 ? Key::kLeft : Key::kRight);
  EXPECT_EQ(stage.viewer.drawn_size(), cv::Size(192, 144)) << "it is quick now";
}

// A picture that is kept is never a smaller one.
TEST(Viewer, PicturesToFilesAreInFullWhileItMoves) {
  const ScratchFolder scratch;
  SlowClock clock{.seconds_a_look = 0.05};
  ViewerOptions options;
  options.out = scratch.path();
  options.seconds = [&] { return clock.now += clock.seconds_a_look; };
  Stage stage({192, 144}, MakeScene(kSpec), options);
  for (const Key key : {Key::kLeft, Key::kLeft, Key::kLeft}) {
    stage.surface.Push(KeyPressed{key});
    stage.viewer.Step(0);
  }
  EXPECT_LT(stage.viewer.drawn_size().width, 192);
  stage.surface.Push(Typed{U's'});
  stage.viewer.Step(0);
  clock.now += 1;
  EXPECT_EQ(cv::norm(cv::imread(scratch / "ulf_view_000.png"), stage.Now(), cv::NORM_INF), 0);
}

// Pixels of the colour of warnings in the lower half.
int CarefulPixels(const cv::Mat& screen) {
  cv::Mat mask;
  const cv::Scalar color(ink::kCareful.b, ink::kCareful.g, ink::kCareful.r);
  cv::inRange(screen.rowRange(screen.rows / 2, screen.rows), color - cv::Scalar::all(3),
              color + cv::Scalar::all(3), mask);
  return cv::countNonZero(mask);
}

TEST(Viewer, WarnsOutsideTheRecordedViews) {
  Stage stage({640, 480});
  stage.Press("t");
  EXPECT_EQ(CarefulPixels(stage.Now()), 0);
  EXPECT_GT(CarefulPixels(stage.Stand({1.2, 0, 2})), 30);
  EXPECT_EQ(CarefulPixels(stage.Stand({0.3, 0.2, 2})), 0);
}

TEST(Viewer, TheSphereIsInACornerUntilSwitchedOff) {
  Stage stage({640, 480});
  const cv::Mat without = stage.Now(), with = stage.Press("w");
  cv::Mat changed;
  cv::cvtColor(cv::abs(with - without), changed, cv::COLOR_BGR2GRAY);
  const cv::Rect where = cv::boundingRect(changed > 20);
  EXPECT_GT(where.x, 480) << where;
  EXPECT_LT(where.br().y, 200) << where;
  EXPECT_GT(where.area(), 60 * 60) << where;
}

TEST(Viewer, TheMeshMeetsTheFieldsColours) {
  Stage stage({240, 180});
  stage.Stand({0.02, 0.03, 3.5});
  const cv::Mat field = stage.Press("2,b");
  const cv::Mat with_mesh = stage.Press("m");
  EXPECT_GT(MeanDifference(field, with_mesh), 1);
  const ViewerState& state = stage.viewer.state();
  const SceneView& view = stage.scene->views[kMiddleView];
  const auto img =
      *state.camera.ModelFor({240, 180}).ImgFromCam(state.camera.CamFromWorld() * view.center_in_world);
  const auto at = [&](const cv::Mat& screen) {
    return cv::Scalar(screen.at<cv::Vec3b>(static_cast<int>(img.y()), static_cast<int>(img.x())));
  };
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(at(field)[channel], ColorOf(view)[channel], 25);
    EXPECT_NEAR(at(with_mesh)[channel], ColorOf(view)[channel], 2);
  }
}

TEST(Viewer, UnavailableProxyIsReportedAndTheOldStays) {
  ViewerOptions options;
  int tried = 0;
  options.proxies = {PlaneAt("plane", 0), {"broken", [&]() -> std::shared_ptr<const Proxy> {
                                             ++tried;
                                             throw Error("the mesh is broken");
                                           }}};
  Stage stage({320, 240}, MakeScene(kSpec), options);
  const cv::Mat before = stage.Now();
  EXPECT_LT(MeanDifference(stage.Press("p"), before), 1e-9);
  EXPECT_EQ(stage.viewer.state().proxy, 0);
  stage.Press("Left,Right");
  EXPECT_EQ(tried, 1);
}

// A light field on disk, whose photographs have to be read first.
std::shared_ptr<const RenderScene> SceneOnDisk(const std::filesystem::path& dir, const SceneSpec& spec) {
  WriteLightField(dir, spec, true);
  return LoadScene(ReadLightField(dir), {});
}

TEST(Viewer, DrawsAtOnceAndCompletesThePicture) {
  const ScratchFolder scratch;
  const auto scene = SceneOnDisk(scratch / "lf", kSpec);
  // Several times: the last photograph may come between any two passes of a picture.
  for (int round = 0; round < 8; ++round) {
    Stage stage({192, 144}, scene);
    ViewerCamera camera = stage.viewer.state().camera;
    camera.eye_in_world = {0.2, 0.1, 1.2};  // many views weigh from here, most of them not read yet
    stage.viewer.Place(camera);
    stage.viewer.Step(0);
    EXPECT_TRUE(stage.viewer.loading());
    int steps = 0;
    for (; stage.viewer.loading() && steps < 2000; ++steps) stage.viewer.Step(0.01);
    EXPECT_LT(steps, 2000);
    const cv::Mat shown = stage.Now();
    GlRenderer complete(WithProxy(*scene, PlaneAt("", 0).make()), {});
    const Rendering truth = complete.Render(camera.ModelFor({192, 144}), camera.CamFromWorld());
    EXPECT_LE(cv::norm(shown, DisplaySrgb8(truth.linear, 0), cv::NORM_INF), 1) << round;
  }
}

// What lies ahead is read while the camera moves.
TEST(Viewer, ReadsAheadAlongTheMotion) {
  const ScratchFolder scratch;
  const auto scene =
      SceneOnDisk(scratch / "lf", {.viewpoints = CapViewpoints(80, 0.9, 2.0), .width = 48, .height = 36});
  OffscreenSurface surface({96, 72});
  Viewer viewer(surface, scene, Stage::WithProxies({}));
  const auto complete = [&] {
    do viewer.Step(0);
    while (viewer.loading());
  };
  const ViewerCamera start = Zoomed(viewer.state().camera, 1.5);
  viewer.Place(start);
  const auto decoded = [&] { return scene->store->counts().decoded; };
  const auto wait = [&] {
    std::size_t before = 0;
    for (int calm = 0; calm < 10; calm = decoded() == before ? calm + 1 : 0, before = decoded())
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  };
  complete();
  wait();
  const std::size_t needed = decoded();
  const ViewerCamera next = Orbited(start, 0.02, 0);
  viewer.Place(next);
  complete();
  wait();
  EXPECT_GT(decoded(), needed);
  viewer.Place(Extrapolated(start, next, 10));
  viewer.Step(0);
  EXPECT_FALSE(viewer.loading());
}

TEST(Viewer, KeepsWithinItsGraphicsMemory) {
  ViewerOptions options;
  options.gpu_memory_mb = 1;
  Stage stage({192, 144}, MakeScene(kSpec), options);
  for (const Vector3d& eye : {Vector3d(0.3, 0.3, 1.2), Vector3d(-0.3, 0.2, 1.9), Vector3d(0, 0, 1)}) {
    ViewerCamera camera = stage.viewer.state().camera;
    camera.eye_in_world = eye;
    stage.viewer.Place(camera);
    for (int i = 0; i < 20; ++i) stage.viewer.Step(0);
    EXPECT_LE(stage.viewer.renderer().photograph_counts().most_bytes, 1'000'000u);
  }
}

TEST(Viewer, PicturesAndKeyframesGoToFiles) {
  const ScratchFolder scratch;
  ViewerOptions options;
  options.out = scratch.path();
  Stage stage({320, 240}, MakeScene(kSpec), options);
  const cv::Mat shown = stage.Press("Left,s");
  EXPECT_EQ(cv::norm(cv::imread(scratch / "ulf_view_000.png"), shown, cv::NORM_INF), 0);
  stage.Press("k,Right,Up,PageUp,+,k,s");
  EXPECT_TRUE(std::filesystem::exists(scratch / "ulf_view_001.png"));
  const CameraPath path = PathFromFile(scratch / kKeyframeFile, {.path = "", .fps = 1}, *stage.scene);
  ASSERT_EQ(path.cam_from_world.size(), 3u) << "two keyframes, two seconds apart";
  const ViewerCamera& camera = stage.viewer.state().camera;
  EXPECT_LT((path.cam_from_world.back().OriginInSource() - camera.eye_in_world).norm(), 1e-9);
  EXPECT_LT(RotationAngle(path.cam_from_world.back().rotation * camera.CamFromWorld().rotation.conjugate()),
            1e-6);
  EXPECT_NEAR(path.cameras.back().fx, camera.ModelFor({320, 240}).fx, 1e-6);
  EXPECT_EQ(path.cameras.back().width, 320);
  // An aperture is of all keyframes or of none.
  stage.Press("o,o,k");
  EXPECT_EQ(PathFromFile(scratch / kKeyframeFile, {.path = "", .fps = 1}, *stage.scene).cam_from_world.size(),
            3u);
  std::filesystem::remove(scratch / kKeyframeFile);
  stage.Press("k,u,x,k");
  const CameraPath lens = PathFromFile(scratch / kKeyframeFile, {.path = "", .fps = 0.5}, *stage.scene);
  ASSERT_EQ(lens.apertures.size(), 2u);
  EXPECT_GT(lens.apertures[0].radius, 0.1);
  EXPECT_NEAR(lens.apertures[0].focus_in_world.norm(), 0, 0.05);
  EXPECT_EQ(lens.apertures[1].radius, 0);
  // A file of somebody else's is left alone, and the viewer goes on.
  std::ofstream(scratch / kKeyframeFile) << "{\"frames\": []}";
  stage.Press("k,Left");
  EXPECT_FALSE(std::filesystem::exists(scratch / "ulf_view_002.png"));
  EXPECT_EQ(ReadWholeFile(scratch / kKeyframeFile), "{\"frames\": []}");
}

// What the views' masks leave out is grey, whatever the photographs show there, and the rest is as without
// masks; over another proxy the masks are drawn over it, too.
TEST(Viewer, MaskedPartsAreGrey) {
  constexpr double kDisc = 0.3;
  const std::vector<std::string> keys{"Left", "p", "p,Up"};
  std::vector<cv::Mat> without;
  {
    Stage plain;
    for (const std::string& pressed : keys) without.push_back(plain.Press(pressed));
  }
  ViewerOptions options;
  options.masks = DiscMasks(kSpec, kDisc);
  Stage cut_out({192, 144}, MakeScene(kSpec), options);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const cv::Mat with = cut_out.Press(keys[i]);
    const ViewerState& state = cut_out.viewer.state();
    if (state.proxy == 1) {
      EXPECT_GT(MeanDifference(with, without[i]), 1);
      continue;
    }
    const CameraModel camera = state.camera.ModelFor(with.size());
    const double pixel = 2.0 / camera.fx;
    int inside_px = 0, outside_px = 0;
    for (int y = 0; y < with.rows; ++y)
      for (int x = 0; x < with.cols; ++x) {
        const double inside = InsideDisc(kDisc, camera, state.camera.CamFromWorld(), x, y);
        if (std::abs(inside) < 2 * pixel) continue;
        ++(inside > 0 ? inside_px : outside_px);
        ASSERT_EQ(with.at<cv::Vec3b>(y, x), inside > 0 ? without[i].at<cv::Vec3b>(y, x) : cv::Vec3b::all(64))
            << keys[i] << " " << x << " " << y;
      }
    EXPECT_GT(inside_px, 1000);
    EXPECT_GT(outside_px, 1000);
  }
}

// The middle of a ring is above its axis, where nobody has been.
TEST(StartingCameraTest, StandsAtAViewOfARing) {
  SceneSpec spec = kSpec;
  spec.viewpoints.clear();
  for (int i = 0; i < 24; ++i)
    spec.viewpoints.push_back({1.6 * std::cos(i * M_PI / 12), 1.6 * std::sin(i * M_PI / 12), 1});
  const auto ring = MakeScene(spec), grid = MakeScene(kSpec);
  const auto to_nearest = [](const RenderScene& scene) {
    const Vector3d eye = StartingCamera(scene).eye_in_world;
    double least = 1e9;
    for (const SceneView& view : scene.views) least = std::min(least, (view.center_in_world - eye).norm());
    return least;
  };
  EXPECT_LT(to_nearest(*ring), 1e-9);
  EXPECT_LT(to_nearest(*grid), 0.2);
}

}  // namespace
}  // namespace ulf::test::viewer_test
