#include "core/light_field/exchange/subject_of_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/light_field/folder/quick_checks.h"

namespace ulf {
namespace {

// The nearest and the farthest depth in one view, and the median disparity's depth.
struct ShownDepths {
  double nearest = 0, middle = 0, farthest = 0;
};
using DepthsOfViews = std::vector<std::optional<ShownDepths>>;  // by view

DepthsOfViews FromBounds(const std::vector<Eigen::Vector2d>& bounds) {
  DepthsOfViews depths;
  for (const Eigen::Vector2d& bound : bounds)
    depths.push_back(ShownDepths{bound.x(), 2 / (1 / bound.x() + 1 / bound.y()), bound.y()});
  return depths;
}

// Uses the points that a view is known to have seen; without tracks, all that project into it.
DepthsOfViews FromPoints(const LightField& light_field) {
  constexpr std::size_t kFewestPoints = 10;  // needed for a view's depths. Guessed.
  constexpr double kAstray = 0.05;           // share of outliers at either end. Guessed.
  std::unordered_map<int, std::size_t> index_of_view;
  for (std::size_t i = 0; i < light_field.views.size(); ++i) index_of_view[light_field.views[i].id] = i;
  std::vector<std::vector<double>> disparities(light_field.views.size());
  const auto note = [&](std::size_t i, const Eigen::Vector3d& point) {
    const View& view = light_field.views[i];
    const Eigen::Vector3d in_cam = view.cam_from_world * point;
    const CameraModel& camera = light_field.CameraOf(view);
    const auto img = camera.ImgFromCam(in_cam);
    if (in_cam.z() > 0 && img && camera.Contains(*img)) disparities[i].push_back(1 / in_cam.z());
  };
  const bool some_are_tracked =
      std::ranges::any_of(light_field.points, [](const ScenePoint& point) { return !point.track.empty(); });
  for (const ScenePoint& point : light_field.points) {
    if (some_are_tracked)
      for (const ViewObservation& seen : point.track)
        note(index_of_view.at(seen.view_id), point.position_in_world);
    else
      for (std::size_t i = 0; i < light_field.views.size(); ++i) note(i, point.position_in_world);
  }
  DepthsOfViews depths;
  for (std::vector<double>& of_view : disparities) {
    if (of_view.size() < kFewestPoints)
      depths.push_back(std::nullopt);
    else
      depths.push_back(ShownDepths{1 / Quantile(of_view, 1 - kAstray), 1 / Quantile(of_view, 0.5),
                                   1 / Quantile(of_view, kAstray)});
  }
  return depths;
}

bool ShowSomethingAt(const Subject& subject, const LightField& light_field, const DepthsOfViews& depths) {
  std::size_t inside = 0, known = 0;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!depths[i]) continue;
    const double depth = (light_field.views[i].cam_from_world * subject.center_in_world).z();
    ++known;
    inside += depth >= depths[i]->nearest - subject.radius && depth <= depths[i]->farthest + subject.radius;
  }
  return 2 * inside >= known;
}

std::optional<Subject> SubjectFromDepths(const LightField& light_field, const DepthsOfViews& depths) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<double> radii;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!depths[i]) continue;
    const View& view = light_field.views[i];
    const CameraModel& camera = light_field.CameraOf(view);
    sum += view.cam_from_world.Inverse() * Eigen::Vector3d(0, 0, depths[i]->middle);
    radii.push_back(depths[i]->middle * std::sin(std::atan(0.5 * kSubjectSize * camera.width / camera.fx)));
  }
  if (radii.empty()) return std::nullopt;
  const Subject subject{sum / static_cast<double>(radii.size()), Median(radii)};
  const bool is_before_cameras = std::ranges::all_of(light_field.views, [&](const View& view) {
    return (view.cam_from_world * subject.center_in_world).z() > 0;
  });
  return is_before_cameras ? std::optional(subject) : std::nullopt;
}

// Returns the mean square distance of the cameras from their middle.
double VarianceOfCenters(const LightField& light_field) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares = 0;
  for (const View& view : light_field.views) sum += view.CenterInWorld();
  const double count = static_cast<double>(light_field.views.size());
  for (const View& view : light_field.views) squares += (view.CenterInWorld() - sum / count).squaredNorm();
  return squares / count;
}

// Returns whether the cameras would look at one thing if each pose were inverted, with the axes of either
// convention. Cameras around a thing are far apart, while their inverses are at about one place, near which
// these axes meet as well, by chance also before them.
bool InversesMeet(const LightField& light_field) {
  const Rigid3 half_turn{Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()};
  LightField inverted = light_field;
  for (View& view : inverted.views) view.cam_from_world = view.cam_from_world.Inverse();
  constexpr double kFarFromEachOther = 4;  // times the variance of the given poses. Guessed
  if (VarianceOfCenters(inverted) < kFarFromEachOther * VarianceOfCenters(light_field)) return false;
  if (SubjectFromAxes(inverted)) return true;
  for (View& view : inverted.views) view.cam_from_world = half_turn * view.cam_from_world;
  return SubjectFromAxes(inverted).has_value();
}

