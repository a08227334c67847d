#include "render/proxy/plane_search.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>

#include "core/base/counted.h"
#include "core/geometry/small_matrices.h"

namespace ulf::render {

using Eigen::Vector3d;

namespace {

// All of these are guessed.
constexpr double kParallaxRad = 0.005;  // two and a half pixels of a picture of 500 at 53 degrees
// The relief that counts as flat, over the plane's distance from the viewpoint: at least, since points are
// not exact, and at most, since pictures are also rendered from other places.
constexpr double kLeastRelief = 0.003, kMostRelief = 0.2;
constexpr std::size_t kFewestPoints = 50;  // of the light field
constexpr std::size_t kPlaneSearchMostPlanes = 6;
constexpr double kPlaneSearchLeastShare = 0.04;  // of all points: a plane with fewer ends the search
constexpr std::size_t kLeastPoints = 12;         // of a plane
constexpr double kLeastExplained = 0.5;          // of all points: otherwise the scene is not planar
constexpr int kPlaneSearchSamples = 4000;        // for each plane
constexpr std::size_t kMostScored = 3000;        // points by which samples are scored

struct SightedPoint {
  Vector3d at, from;  // in the world: the point, and the viewpoint nearest to it that sees it
  double relief;      // largest distance from a plane, over the viewpoint's distance from that plane
  std::size_t index;  // in the light field
};

struct TriedPlane {
  Vector3d normal;
  double offset;

  // Returns the point's distance from the plane; up to 1 it lies on it.
  double Off(const SightedPoint& point) const {
    const double allowed = point.relief * std::abs(normal.dot(point.from) - offset);
    const double off = std::abs(normal.dot(point.at) - offset);
    return allowed > 0 ? off / allowed : std::numeric_limits<double>::infinity();
  }
};

std::vector<SightedPoint> SightedPoints(const LightField& light_field) {
  std::vector<Vector3d> viewpoints;
  for (const View& view : light_field.views) viewpoints.push_back(view.cam_from_world.OriginInSource());
  const double spacing = SpacingOf(viewpoints);
  const auto seen_from = ViewpointsOfPoints(light_field);
  std::vector<SightedPoint> points;
  for (std::size_t i = 0; i < seen_from.size(); ++i) {
    if (seen_from[i].empty()) continue;
    const Vector3d& at = light_field.points[i].position_in_world;
    const double distance = (at - seen_from[i].front()).norm();
    const double relief = spacing > 0 ? kParallaxRad * distance / spacing : kMostRelief;
    points.push_back({at, seen_from[i].front(), std::clamp(relief, kLeastRelief, kMostRelief), i});
  }
  return points;
}

// At even density the mean score is 0: the integral of 1 - off² from 0 to 1 equals that of the rest.
constexpr double kAround = 3;
double Score(const TriedPlane& plane, const std::vector<SightedPoint>& points) {
  double score = 0;
  for (const SightedPoint& point : points) {
    const double off = plane.Off(point);
    if (off < 1)
      score += 1 - off * off;
    else if (off < kAround)
      score -= (2.0 / 3) / (kAround - 1);
  }
  return score;
}

// Tests against chance: the score's deviation over even density is half the root of the number of points that
// count, and the best of thousands of samples is four or five deviations off. Also most of the surrounding
// points must lie on the plane.
bool StandsOut(const TriedPlane& plane, const std::vector<SightedPoint>& points, double score) {
  constexpr double kDeviations = 6, kLeastMean = 0.45;
  std::size_t on = 0, about = 0;
  for (const SightedPoint& point : points) {
    const double off = plane.Off(point);
    on += off < 1;
    about += off < kAround;
  }
  return score > kDeviations * 0.5 * std::sqrt(static_cast<double>(about)) &&
         score > kLeastMean * static_cast<double>(on);
}

std::optional<TriedPlane> Through(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a);
  const double length = normal.norm(), scale = (b - a).norm() * (c - a).norm();
  constexpr double kLeastSine = 1e-3;
  if (!(length > kLeastSine * scale)) return std::nullopt;
  return TriedPlane{normal / length, normal.dot(a) / length};
}

// Fits by least squares to the points on it, weighted by their tolerance.
std::optional<TriedPlane> Fitted(const TriedPlane& plane, const std::vector<SightedPoint>& points) {
  double weights = 0;
  std::size_t on = 0;
  Vector3d mean = Vector3d::Zero();
  const auto weight_of = [&](const SightedPoint& point) {
    const double off = plane.Off(point);
    if (!(off < 1)) return 0.0;
    return 1 / std::pow(point.relief * (plane.normal.dot(point.from) - plane.offset), 2);
  };
  for (const SightedPoint& point : points)
    if (const double weight = weight_of(point); weight > 0) {
      weights += weight;
      mean += weight * point.at;
      ++on;
    }
  if (on < 3) return std::nullopt;
  mean /= weights;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const SightedPoint& point : points)
    if (const double weight = weight_of(point); weight > 0)
      spread += weight / weights * (point.at - mean) * (point.at - mean).transpose();
  const Eigenvalues3 axes = EigenvaluesOf(spread);
  const Vector3d normal = axes.vectors.col(0);
  return TriedPlane{normal, normal.dot(mean)};
}

