// What the stages of tracking one 640x480 frame cost, beside cv::ORB with 1,000 features on the same picture.
#include <benchmark/benchmark.h>

#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>

#include "tests/measure/figures.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/features/matching.h"
#include "tracking/map/frame_locator.h"
#include "tracking/map/map.h"
#include "tracking/map/map_matching.h"
#include "tracking/tracker/tracker.h"

namespace ulf {
namespace {

using test::TexturedRoom;

const cv::Mat& Picture(int frame) {
  static const TexturedRoom room({});
  static std::vector<cv::Mat> made(64);
  cv::Mat& picture = made[static_cast<std::size_t>(frame)];
  if (picture.empty())
    picture = room.Take(TexturedRoom::HandAt(frame), static_cast<std::uint64_t>(frame)).image.pixels;
  return picture;
}

void BM_CvOrb1000(benchmark::State& state) {
  cv::setNumThreads(1);
  const auto orb = cv::ORB::create(1000);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  for ([[maybe_unused]] auto _ : state)
    orb->detectAndCompute(Picture(3), cv::noArray(), keypoints, descriptors);
}
BENCHMARK(BM_CvOrb1000)->Unit(benchmark::kMillisecond);

void BM_Pyramid(benchmark::State& state) {
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(BuildPyramid(Picture(3)));
}
BENCHMARK(BM_Pyramid)->Unit(benchmark::kMillisecond);

void BM_Features(benchmark::State& state) {
  FeatureExtractor extractor(TexturedRoom::Camera());
  const Pyramid pyramid = BuildPyramid(Picture(3));
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(extractor.Extract(pyramid, static_cast<int>(state.range(0))));
}
BENCHMARK(BM_Features)->Arg(1000)->Arg(2000)->Unit(benchmark::kMillisecond);

void BM_MatchAll1000x1000(benchmark::State& state) {
  FeatureExtractor extractor(TexturedRoom::Camera());
  const FeatureSet first = extractor.Extract(BuildPyramid(Picture(3)), 1000);
  const FeatureSet second = extractor.Extract(BuildPyramid(Picture(6)), 1000);
  std::vector<int> a(static_cast<std::size_t>(first.size())), b(static_cast<std::size_t>(second.size()));
  for (int i = 0; i < first.size(); ++i) a[static_cast<std::size_t>(i)] = i;
  for (int i = 0; i < second.size(); ++i) b[static_cast<std::size_t>(i)] = i;
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(MatchAll(first, a, second, b));
}
BENCHMARK(BM_MatchAll1000x1000)->Unit(benchmark::kMillisecond);

void BM_AlignPatch(benchmark::State& state) {
  const CameraModel camera = TexturedRoom::Camera();
  const Pyramid pyramid = BuildPyramid(Picture(3));
  FeatureExtractor extractor(camera);
  const FeatureSet features = extractor.Extract(pyramid, 500);
  struct Job {
    ReferencePatch patch;
    PatchAxes axes;
    Feature feature;
  };
  std::vector<Job> jobs;
  for (const Feature& feature : features.all()) {
    const auto patch = CutPatch(pyramid, feature.img, feature.level);
    const auto axes = AxesOf(camera, Rigid3{}, feature.ray, feature.level);
    if (patch && axes) jobs.push_back({*patch, *axes, feature});
  }
  std::size_t next = 0;
  for ([[maybe_unused]] auto _ : state) {
    const Job& job = jobs[next++ % jobs.size()];
    benchmark::DoNotOptimize(AlignPatch(camera, job.patch, job.axes, job.feature.ray, Rigid3{}, pyramid,
                                        job.feature.img + Eigen::Vector2d(0.7, -0.4)));
  }
}
BENCHMARK(BM_AlignPatch)->Unit(benchmark::kMicrosecond);

// What a frame reads out of the map, of which it sees 400 points however large it is.
void BM_GatherCandidatesNear(benchmark::State& state) {
  const CameraModel camera = TexturedRoom::Camera();
  Map map(camera);
  constexpr int kSeen = 400;
  const int points = static_cast<int>(state.range(0));
  std::vector<Feature> features(kSeen);
  Keyframe keyframe;
  keyframe.features = std::make_shared<const FeatureSet>(features, camera.width, camera.height);
  map.AddKeyframe(std::move(keyframe));
  std::unordered_map<int, Eigen::Vector2d> seen_before;
  for (int k = 0; k < points; ++k) {
    const bool seen = k < kSeen;
    MapPoint& point = map.point(map.AddPoint({seen ? 0.002 * (k - kSeen / 2) : 10.0 + k, 0, 3}));
    point.mean_direction = Eigen::Vector3d::UnitZ();
    point.reference_distance = point.farthest = 10;
    if (!seen) continue;
    map.AddObservation(point.id, {0, k, Eigen::Vector2d(0, 0), 1});
    seen_before.emplace(point.id, Eigen::Vector2d(0, 0));
  }
  int sweep = 0;
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(GatherCandidatesNear(map, camera, Rigid3{}, seen_before, sweep));
}
BENCHMARK(BM_GatherCandidatesNear)->Arg(4000)->Arg(40000)->Arg(400000)->Unit(benchmark::kMicrosecond);

void BM_RefinePose(benchmark::State& state) {
  const auto scene = test::MakeAbsoluteScene(static_cast<int>(state.range(0)), 0.5, 0.1, 1);
  Eigen::Matrix<double, 6, 1> twist;
  twist << 0.003, -0.002, 0.001, 0.004, -0.003, 0.005;
  const Rigid3 start = Perturbed(scene.cam_from_world, twist);
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(RefinePose(test::SceneCamera(), scene.matches, start));
}
BENCHMARK(BM_RefinePose)->Arg(400)->Unit(benchmark::kMillisecond);

void BM_AbsolutePose(benchmark::State& state) {
  const auto scene = test::MakeAbsoluteScene(300, 1, 0.01 * static_cast<double>(state.range(0)), 1);
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(AbsolutePose(test::SceneCamera(), scene.matches, {.max_iterations = 2000}));
}
BENCHMARK(BM_AbsolutePose)
    ->ArgName("outliers_percent")
    ->Arg(0)
    ->Arg(50)
    ->Arg(80)
    ->Unit(benchmark::kMillisecond);

void BM_RelativePose(benchmark::State& state) {
  const auto scene = test::MakeRelativeScene(700, test::Shape::kDeep, 0.8, 0.3, 0.2, 1);
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(RelativePose(scene.pairs, {.focal_px = 525}));
}
BENCHMARK(BM_RelativePose)->Unit(benchmark::kMillisecond);

// Tracking CPU without mapping, over frames of a map that stands, and cv::ORB's on the same pictures.
void BM_TrackedFrame(benchmark::State& state) {
  cv::setNumThreads(1);
  const auto orb = cv::ORB::create(1000);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors, picture;
  Tracker tracker(TexturedRoom::Camera(), {.deterministic = true});
  int k = 0;
  const auto step = [&] {
    Frame frame;
    const int phase = k % 126;
    frame.image.pixels = picture = Picture(phase < 63 ? phase : 126 - phase);
    frame.id = static_cast<std::uint64_t>(k);
    frame.device_time_s = k++ / 30.0;
    return tracker.Step(frame);
  };
  while (k < 126) step();
  std::vector<double> frame_s, orb_s;
  for ([[maybe_unused]] auto _ : state) {
    frame_s.push_back(step().cpu_s);
    state.SetIterationTime(frame_s.back());
    const double start_s = ThreadCpuSeconds();
    orb->detectAndCompute(picture, cv::noArray(), keypoints, descriptors);
    orb_s.push_back(ThreadCpuSeconds() - start_s);
  }
  state.counters["orb_over_frame"] = Median(orb_s) / Median(frame_s);
}
BENCHMARK(BM_TrackedFrame)->UseManualTime()->MinTime(2)->Unit(benchmark::kMillisecond);

// A map of a thousand keyframes: a hundred rooms far from each other, ten pictures of each.
struct LargeMap {
  static constexpr int kRooms = 100, kPictures = 10;
  CameraModel camera = TexturedRoom::Camera();
  OwnedMap owned{Map(camera)};
  SharedMap& shared = owned.shared;
  KeyframeIndex index{1};
  std::vector<std::shared_ptr<const Pyramid>> lost;  // pictures of some rooms that are not in the map
  std::vector<std::shared_ptr<const FeatureSet>> lost_features;

