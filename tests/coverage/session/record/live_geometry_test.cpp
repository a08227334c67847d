// Tests: coverage/session/record/live_geometry.
//
// Depth maps and meshes that are made beside a capture: right, within their share, and no harm
// when they fail.
#include "coverage/session/record/live_geometry.h"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "render/proxy/depth_raster.h"
#include "render/proxy/mesh_file.h"
#include "tests/support/floors.h"
#include "tests/support/test_run.h"

namespace ulf::live_geometry_test {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const SimulatedCamera& Studio() {
  static const SimulatedCamera camera = [] {
    SimulationOptions options;
    options.width = 160;
    options.height = 120;
    return SimulatedCamera(options);
  }();
  return camera;
}

// Five rows of six views, four degrees apart.
const std::vector<Rigid3>& Poses() {
  static const std::vector<Rigid3> poses = [] {
    std::vector<Rigid3> grid;
    const Vector3d center = Studio().scene().subject().center_in_world;
    for (int row = 0; row < 5; ++row)
      for (int column = 0; column < 6; ++column) {
        const double azimuth = Radians(4) * (column - 2.5), elevation = Radians(33 + 4 * (row - 2));
        const Vector3d direction(std::cos(elevation) * std::sin(azimuth),
                                 -std::cos(elevation) * std::cos(azimuth), std::sin(elevation));
        grid.push_back(LookAt(center + 0.8 * direction, center, Vector3d::UnitZ()));
      }
    return grid;
  }();
  return poses;
}

// What the camera sees from a pose, kept: every test asks for all of them.
cv::Mat PictureOf(std::size_t pose) {
  static const std::vector<cv::Mat> pictures = [] {
    std::vector<cv::Mat> seen;
    for (const Rigid3& cam_from_world : Poses()) seen.push_back(Studio().CleanSrgb(cam_from_world));
    return seen;
  }();
  return pictures[pose].clone();
}

LiveGeometry::Options Small(bool threaded) {
  LiveGeometry::Options options;
  options.growing.size_px = 160;
  options.growing.least_apart = Radians(5);
  options.first_mesh_maps = 4;
  options.threaded = threaded;
  options.finish_s *= test::kPatience;
  options.gives_way = false;  // on a busy machine these tests would wait for minutes
  return options;
}

void AddAll(LiveGeometry& geometry) {
  for (std::size_t i = 0; i < Poses().size(); ++i)
    geometry.AddView(
        static_cast<int>(i), [i] { return PictureOf(i); }, Studio().camera(), Poses()[i]);
}

// As if the whole world had moved.
std::map<int, Rigid3> MovedPoses(const Vector3d& moved) {
  std::map<int, Rigid3> poses;
  for (std::size_t i = 0; i < Poses().size(); ++i) {
    Rigid3 pose = Poses()[i];
    pose.translation -= pose.rotation * moved;
    poses[static_cast<int>(i)] = pose;
  }
  return poses;
}

// Returns the geometry of all views, made at the end without a thread.
const FinishedGeometry& OfAllViews() {
  static const FinishedGeometry finished = [] {
    LiveGeometry geometry(Small(false));
    geometry.SetSubject(Studio().scene().subject());
    AddAll(geometry);
    return geometry.Finish();
  }();
  return finished;
}

Vector3d MiddleOf(const LiveMesh& mesh) {
  Vector3d middle = Vector3d::Zero();
  for (const Eigen::Vector3f& vertex : mesh.mesh->vertices) middle += vertex.cast<double>();
  return middle / static_cast<double>(mesh.mesh->vertices.size());
}

template <typename Condition>
bool ComesTrue(const Condition& condition, double within_s = 120) {
  const auto start = std::chrono::steady_clock::now();
  while (!condition() && SecondsSince(start) < within_s)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return condition();
}

TEST(LiveGeometry, MapsAndAMeshAreThereBeforeTheEnd) {
  LiveGeometry geometry(Small(true));
  geometry.SetSubject(Studio().scene().subject());
  AddAll(geometry);
  EXPECT_TRUE(ComesTrue([&] { return geometry.State().mesh != nullptr; }));
  EXPECT_EQ(geometry.State().views, static_cast<int>(Poses().size()));
  EXPECT_GE(geometry.State().maps, 4);
  EXPECT_GT(geometry.State().processor_s, 0);

  const FinishedGeometry finished = geometry.Finish();
  EXPECT_EQ(geometry.TakeProblem(), std::nullopt);
  ASSERT_TRUE(finished.mesh);
  EXPECT_GE(finished.maps, finished.mesh->maps);
  EXPECT_EQ(finished.missing_maps, 0);
  const CameraModel camera = Studio().camera().WithoutDistortion();
  const Rigid3& pose = Poses()[14];
  const cv::Mat inverse = DrawInverseDepth(*finished.mesh->mesh, camera, pose);
  std::vector<double> errors;
  for (int y = 10; y < 110; y += 2)
    for (int x = 10; x < 150; x += 2) {
      const auto ray = camera.RayFromImg({x + 0.5, y + 0.5});
      const double depth = Studio().scene().DepthAlong(pose.OriginInSource(), pose.DirectionInSource(*ray)) *
                           ray->normalized().z();
      if (inverse.at<float>(y, x) > 0)
        errors.push_back(std::abs(static_cast<double>(inverse.at<float>(y, x)) * depth - 1));
    }
  EXPECT_GT(errors.size(), 2500u) << "of 3,500";
  EXPECT_LT(Quantile(errors, 0.5), 0.01);
  EXPECT_EQ(static_cast<int>(finished.maps_for_rendering.size()), finished.maps);
}

TEST(LiveGeometry, IsRepeatableWithoutAThread) {
  const auto mesh = [] {
    LiveGeometry geometry(Small(false));
    AddAll(geometry);
    geometry.SetSubject(Studio().scene().subject());
    EXPECT_EQ(geometry.State().maps, 0) << "nothing is made before the end";
    const FinishedGeometry finished = geometry.Finish();
    return finished.mesh ? MeshPlyBytes(*finished.mesh->mesh) : std::string();
  };
  const std::string once = mesh();
  EXPECT_GT(once.size(), 10000u);
  EXPECT_TRUE(once == mesh());
}

// From the end of one map to the end of another: the thread's processor time, which does not depend on what
// others take, by the time that passed, which they make longer.
// Without a subject none can be made.
TEST(LiveGeometry, GoesOnFromMapsThatWereMadeBefore) {
  const FinishedGeometry& finished = OfAllViews();
  ASSERT_GE(finished.maps, 4);
  std::vector<KnownMap> known;
  for (const auto& [id, map] : finished.maps_for_rendering) {
    cv::Mat inverse;
    map.inverse_depth.convertTo(inverse, CV_32F, map.unit);
    known.push_back({id, map.camera, 1 / inverse, map.step});
  }
  known.push_back({1000, known.front().camera, known.front().depth, known.front().plane_step});  // of no view
  LiveGeometry geometry(Small(true));
  AddAll(geometry);
  geometry.AddMaps([known] { return known; });
  EXPECT_TRUE(ComesTrue([&] { return geometry.State().maps == finished.maps; }));
  geometry.SetSubject(Studio().scene().subject());
  const FinishedGeometry again = geometry.Finish();
  EXPECT_GE(again.maps, finished.maps);
  ASSERT_TRUE(again.mesh);
  EXPECT_GT(again.mesh->mesh->triangles.size(), finished.mesh->mesh->triangles.size() / 2);
  EXPECT_EQ(geometry.TakeProblem(), std::nullopt);
}

TEST(LiveGeometry, TakesNoMoreThanItsShareOfAProcessor) {
  LiveGeometry::Options options = Small(true);
  options.processor_share = 0.1;
  options.growing.least_apart = Radians(1);
  options.first_mesh_maps = 1000;  // maps alone: each takes about a tenth of a second
  LiveGeometry geometry(options);
  geometry.SetSubject(Studio().scene().subject());
  AddAll(geometry);
  ASSERT_TRUE(ComesTrue([&] { return geometry.State().maps > 1; }));
  const auto start = std::chrono::steady_clock::now();
  const LiveGeometryState before = geometry.State();
  constexpr int kMaps = 8;
  ASSERT_TRUE(ComesTrue([&] { return geometry.State().maps >= before.maps + kMaps; }));
  const double took_s = geometry.State().processor_s - before.processor_s;
  EXPECT_GT(took_s, 0);
  EXPECT_LT(took_s, 1.5 * options.processor_share * SecondsSince(start));
}

// By a correction that moves the whole world, long before there are enough maps for another mesh. Afterwards
// nothing is left to do.
TEST(LiveGeometry, MeshFollowsPosesDuringTheCapture) {
  LiveGeometry::Options options = Small(true);
  options.more_maps = 100;
  options.between_meshes_s = 0.1;
  LiveGeometry geometry(options);
  geometry.SetSubject(Studio().scene().subject());
  AddAll(geometry);
  ASSERT_TRUE(ComesTrue([&] { return geometry.State().mesh != nullptr; }));
  const Vector3d before = MiddleOf(*geometry.State().mesh), moved(0.5, -0.2, 0.1);
  Subject subject = Studio().scene().subject();
  subject.center_in_world += moved;
  geometry.SetSubject(subject);
  geometry.MoveViews(MovedPoses(moved));
  EXPECT_TRUE(ComesTrue([&] {
    return (MiddleOf(*geometry.State().mesh) - before - moved).norm() < 0.1;  // of more maps by now
  }));
  double processor_s = -1;
  EXPECT_TRUE(ComesTrue([&] {
    std::this_thread::sleep_for(std::chrono::seconds(1));
    return std::exchange(processor_s, geometry.State().processor_s) == geometry.State().processor_s;
  }));
}

TEST(LiveGeometry, CorrectionOfATenthOfAPixelMakesNoMesh) {
  LiveGeometry geometry(Small(false));
  geometry.SetSubject(Studio().scene().subject());
  AddAll(geometry);
  geometry.WorkNow();
  const auto mesh = geometry.State().mesh;
  ASSERT_TRUE(mesh);
  geometry.MoveViews(MovedPoses({0.0003, 0, 0}));
  geometry.WorkNow();
  EXPECT_EQ(geometry.State().mesh, mesh);
  geometry.MoveViews(MovedPoses({0.01, 0, 0}));
  geometry.WorkNow();
  EXPECT_NE(geometry.State().mesh, mesh);
}

TEST(LiveGeometry, TakenBackViewsLeaveTheMeshAtOnce) {
  LiveGeometry::Options options = Small(true);
  options.more_maps = 100;
  options.between_meshes_s = 0.1;
  options.growing.views_waited_for = 0;
  LiveGeometry geometry(options);
  geometry.SetSubject(Studio().scene().subject());
  AddAll(geometry);
  ASSERT_TRUE(ComesTrue([&] { return geometry.State().mesh && geometry.State().maps >= 8; }));
  const auto before = geometry.State().mesh;
  for (int id = 0; id < 18; ++id) geometry.RemoveView(id);
  ASSERT_TRUE(ComesTrue([&] { return geometry.State().mesh != before; }));
  ASSERT_TRUE(geometry.State().mesh);
  EXPECT_LE(geometry.State().mesh->maps, 12);
}

TEST(LiveGeometry, ViewThatWasTakenBackGivesNoGeometry) {
  LiveGeometry geometry(Small(false));
  geometry.SetSubject(Studio().scene().subject());
  AddAll(geometry);
  for (int id = 0; id < static_cast<int>(Poses().size()) - 1; ++id) geometry.RemoveView(id);
  const FinishedGeometry finished = geometry.Finish();
  EXPECT_EQ(finished.maps, 0);
  EXPECT_FALSE(finished.mesh);
  EXPECT_TRUE(finished.maps_for_rendering.empty());
}

TEST(LiveGeometry, ViewsThatMovedMoveTheMesh) {
  const auto middle_of_mesh = [](const Vector3d& moved) {
    LiveGeometry geometry(Small(false));
    Subject subject = Studio().scene().subject();
    subject.center_in_world += moved;
    geometry.SetSubject(subject);
    AddAll(geometry);
    geometry.MoveViews(MovedPoses(moved));
    const FinishedGeometry finished = geometry.Finish();
    return finished.mesh ? MiddleOf(*finished.mesh) : Vector3d(Vector3d::Zero());
  };
  const Vector3d moved(0.5, -0.2, 0.1);
  ASSERT_TRUE(OfAllViews().mesh);
  EXPECT_LT((middle_of_mesh(moved) - MiddleOf(*OfAllViews().mesh) - moved).norm(), 0.01);
}

// Pictures of a lens that is 15 % too long show everything farther away.
TEST(LiveGeometry, StartsAgainUnderAnotherLens) {
  const auto add = [](LiveGeometry& geometry, double factor) {
    CameraModel lens = Studio().camera();
    lens.fx *= factor, lens.fy *= factor;
    for (std::size_t i = 0; i < Poses().size(); ++i)
      geometry.AddView(
          static_cast<int>(i), [i] { return PictureOf(i); }, lens, Poses()[i]);
  };
  for (const bool threaded : {false, true}) {
    LiveGeometry geometry(Small(threaded));
    geometry.SetSubject(Studio().scene().subject());
    add(geometry, 1.15);
    const auto has_mesh = [&] {
      if (!threaded) geometry.WorkNow();
      return geometry.State().mesh != nullptr;
    };
    ASSERT_TRUE(ComesTrue(has_mesh));
    const Vector3d too_far = MiddleOf(*geometry.State().mesh);
    geometry.StartAgain();
    add(geometry, 1);
    EXPECT_FALSE(threaded && geometry.State().mesh && geometry.State().mesh->lens == 0)
        << "the mesh of before is gone at once";
    const FinishedGeometry finished = geometry.Finish();
    ASSERT_TRUE(finished.mesh);
    const FinishedGeometry& expected = OfAllViews();
    ASSERT_TRUE(expected.mesh);
    EXPECT_LT((MiddleOf(*finished.mesh) - MiddleOf(*expected.mesh)).norm(), 0.004);
    EXPECT_GT((too_far - MiddleOf(*expected.mesh)).norm(), 0.01);
    EXPECT_TRUE(geometry.IsCorrected());
  }
}

// The others make the geometry all the same.
// Its picture may be moved away before the thread has read it: nothing that anybody lost.
TEST(LiveGeometry, TakenBackViewsPictureIsNotMissed) {
  LiveGeometry geometry(Small(false));
  geometry.SetSubject(Studio().scene().subject());
  const auto add = [&](int id) {
    geometry.AddView(
        id, []() -> cv::Mat { throw ulf::Error("the image is missing"); }, Studio().camera(), Poses()[0]);
  };
  add(1000);
  geometry.RemoveView(1000);
  EXPECT_EQ(geometry.TakeProblem(), std::nullopt);
  add(1001);
  EXPECT_THAT(geometry.TakeProblem(), testing::Optional(HasSubstr("without view 1001")));
}

TEST(LiveGeometry, UnreadablePictureIsReportedOnce) {
  LiveGeometry geometry(Small(true));
  geometry.SetSubject(Studio().scene().subject());
  for (int id = 1000; id < 1003; ++id)
    geometry.AddView(
        id, []() -> cv::Mat { throw ulf::Error("view 000003.tif: cut short"); }, Studio().camera(),
        Poses()[0]);
  AddAll(geometry);
  std::optional<std::string> problem;
  EXPECT_TRUE(ComesTrue([&] {
    if (!problem) problem = geometry.TakeProblem();
    return problem.has_value();
  }));
  geometry.RemoveView(1001);
  const FinishedGeometry finished = geometry.Finish();
  EXPECT_TRUE(finished.mesh);
  EXPECT_THAT(finished.unreadable_views, ElementsAre(1000, 1002)) << "1001 was taken back";
  ASSERT_TRUE(problem);
  EXPECT_THAT(*problem, HasSubstr("000003.tif"));
  EXPECT_THAT(*problem, HasSubstr("without view 1000"));
  EXPECT_FALSE(geometry.TakeProblem()) << "once";
}

// A machine with no time for geometry at all: what is missing is counted, and the maps that are
// there make a mesh.
TEST(LiveGeometry, CountsWorkThatTimeDidNotAllow) {
  LiveGeometry::Options options = Small(true);
  options.processor_share = 1e-6;
  options.finish_s = 0;
  LiveGeometry geometry(options);
  geometry.SetSubject(Studio().scene().subject());
  AddAll(geometry);
  const FinishedGeometry finished = geometry.Finish();
  EXPECT_GT(finished.missing_maps + static_cast<int>(finished.views_left_out.size()), 2);
  EXPECT_LT(finished.seconds, 30);
}

TEST(LiveGeometry, WithoutASubjectThereIsNoMesh) {
  LiveGeometry geometry(Small(true));
  AddAll(geometry);
  EXPECT_FALSE(geometry.Finish().mesh);
}

// A picture that the thread cannot get done with, as a thread that gets no processor: Finish()
// does without it.
class Stuck {
 public:
  ~Stuck() { Release(); }
  void Release() { released_.store(true); }
  bool is_reached() const { return calls_ > 0; }
  cv::Mat Picture(std::size_t pose) {
    if (calls_++ == 0)
      while (!released_) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return PictureOf(pose);
  }