// Refits as long as the score improves.
TriedPlane Improved(TriedPlane plane, double& score, const std::vector<SightedPoint>& points) {
  constexpr int kRounds = 8;
  for (int i = 0; i < kRounds; ++i) {
    const auto fitted = Fitted(plane, points);
    const double better = fitted ? Score(*fitted, points) : 0;
    if (!(better > score)) break;
    plane = *fitted;
    score = better;
  }
  return plane;
}

// Returns a subset of evenly spaced points.
std::vector<SightedPoint> AtMost(const std::vector<SightedPoint>& points, std::size_t most) {
  if (points.size() <= most) return points;
  std::vector<SightedPoint> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(points[i * points.size() / most]);
  return some;
}

// Draws samples of varying extent, because planes are small and large: the two points nearest to the first of
// 2, 4, 8, up to 128 drawn ones.
std::optional<TriedPlane> Drawn(const std::vector<SightedPoint>& points, int sample, std::mt19937& random) {
  const int draws = 2 << (sample % 7);
  const auto draw = [&]() -> const Vector3d& { return points[random() % points.size()].at; };
  const Vector3d& first = draw();
  std::array<const Vector3d*, 2> nearest{};
  std::array<double, 2> distances{};
  distances.fill(std::numeric_limits<double>::infinity());
  for (int i = 0; i < draws; ++i) {
    const Vector3d& other = draw();
    const double distance = (other - first).squaredNorm();
    if (distance == 0 || distance == distances[0] || distance >= distances[1]) continue;
    const std::size_t place = distance < distances[0] ? 0 : 1;
    if (place == 0) distances[1] = distances[0], nearest[1] = nearest[0];
    distances[place] = distance;
    nearest[place] = &other;
  }
  if (!nearest[1]) return std::nullopt;
  return Through(first, *nearest[0], *nearest[1]);
}

std::optional<TriedPlane> NextPlane(const std::vector<SightedPoint>& left, std::mt19937& random) {
  const std::vector<SightedPoint> scored = AtMost(left, kMostScored);
  // Samples whose expected score on these is below half of the best one's are given up. Guessed.
  constexpr std::size_t kFew = 400;
  constexpr double kPromising = 0.5;
  const std::vector<SightedPoint> few = AtMost(scored, kFew);
  const double few_of_scored = static_cast<double>(scored.size()) / static_cast<double>(few.size());
  std::optional<TriedPlane> best;
  double best_score = 0;
  for (int i = 0; i < kPlaneSearchSamples; ++i) {
    const auto plane = Drawn(scored, i, random);
    if (!plane || Score(*plane, few) * few_of_scored < kPromising * best_score) continue;
    double score = Score(*plane, scored);
    if (score <= best_score) continue;
    best = Improved(*plane, score, scored);
    best_score = score;
  }
  if (!best || !StandsOut(*best, scored, best_score)) return std::nullopt;
  double score = Score(*best, left);
  return Improved(*best, score, left);
}

// Assigns each point to its nearest plane, or to none.
std::vector<std::vector<SightedPoint>> Shared(const std::vector<TriedPlane>& planes,
                                              const std::vector<SightedPoint>& points) {
  std::vector<std::vector<SightedPoint>> shared(planes.size());
  for (const SightedPoint& point : points) {
    const auto nearest =
        std::ranges::min_element(planes, {}, [&](const TriedPlane& plane) { return plane.Off(point); });
    if (nearest != planes.end() && nearest->Off(point) < 1)
      shared[static_cast<std::size_t>(nearest - planes.begin())].push_back(point);
  }
  return shared;
}

