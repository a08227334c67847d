#include "tracking/refine/refine_scene.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/base/quantile.h"
#include "core/geometry/trajectory.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void ReadOne(const ViewReading& reading, int index, const CameraModel& lens, FeatureExtractor& extractor,
             bool first, RefineView& view) {
  Image image = reading.read(index);
  cv::Mat gray = GrayForTracking(image);
  cv::Mat color = image.mosaic == Mosaic::kNone && image.pixels.depth() == CV_8U ? image.pixels : gray;
  if (gray.cols != lens.width || gray.rows != lens.height) {
    cv::resize(gray, gray, {lens.width, lens.height}, 0, 0, cv::INTER_AREA);
    cv::resize(color, color, {lens.width, lens.height}, 0, 0, cv::INTER_AREA);
  }
  view.gray = gray.clone();
  const Pyramid pyramid = BuildPyramid(view.gray);
  if (first) extractor.Extract(pyramid, reading.features);  // the corner threshold settles
  view.features = extractor.Extract(pyramid, reading.features);
  for (const Feature& feature : view.features.all()) {
    const int x = static_cast<int>(feature.img.x()), y = static_cast<int>(feature.img.y());
    if (color.channels() == 3) {
      const cv::Vec3b bgr = color.at<cv::Vec3b>(y, x);
      view.feature_rgb.push_back({bgr[2], bgr[1], bgr[0]});
    } else {
      const std::uint8_t value = gray.at<std::uint8_t>(y, x);
      view.feature_rgb.push_back({value, value, value});
    }
  }
}

}  // namespace

void ForAll(int count, const std::function<void(int)>& work) {
  cv::parallel_for_(
      cv::Range(0, count),
      [&](const cv::Range& range) {
        for (int i = range.start; i < range.end; ++i) work(i);
      },
      count);
}

void ReadViews(const ViewReading& reading, RefineScene& scene) {
  // One extractor serves neighbouring views, whose pictures are alike, whatever the number of threads.
  constexpr int kChunk = 8;
  const int count = static_cast<int>(scene.views.size());
  struct {
    Mutex mutex;
    int done ULF_GUARDED_BY(mutex) = 0;
  } shown;
  ForAll((count + kChunk - 1) / kChunk, [&](int chunk) {
    int lens = -1;
    std::optional<FeatureExtractor> extractor;
    for (int i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      RefineView& view = scene.views[static_cast<std::size_t>(i)];
      const bool first = view.lens != lens;
      if (first) extractor.emplace(scene.LensOf(view));
      lens = view.lens;
      try {
        ReadOne(reading, i, scene.LensOf(view), *extractor, first, view);
      } catch (const std::exception& error) {
        view.registered = false;
        view.why = error.what();
      }
      const MutexLock lock(shown.mutex);
      if (reading.done) reading.done(++shown.done);
    }
  });
}

double ReprojectionErrorPx(const RefineScene& scene, const SceneTrack& track, const TrackObservation& seen) {
  const RefineView& view = scene.view(seen.view);
  const auto img = scene.LensOf(view).ImgFromCam(view.cam_from_world * track.position);
  return img ? (*img - seen.img).norm() : std::numeric_limits<double>::infinity();
}

BundleProblem ToBundle(const RefineScene& scene) {
  BundleProblem problem;
  for (const RefineView& view : scene.views) {
    problem.cam_from_world.push_back(view.cam_from_world);
    problem.lens.push_back(view.lens);
  }
  std::vector<int> seen(scene.views.size(), 0);
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    problem.points.push_back(scene.tracks[t].position);
    for (const TrackObservation& o : scene.tracks[t].observations) {
      problem.observations.push_back({o.view, static_cast<int>(t), o.img, o.sigma_px, false});
      ++seen[static_cast<std::size_t>(o.view)];
    }
  }
  // Of each group the view that sees most holds the world still meanwhile.
  problem.fixed.assign(scene.views.size(), false);
  const ViewGroups groups = GroupViews(scene);
  std::vector<int> most(static_cast<std::size_t>(groups.count), -1);
  for (int v = 0; v < static_cast<int>(seen.size()); ++v) {
    const int group = groups.group[static_cast<std::size_t>(v)];
    if (group < 0) continue;
    int& best = most[static_cast<std::size_t>(group)];
    if (best < 0 || seen[static_cast<std::size_t>(v)] > seen[static_cast<std::size_t>(best)]) best = v;
  }
  for (const int v : most) problem.fixed[static_cast<std::size_t>(v)] = true;
  return problem;
}

void FromBundle(const BundleProblem& problem, int min_views, RefineScene& scene) {
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    scene.views[v].cam_from_world = problem.cam_from_world[v];
  std::size_t next = 0;
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    SceneTrack& track = scene.tracks[t];
    track.position = problem.points[t];
    std::vector<TrackObservation> kept;
    for (const TrackObservation& o : track.observations)
      if (!problem.observations[next++].outlier) kept.push_back(o);
    track.observations = std::move(kept);
  }
  std::erase_if(scene.tracks, [&](const SceneTrack& track) {
    return static_cast<int>(track.observations.size()) < min_views || !track.position.allFinite();
  });
}