  LargeMap() {
    FeatureExtractor extractor(camera);
    for (int r = 0; r < kRooms; ++r) {
      const TexturedRoom room({.seed = static_cast<unsigned>(r + 1)});
      Rigid3 pose;
      pose.translation.x() = -100.0 * r;
      std::vector<int> points;  // of the room, by the first picture's feature
      std::shared_ptr<const FeatureSet> first;
      for (int k = 0; k <= kPictures; ++k) {
        const Frame frame = room.Take(Rigid3{}, static_cast<std::uint64_t>(k));
        auto pyramid = std::make_shared<const Pyramid>(BuildPyramid(frame.image.pixels));
        auto features = std::make_shared<const FeatureSet>(extractor.Extract(*pyramid, 1000));
        if (k == kPictures) {
          if (r % 10 == 0) lost.push_back(pyramid), lost_features.push_back(features);
          break;
        }
        AddKeyframe(pose, features, first, points);
        if (!first) first = features;
      }
      for (const int point : points) owned.map.Update(point);
    }
    for (const Keyframe& keyframe : shared.map.keyframes()) index.Add(keyframe);
    for (const MapPoint& point : shared.map.points())
      owned.map.point(point.id).found = owned.map.point(point.id).expected = 10;
  }

  void AddKeyframe(const Rigid3& pose, const std::shared_ptr<const FeatureSet>& features,
                   const std::shared_ptr<const FeatureSet>& first, std::vector<int>& points)
      ULF_REQUIRES(owned.shared.mutex) {
    Map& map = owned.map;
    Keyframe keyframe;
    keyframe.cam_from_world = pose;
    keyframe.features = features;
    const int id = map.AddKeyframe(std::move(keyframe));
    constexpr double kDistance = 2.5;
    for (int i = 0; i < features->size(); ++i) {
      const Feature& feature = (*features)[i];
      int point = -1;
      if (!first) {
        points.push_back(point = map.AddPoint(pose.Inverse() * (kDistance * feature.ray)));
      } else {
        first->ForEachNear(feature.img, 1.5, feature.level, feature.level, [&](int j) {
          if (Distance(feature.descriptor, (*first)[j].descriptor) < kSureDistance)
            point = points[static_cast<std::size_t>(j)];
        });
      }
      if (point >= 0) map.AddObservation(point, {id, i, feature.img, 1});
    }
  }
};

void BM_RelocalizeAmong1000Keyframes(benchmark::State& state) {
  cv::setNumThreads(1);
  const LargeMap large;
  const FrameLocator locator(large.camera, large.shared, 1000);
  std::size_t next = 0, found = 0, asked = 0;
  const double start_s = ThreadCpuSeconds();
  for ([[maybe_unused]] auto _ : state) {
    const std::size_t i = next++ % large.lost.size();
    const TrackedImage image{0, large.lost[i], large.lost_features[i]};
    const auto located = locator.Find(image, large.index, 1);
    ++asked;
    found +=
        located && std::abs(located->cam_from_world.translation.x() + 1000.0 * static_cast<double>(i)) < 0.1;
  }
  state.counters["a_second"] = static_cast<double>(asked) / (ThreadCpuSeconds() - start_s);
  state.counters["points"] = large.shared.ReadByOwner().LivingPoints();
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(std::max<std::size_t>(1, asked));
}
BENCHMARK(BM_RelocalizeAmong1000Keyframes)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  return ulf::RunBenchmarks(
      argc, argv,
      {{"BM_TrackedFrame", "orb_over_frame", 1 / 1.3, "CPU of cv::ORB with 1,000 features / of a frame"},
       {"BM_RelocalizeAmong1000Keyframes", "a_second", 10, "cameras found again in a second"},
       {"BM_RelocalizeAmong1000Keyframes", "found", 1, "share of them that was right"}});
}