FoundPlane Found(const TriedPlane& plane, const std::vector<SightedPoint>& points) {
  double towards = 0;
  for (const SightedPoint& point : points) towards += plane.normal.dot(point.from) > plane.offset ? 1 : -1;
  const double sign = towards < 0 ? -1 : 1;
  FoundPlane found{sign * plane.normal, sign * plane.offset, {}};
  for (const SightedPoint& point : points) found.points.push_back(point.index);
  return found;
}

}  // namespace

std::vector<std::vector<Vector3d>> ViewpointsOfPoints(const LightField& light_field) {
  std::map<int, Vector3d> viewpoints;
  for (const View& view : light_field.views) viewpoints[view.id] = view.cam_from_world.OriginInSource();
  std::vector<std::vector<Vector3d>> seen_from(light_field.points.size());
  for (std::size_t i = 0; i < seen_from.size(); ++i) {
    const ScenePoint& point = light_field.points[i];
    if (!point.position_in_world.allFinite()) continue;
    for (const ViewObservation& seen : point.track)
      if (const auto view = viewpoints.find(seen.view_id); view != viewpoints.end())
        seen_from[i].push_back(view->second);
    const auto distance = [&](const Vector3d& from) { return (from - point.position_in_world).norm(); };
    std::ranges::stable_sort(seen_from[i], {}, distance);
    if (!seen_from[i].empty() || viewpoints.empty()) continue;
    const auto nearest =
        std::ranges::min_element(viewpoints, {}, [&](const auto& view) { return distance(view.second); });
    seen_from[i].push_back(nearest->second);
  }
  return seen_from;
}

PlaneSearch FindPlanes(const LightField& light_field) {
  PlaneSearch search;
  if (light_field.views.empty() || light_field.points.size() < kFewestPoints) {
    search.points = light_field.points.size();
    search.why_none = fmt::format("{} are too few: planes are looked for in {} or more",
                                  Counted(search.points, "tracked point"), kFewestPoints);
    return search;
  }
  const std::vector<SightedPoint> points = SightedPoints(light_field);
  search.points = points.size();
  const auto all = static_cast<double>(points.size());
  const auto enough = [&](const std::vector<SightedPoint>& on) {
    return on.size() >= kLeastPoints && static_cast<double>(on.size()) >= kPlaneSearchLeastShare * all;
  };
  std::mt19937 random(static_cast<std::uint32_t>(points.size()));
  std::vector<TriedPlane> planes;
  std::vector<SightedPoint> left = points;
  while (planes.size() < kPlaneSearchMostPlanes && left.size() >= kLeastPoints) {
    const auto plane = NextPlane(left, random);
    if (!plane || !enough(Shared({*plane}, left).front())) break;
    planes.push_back(*plane);
    std::erase_if(left, [&](const SightedPoint& point) { return plane->Off(point) < 1; });
  }
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const auto shared = Shared(planes, points);
    for (std::size_t i = 0; i < planes.size(); ++i)
      if (const auto fitted = Fitted(planes[i], shared[i])) planes[i] = *fitted;
  }
  std::size_t explained = 0;
  const auto shared = Shared(planes, points);
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (enough(shared[i])) {
      search.planes.push_back(Found(planes[i], shared[i]));
      explained += shared[i].size();
    }
  std::ranges::stable_sort(search.planes, std::ranges::greater(),
                           [](const FoundPlane& plane) { return plane.points.size(); });
  search.explained = all > 0 ? static_cast<double>(explained) / all : 0;
  if (search.explained >= kLeastExplained && !search.planes.empty()) return search;
  search.why_none = search.planes.empty()
                        ? fmt::format("no plane stands out among the {} tracked points", points.size())
                        : fmt::format("{} explain {:.0f} % of the {} tracked points, less than {:.0f} %",
                                      Counted(search.planes.size(), "plane"), 100 * search.explained,
                                      points.size(), 100 * kLeastExplained);
  search.planes.clear();
  return search;
}

}  // namespace ulf::render
