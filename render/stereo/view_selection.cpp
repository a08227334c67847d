#include "render/stereo/view_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/at.h"

namespace ulf::render {
namespace {

// Angle between the lines of sight to the subject, radians. Smaller ones give a worse depth, and larger
// ones images that look different. Guessed.
constexpr double kWantedParallax = Radians(8);
// Views with a larger parallax are no neighbours. Guessed.
constexpr double kMostParallax = Radians(45);
// A view nearer than this share of the distance to the subject stands in the same place and is no
// neighbour.
constexpr double kLeastBaseline = 1e-4;
// Views with a lower score are no neighbours; 1 is the best score. Guessed.
constexpr double kLeastScore = 0.02;

// A view's score falls below this angle to a chosen view, over the wanted parallax, down to this share.
// Guessed.
constexpr double kWantedSpread = 0.5, kLeastOfScore = 0.1;

using Eigen::Vector3d;

// Returns the share of a view's image that another view sees, if everything has the depth `depth`.
double SharedImage(const StereoView& view, const StereoView& other, double depth) {
  constexpr int kSamples = 6;  // along either side of the image
  int seen = 0;
  for (int i = 0; i < kSamples; ++i)
    for (int j = 0; j < kSamples; ++j) {
      const Vector3d ray = view.RayInWorld((2 * i + 1) * view.camera.width / (2 * kSamples),
                                           (2 * j + 1) * view.camera.height / (2 * kSamples));
      if (other.Project(view.center_in_world + depth * ray)) ++seen;
    }
  return static_cast<double>(seen) / (kSamples * kSamples);
}

// Returns the point at which a view looks: on its axis, at the subject's depth; at the subject's distance if
// the view looks elsewhere.
Vector3d Target(const StereoView& view, const Subject& subject) {
  const Vector3d axis = view.cam_from_world.DirectionInSource(Vector3d::UnitZ());
  const Vector3d to_subject = subject.center_in_world - view.center_in_world;
  const double depth = axis.dot(to_subject), distance = DistanceFrom(subject, view);
  constexpr double kLeastCosine = 0.1;  // between the axis and the subject. Guessed.
  return view.center_in_world + (depth > kLeastCosine * distance ? depth : distance) * axis;
}

struct Place {
  Vector3d stands = Vector3d::Zero(), looks = Vector3d::Zero();
};
double Apart(const Place& a, const Place& b) {
  return std::hypot((a.stands - b.stands).norm(), (a.looks - b.looks).norm());
}

}  // namespace

double DistanceFrom(const Subject& subject, const StereoView& view) {
  return std::max(0.5 * subject.radius, (subject.center_in_world - view.center_in_world).norm());
}

std::vector<int> NeighboursOf(int view, const std::vector<StereoView>& views, const Subject& subject,
                              int count) {
  const StereoView& own = views[At(view)];
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
    if (parallax > kMostParallax ||
        (views[i].center_in_world - own.center_in_world).norm() < kLeastBaseline * own_sight.norm())
      continue;
    const double scale = sight.norm() / own_sight.norm();
    const double ratio = parallax / kWantedParallax;
    const double score = std::min(ratio, 1 / (ratio * ratio)) * std::min(scale, 1 / scale) *
                         SharedImage(own, views[i], own_sight.norm());
    if (score > kLeastScore) candidates.push_back({static_cast<int>(i), sight, score});
  }
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < count && !candidates.empty()) {
    const auto best = std::ranges::max_element(candidates, {}, &Candidate::score);
    const Candidate taken = *best;
    candidates.erase(best);
    chosen.push_back(taken.view);
    // A view next to a chosen one adds little.
    for (Candidate& other : candidates) {
      const double apart = AngleBetween(taken.sight, other.sight) / (kWantedSpread * kWantedParallax);
      other.score *= std::clamp(apart, kLeastOfScore, 1.0);
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
  // A view's place is its direction from the subject and the direction of its axis. The first view is the one
  // nearest to the middle of all places; each next view is the farthest from those that are chosen.
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
    next = static_cast<std::size_t>(std::ranges::max_element(distance) - distance.begin());
  }
  std::ranges::sort(chosen);
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

}  // namespace ulf::render
