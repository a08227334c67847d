#include "tracking/refine/refine_scene.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/similarity3.h"

namespace ulf::tracking {

using Eigen::Vector3d;

int RefineScene::Registered() const {
  return static_cast<int>(
      std::ranges::count_if(views, [](const RefineView& view) { return view.registered; }));
}

std::vector<int> RefineScene::LongestFirst() const {
  std::vector<int> order(tracks.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) {
    return tracks[At(a)].observations.size() > tracks[At(b)].observations.size();
  });
  return order;
}

void RefineScene::DropShortTracks(int min_views) {
  std::erase_if(tracks, [&](const SceneTrack& track) { return track.observations.size() < At(min_views); });
}

double GivenByWorking(const CameraModel& given, const CameraModel& working) {
  return static_cast<double>(given.width + given.height) / (working.width + working.height);
}

std::vector<int> PointsByView(const RefineScene& scene) {
  std::vector<int> count(scene.views.size(), 0);
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& o : track.observations) ++count[At(o.view)];
  return count;
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
      ++seen[At(o.view)];
    }
  }
  // In each group the view with most observations is fixed, because images leave the world open.
  problem.fixed.assign(scene.views.size(), false);
  const ViewGroups groups = GroupViews(scene);
  std::vector<int> most(At(groups.count), -1);
  for (int v = 0; v < static_cast<int>(seen.size()); ++v) {
    const int group = groups.group[At(v)];
    if (group < 0) continue;
    int& best = most[At(group)];
    if (best < 0 || seen[At(v)] > seen[At(best)]) best = v;
  }
  for (const int v : most) problem.fixed[At(v)] = true;
  return problem;
}

void FromBundle(const BundleProblem& problem, int min_views, RefineScene& scene) {
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    scene.views[v].cam_from_world = problem.cam_from_world[v];
  std::size_t next = 0;
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    SceneTrack& track = scene.tracks[t];
    track.position = problem.points[t];
    std::erase_if(track.observations,
                  [&](const TrackObservation&) { return problem.observations[next++].outlier; });
    if (!track.position.allFinite()) track.observations.clear();
  }
  scene.DropShortTracks(min_views);
}

void DropSlidingPoints(RefineScene& scene, double most_times_usual) {
  std::vector<double> by_track, all;
  for (const SceneTrack& track : scene.tracks) {
    std::vector<double> errors;
    for (const TrackObservation& o : track.observations)
      errors.push_back(ReprojectionErrorPx(scene, track, o) / o.sigma_px);
    all.insert(all.end(), errors.begin(), errors.end());
    by_track.push_back(Median(std::move(errors)));
  }
  const double most = most_times_usual * Median(std::move(all));
  std::size_t next = 0;
  std::erase_if(scene.tracks, [&](const SceneTrack&) { return !(by_track[next++] <= most); });
  spdlog::debug("{} of {} points slide", by_track.size() - scene.tracks.size(), by_track.size());
}

ViewGroups GroupViews(const RefineScene& scene) {
  std::vector<int> parent(scene.views.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root_of = [&](int v) {
    while (parent[At(v)] != v) v = parent[At(v)];
    return v;
  };
  ViewGroups groups;
  groups.group.assign(scene.views.size(), -1);
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& o : track.observations) {
      const int a = root_of(track.observations.front().view), b = root_of(o.view);
      parent[At(std::max(a, b))] = std::min(a, b);
      groups.group[At(o.view)] = 0;
    }
  std::vector<int> number(scene.views.size(), -1);
  for (int v = 0; v < static_cast<int>(scene.views.size()); ++v) {
    int& group = groups.group[At(v)];
    if (group < 0) continue;
    int& of_root = number[At(root_of(v))];
    if (of_root < 0) of_root = groups.count++;
    group = of_root;
  }
  return groups;
}

namespace {

// Returns the similarity from the views' present poses to their start poses. The scale is the median change
// of the distances between centres. The rotation comes from the centres and from points on the axes, as far
// out as the scene is, which determine it even where all centres lie on a line. The middle of the centres
// stays.
std::optional<Similarity3> ToStart(const std::vector<const RefineView*>& views, double reach) {
  constexpr std::size_t kPartners = 50;  // views that each one is compared with, about: enough for a median
  std::vector<double> ratios;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t j = i + 1; j < views.size(); j += 1 + views.size() / kPartners) {
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

void DropGroupsWithoutRecordedViews(RefineScene& scene) {
  const ViewGroups groups = GroupViews(scene);
  std::vector<bool> held(At(groups.count), false);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    if (groups.group[v] >= 0 && scene.views[v].is_recorded) held[At(groups.group[v])] = true;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    RefineView& view = scene.views[v];
    if (groups.group[v] < 0 || held[At(groups.group[v])]) continue;
    view.registered = false;
    view.why = "shares points with no recorded view";
    view.cam_from_world = view.start;
  }
  std::erase_if(scene.tracks, [&](const SceneTrack& track) {
    return !scene.view(track.observations.front().view).registered;
  });
}

bool AlignToStart(RefineScene& scene) {
  const ViewGroups groups = GroupViews(scene);
  for (int group = 0; group < groups.count; ++group) {
    const auto in_group = [&](int v) { return groups.group[At(v)] == group; };
    std::vector<double> distances;
    for (const SceneTrack& track : scene.tracks)
      if (in_group(track.observations.front().view))
        for (const TrackObservation& o : track.observations)
          distances.push_back((track.position - scene.view(o.view).cam_from_world.OriginInSource()).norm());
    std::vector<const RefineView*> views;
    for (int v = 0; v < static_cast<int>(scene.views.size()); ++v)
      if (in_group(v)) views.push_back(&scene.view(v));
    const auto is_recorded = [](const RefineView* view) { return view->is_recorded; };
    if (std::ranges::count_if(views, is_recorded) > 1)
      std::erase_if(views, [&](const RefineView* view) { return !is_recorded(view); });
    const auto move = ToStart(views, Median(std::move(distances)));
    if (!move) return false;
    const Eigen::Quaterniond turned(move->rotation);
    for (SceneTrack& track : scene.tracks)
      if (in_group(track.observations.front().view)) track.position = *move * track.position;
    for (int v = 0; v < static_cast<int>(scene.views.size()); ++v) {
      if (!in_group(v)) continue;
      Rigid3& pose = scene.views[At(v)].cam_from_world;
      const Vector3d center = *move * pose.OriginInSource();
      pose.rotation = (pose.rotation * turned.conjugate()).normalized();
      pose.translation = -(pose.rotation * center);
      if (auto& middle_row = scene.views[At(v)].middle_row_from_picture)
        middle_row->translation *= move->scale;
    }
  }
  return groups.count > 0;
}

}  // namespace ulf::tracking