 private:
  std::atomic<bool> released_ = false;
  std::atomic<int> calls_ = 0;
};

TEST(LiveGeometry, FinishesWhenItsThreadGetsNoProcessor) {
  LiveGeometry geometry(Small(true));
  Stuck stuck;  // released before the thread is waited for
  geometry.SetSubject(Studio().scene().subject());
  geometry.AddView(
      0, [&stuck] { return stuck.Picture(0); }, Studio().camera(), Poses()[0]);
  ASSERT_TRUE(ComesTrue([&] {
    geometry.State();  // hands over what could not be handed over before
    return stuck.is_reached();
  }));
  AddAll(geometry);
  const FinishedGeometry finished = geometry.Finish();
  EXPECT_TRUE(finished.mesh) << "all views, the one that the thread did not get done with among them";
  EXPECT_THAT(finished.views_left_out, IsEmpty());
  EXPECT_LT(finished.seconds, 30);
}

// The machine has no time for geometry: pictures in memory wait in no number, those on the disk do.
TEST(LiveGeometry, PicturesInMemoryThatWaitAreFew) {
  LiveGeometry::Options options = Small(true);
  options.most_waiting = 3;
  options.light_field = "my vase";
  LiveGeometry geometry(options);
  Stuck stuck;
  geometry.SetSubject(Studio().scene().subject());
  geometry.AddView(
      99, [&stuck] { return stuck.Picture(0); }, Studio().camera(), Poses()[0]);
  ASSERT_TRUE(ComesTrue([&] {
    geometry.State();  // hands over what could not be handed over before
    return stuck.is_reached();
  }));
  const auto held = std::make_shared<int>();
  const auto add = [&](int id, LiveGeometry::Picture where) {
    const std::size_t pose = static_cast<std::size_t>(id);
    geometry.AddView(
        id, [pose, held] { return PictureOf(pose); }, Studio().camera(), Poses()[pose], where);
  };
  for (int id = 0; id < 10; ++id) add(id, LiveGeometry::Picture::kIsHeld);
  EXPECT_LE(held.use_count(), 1 + 3);
  const auto problem = geometry.TakeProblem();
  ASSERT_TRUE(problem);
  EXPECT_THAT(*problem, HasSubstr("view 3 is left out, and so is every view that comes while 3 others wait"));
  EXPECT_THAT(*problem, HasSubstr("'ulf proxy \"my vase\"' makes a mesh of all"));
  EXPECT_FALSE(geometry.TakeProblem()) << "once";
  for (int id = 10; id < 20; ++id) add(id, LiveGeometry::Picture::kIsRead);
  geometry.RemoveView(3);
  stuck.Release();
  ASSERT_TRUE(ComesTrue([&] { return geometry.State().views == 1 + 3 + 10; }));
  for (int id = 20; id < 22; ++id) add(id, LiveGeometry::Picture::kIsHeld);
  EXPECT_TRUE(ComesTrue([&] { return geometry.State().views == 1 + 3 + 10 + 2; })) << "there is room again";
  const FinishedGeometry finished = geometry.Finish();
  EXPECT_THAT(finished.views_left_out, ElementsAre(4, 5, 6, 7, 8, 9)) << "3 was taken back";
  EXPECT_TRUE(finished.mesh);
}

TEST(LiveGeometry, EndsAtOnceWhenItIsDropped) {
  auto dropped = std::chrono::steady_clock::now();
  {
    LiveGeometry::Options options = Small(true);
    options.processor_share = 0.001;  // rests for minutes between two maps
    LiveGeometry geometry(options);
    geometry.SetSubject(Studio().scene().subject());
    AddAll(geometry);
    EXPECT_TRUE(ComesTrue([&] { return geometry.State().maps > 0; }));
    dropped = std::chrono::steady_clock::now();
  }
  EXPECT_LT(SecondsSince(dropped), 10);
}

}  // namespace
}  // namespace ulf::live_geometry_test
