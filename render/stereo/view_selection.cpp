#include "render/stereo/view_selection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ulf::render {
namespace {

using Eigen::Vector3d;

double AngleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// The share of a view's picture, taken at the subject's distance, that another one sees.
double SharedPicture(const StereoView& view, const StereoView& other, double depth) {
  constexpr int kSamples = 6;
  int seen = 0;
  for (int i = 0; i < kSamples; ++i)
    for (int j = 0; j < kSamples; ++j) {
      const Vector3d ray = view.RayInWorld((2 * i + 1) * view.camera.width / (2 * kSamples),
                                           (2 * j + 1) * view.camera.height / (2 * kSamples));
      if (other.See(view.center_in_world + depth * ray)) ++seen;
    }
  return static_cast<double>(seen) / (kSamples * kSamples);
}

// Where a view looks at: on its axis, as far away as the subject.
Vector3d Target(const StereoView& view, const Subject& subject) {
  const Vector3d axis = view.cam_from_world.DirectionInSource(Vector3d::UnitZ());
  const Vector3d to_subject = subject.center_in_world - view.center_in_world;
  const double depth = axis.dot(to_subject);
  return view.center_in_world + (depth > 0.1 * to_subject.norm() ? depth : to_subject.norm()) * axis;
}

struct Place {
  Vector3d stands = Vector3d::Zero(), looks = Vector3d::Zero();
};
double Apart(const Place& a, const Place& b) {
  return std::hypot((a.stands - b.stands).norm(), (a.looks - b.looks).norm());
}

}  // namespace

std::vector<int> NeighboursOf(int view, const std::vector<StereoView>& views, const Subject& subject,
                              const NeighbourOptions& options) {
  const StereoView& own = views[static_cast<std::size_t>(view)];
  const Vector3d target = Target(own, subject);
  const Vector3d own_sight = own.center_in_world - target;
  struct Candidate {
    int view;
    Vector3d sight;
    double score;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (static_cast<int>(i) == view) continue;
    const Vector3d sight = views[i].center_in_world - target;
    const double parallax = AngleBetween(own_sight, sight);
    if (parallax > options.most_parallax ||
        (views[i].center_in_world - own.center_in_world).norm() < 1e-4 * own_sight.norm())
      continue;
    const double scale = sight.norm() / own_sight.norm();
    const double ratio = parallax / options.wanted_parallax;
    const double score = std::min(ratio, 1 / (ratio * ratio)) * std::min(scale, 1 / scale) *
                         SharedPicture(own, views[i], own_sight.norm());
    if (score > 0.02) candidates.push_back({static_cast<int>(i), sight, score});
  }
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < options.count && !candidates.empty()) {
    const auto best =
        std::max_element(candidates.begin(), candidates.end(),
                         [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
    const Candidate taken = *best;
    candidates.erase(best);
    chosen.push_back(taken.view);
    // One beside it tells little that it does not.
    for (Candidate& other : candidates) {
      const double apart = AngleBetween(taken.sight, other.sight) / (0.5 * options.wanted_parallax);
      other.score *= std::clamp(apart, 0.1, 1.0);
    }
  }
  return chosen;
}

std::vector<int> SpreadViews(const std::vector<StereoView>& views, const Subject& subject, int count) {
  std::vector<int> chosen;
  if (static_cast<int>(views.size()) <= count) {
    for (std::size_t i = 0; i < views.size(); ++i) chosen.push_back(static_cast<int>(i));
    return chosen;
  }
  // Where it stands, in distances to the subject, and where it looks: the farthest from all that are chosen
  // comes next, from the middle of all on.
  std::vector<Place> places;
  Place middle;
  for (const StereoView& view : views) {
    places.push_back({(view.center_in_world - subject.center_in_world).normalized(),
                      view.cam_from_world.DirectionInSource(Vector3d::UnitZ())});
    middle.stands += places.back().stands / static_cast<double>(views.size());
    middle.looks += places.back().looks / static_cast<double>(views.size());
  }
  std::vector<double> distance(views.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (Apart(places[i], middle) < Apart(places[next], middle)) next = i;
  while (static_cast<int>(chosen.size()) < count) {
    chosen.push_back(static_cast<int>(next));
    for (std::size_t i = 0; i < views.size(); ++i)
      distance[i] = std::min(distance[i], Apart(places[i], places[next]));
    next = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

}  // namespace ulf::render