void DropSliding(RefineScene& scene) {
  constexpr double kMostTimesUsual = 3;
  std::vector<double> by_track, all;
  for (const SceneTrack& track : scene.tracks) {
    std::vector<double> errors;
    for (const TrackObservation& o : track.observations)
      errors.push_back(ReprojectionErrorPx(scene, track, o) / o.sigma_px);
    all.insert(all.end(), errors.begin(), errors.end());
    by_track.push_back(Median(std::move(errors)));
  }
  const double most = kMostTimesUsual * Median(std::move(all));
  std::vector<SceneTrack> kept;
  for (std::size_t t = 0; t < by_track.size(); ++t)
    if (by_track[t] <= most) kept.push_back(std::move(scene.tracks[t]));
  spdlog::debug("{} of {} points slide", by_track.size() - kept.size(), by_track.size());
  scene.tracks = std::move(kept);
}

ViewGroups GroupViews(const RefineScene& scene) {
  std::vector<int> parent(scene.views.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root_of = [&](int v) {
    while (parent[static_cast<std::size_t>(v)] != v) v = parent[static_cast<std::size_t>(v)];
    return v;
  };
  ViewGroups groups;
  groups.group.assign(scene.views.size(), -1);
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& o : track.observations) {
      const int a = root_of(track.observations.front().view), b = root_of(o.view);
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
      groups.group[static_cast<std::size_t>(o.view)] = 0;
    }
  std::vector<int> number(scene.views.size(), -1);
  for (int v = 0; v < static_cast<int>(scene.views.size()); ++v) {
    int& group = groups.group[static_cast<std::size_t>(v)];
    if (group < 0) continue;
    int& of_root = number[static_cast<std::size_t>(root_of(v))];
    if (of_root < 0) of_root = groups.count++;
    group = of_root;
  }
  return groups;
}

namespace {

// The similarity from where views are to where they started. The scale is the median of how distances between
// centres have changed; the rotation comes from centres and axes together, as far out as the scene is, so
// that it is held even where all centres lie on a line; the middle of the centres stays.
std::optional<Similarity3> ToStart(const std::vector<const RefineView*>& views, double reach) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t j = i + 1; j < views.size(); j += 1 + views.size() / 50) {
      const double now =
          (views[i]->cam_from_world.OriginInSource() - views[j]->cam_from_world.OriginInSource()).norm();
      const double then = (views[i]->start.OriginInSource() - views[j]->start.OriginInSource()).norm();
      if (now > 0 && then > 0) ratios.push_back(then / now);
    }
  const double scale = Median(std::move(ratios));
  if (!(reach > 0) || !(scale > 0)) return std::nullopt;
  std::vector<Vector3d> now, then;
  Vector3d middle_now = Vector3d::Zero(), middle_then = Vector3d::Zero();
  for (const RefineView* view : views) {
    const Vector3d from = view->cam_from_world.OriginInSource(), to = view->start.OriginInSource();
    middle_now += from / static_cast<double>(views.size());
    middle_then += to / static_cast<double>(views.size());
    now.push_back(scale * from);
    then.push_back(to);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d direction = scale * reach * Vector3d::Unit(axis);
      now.push_back(scale * from + view->cam_from_world.DirectionInSource(direction));
      then.push_back(to + view->start.DirectionInSource(direction));
    }
  }
  const auto aligned = AlignPoints(now, then);
  if (!aligned) return std::nullopt;
  return Similarity3{scale, aligned->rotation, middle_then - scale * (aligned->rotation * middle_now)};
}

}  // namespace

bool AlignToStart(RefineScene& scene) {
  const ViewGroups groups = GroupViews(scene);
  for (int group = 0; group < groups.count; ++group) {
    const auto in_group = [&](int v) { return groups.group[static_cast<std::size_t>(v)] == group; };
    std::vector<double> distances;
    for (const SceneTrack& track : scene.tracks)
      if (in_group(track.observations.front().view))
        for (const TrackObservation& o : track.observations)
          distances.push_back((track.position - scene.view(o.view).cam_from_world.OriginInSource()).norm());
    std::vector<const RefineView*> views;
    for (int v = 0; v < static_cast<int>(scene.views.size()); ++v)
      if (in_group(v)) views.push_back(&scene.view(v));
    const auto move = ToStart(views, Median(std::move(distances)));
    if (!move) return false;
    const Eigen::Quaterniond turned(move->rotation);
    for (SceneTrack& track : scene.tracks)
      if (in_group(track.observations.front().view)) track.position = *move * track.position;
    for (int v = 0; v < static_cast<int>(scene.views.size()); ++v) {
      if (!in_group(v)) continue;
      Rigid3& pose = scene.views[static_cast<std::size_t>(v)].cam_from_world;
      const Vector3d center = *move * pose.OriginInSource();
      pose.rotation = (pose.rotation * turned.conjugate()).normalized();
      pose.translation = -(pose.rotation * center);
    }
  }
  return groups.count > 0;
}

}  // namespace ulf::tracking