// Two groups of cameras that are far apart in comparison with their extent, the larger first.
struct CameraGroups {
  std::size_t first = 0, second = 0;  // how many cameras
  Eigen::Vector3d first_middle, second_middle;
};

// Divides the cameras by the plane halfway between the two that are farthest apart.
std::optional<CameraGroups> GroupsOf(const LightField& light_field) {
  constexpr double kFarApart = 4;  // times the largest distance from a group's middle. Guessed
  constexpr std::size_t kFewest = 2;
  if (light_field.views.size() < 2 * kFewest) return std::nullopt;
  const auto farthest_from = [&](const Eigen::Vector3d& from) {
    Eigen::Vector3d farthest = from;
    for (const View& view : light_field.views)
      if ((view.CenterInWorld() - from).squaredNorm() > (farthest - from).squaredNorm())
        farthest = view.CenterInWorld();
    return farthest;
  };
  const Eigen::Vector3d a = farthest_from(light_field.views.front().CenterInWorld()), b = farthest_from(a);
  const auto is_first = [&](const Eigen::Vector3d& center) {
    return (center - a).squaredNorm() < (center - b).squaredNorm();
  };
  CameraGroups groups{0, 0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (const View& view : light_field.views) {
    const bool first = is_first(view.CenterInWorld());
    ++(first ? groups.first : groups.second);
    (first ? groups.first_middle : groups.second_middle) += view.CenterInWorld();
  }
  if (groups.first < kFewest || groups.second < kFewest) return std::nullopt;
  groups.first_middle /= static_cast<double>(groups.first);
  groups.second_middle /= static_cast<double>(groups.second);
  double extent = 0;
  for (const View& view : light_field.views) {
    const Eigen::Vector3d center = view.CenterInWorld();
    extent =
        std::max(extent, (center - (is_first(center) ? groups.first_middle : groups.second_middle)).norm());
  }
  if (groups.first < groups.second) {
    std::swap(groups.first, groups.second);
    std::swap(groups.first_middle, groups.second_middle);
  }
  const bool are_apart = (groups.first_middle - groups.second_middle).norm() > kFarApart * extent;
  return are_apart ? std::optional(groups) : std::nullopt;
}

}  // namespace

std::optional<SubjectOfSet> FindSubject(const PosedSet& set) {
  const LightField& light_field = set.light_field;
  const bool points_fit = DescribeMisfit(FitOfPoints(light_field)).empty();
  const DepthsOfViews points = points_fit ? FromPoints(light_field) : DepthsOfViews();
  const bool points_tell = std::ranges::any_of(points, [](const auto& depths) { return depths.has_value(); });
  const DepthsOfViews depths = points_tell ? points : FromBounds(set.depth_bounds);
  if (const auto subject = SubjectFromAxes(light_field);
      subject && ShowSomethingAt(*subject, light_field, depths))
    return SubjectOfSet{*subject, "the optical axes"};
  if (const auto subject = SubjectFromDepths(light_field, depths))
    return SubjectOfSet{*subject, points_tell ? "the points" : "the depth bounds"};
  return std::nullopt;
}

std::string WhyNoSubject(const LightField& light_field) {
  const std::string give_it = fmt::format("give it with {} x,y,z,radius, or do without one ({})",
                                          Parameter("subject"), Parameter("no_subject"));
  if (light_field.views.size() == 1)
    return fmt::format("one photograph alone does not tell how far away it is; {}", give_it);
  if (VarianceOfCenters(light_field) == 0)
    return fmt::format(
        "all cameras stand at one place, from which no depth follows; are the poses those of the set? If so, "
        "{}",
        give_it);
  if (const auto groups = GroupsOf(light_field)) {
    const auto words = [](std::size_t count, const Eigen::Vector3d& at) {
      return fmt::format("{} around {:.3g} {:.3g} {:.3g}", Counted(count, "camera"), at.x(), at.y(), at.z());
    };
    return fmt::format(
        "the cameras stand in two groups far apart ({} and {}): were two sets joined whose worlds differ? "
        "Import each by itself, or {}",
        words(groups->first, groups->first_middle), words(groups->second, groups->second_middle), give_it);
  }
  if (InversesMeet(light_field))
    return fmt::format(
        "the cameras' axes do not meet before them; those of the inverted poses do. Either mend the poses (a "
        "transform_matrix leads from the camera to the world, COLMAP's poses from the world to the camera), "
        "or, where they are right, {}",
        give_it);
  const auto meeting = ConvergenceOfAxes(light_field);
  const auto behind = !meeting ? 0 : std::ranges::count_if(light_field.views, [&](const View& view) {
    return (view.cam_from_world * *meeting).z() < 0;
  });
  if (2 * static_cast<std::size_t>(behind) > light_field.views.size())
    return fmt::format(
        "the optical axes meet behind the cameras. Either the cameras look outwards: then do without one "
        "({}), "
        "or give it with {} x,y,z,radius. Or the poses have other axes than the format: then mend them (a "
        "transform_matrix leads from the camera to the world, with y up and z back)",
        Parameter("no_subject"), Parameter("subject"));
  return fmt::format(
      "the cameras' axes are nearly parallel or do not meet in front of them, and the set has neither points "
      "that belong to the poses nor depth bounds; {}",
      give_it);
}

}  // namespace ulf
