#include "tracking/estimation/pose_log_odds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tracking/features/matching.h"
#include "tracking/tracker/frame_locator.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Two looks of the same thing differ by less.
constexpr int kTwinBits = kSureDistance;

// Logarithm of the probability of a count that varies by `spread` of its mean beyond what counting does
// (negative binomial).
double LogCount(double count, double mean, double spread) {
  const double shape = 1 / (spread * spread);
  return std::lgamma(count + shape) - std::lgamma(shape) - std::lgamma(count + 1) +
         shape * std::log(shape / (shape + mean)) + count * std::log(mean / (shape + mean));
}

// log((1 - h) exp(a) + h exp(b))
double LogMixture(double a, double b, double h) {
  const double most = std::max(a, b);
  return most + std::log((1 - h) * std::exp(a - most) + h * std::exp(b - most));
}

}  // namespace

double PoseLogOdds(const CameraModel& camera, const FramePose& located, const LeftOut& left_out) {
  constexpr int kColumns = 4, kRows = 3;
  constexpr double kByChance = 0.05;  // of the points looked for, a wrong pose finds fewer
  constexpr double kHidden = 0.5;     // of the cells, before anything is known
  constexpr double kSpread = 0.4;     // of what is found about what should be, from cell to cell
  constexpr double kUnnoticed = 0.1;  // of what repeats, is not left out
  struct Cell {
    double looked_for = 0, expected = 0, found = 0, repeats = 0;
  };
  std::array<Cell, kColumns * kRows> cells{};
  const auto cell_of = [&](const Vector2d& img) -> Cell& {
    const int column = std::clamp(static_cast<int>(kColumns * img.x() / camera.width), 0, kColumns - 1);
    const int row = std::clamp(static_cast<int>(kRows * img.y() / camera.height), 0, kRows - 1);
    return cells[static_cast<std::size_t>(row * kColumns + column)];
  };
  const auto counts = [&](int i) { return left_out.empty() || !left_out[static_cast<std::size_t>(i)]; };
  for (const int i : located.looked_for) {
    const Candidate& candidate = located.candidates[static_cast<std::size_t>(i)];
    const auto img = camera.ImgFromCam(located.cam_from_world * candidate.position);
    if (!img || !counts(i)) continue;
    Cell& cell = cell_of(*img);
    ++cell.looked_for;
    cell.expected += candidate.find_rate;
  }
  for (const PointMatch& match : located.matches) {
    Cell& cell = cell_of(match.img);
    ++(counts(match.candidate) ? cell.found : cell.repeats);
  }
  double evidence = 0;
  for (const Cell& cell : cells) {
    const double by_chance = kByChance * cell.looked_for + kUnnoticed * cell.repeats;
    if (by_chance == 0) continue;
    const double chance = LogCount(cell.found, by_chance, kSpread);
    const double visible = LogCount(cell.found, std::max(cell.expected, by_chance), kSpread);
    evidence += LogMixture(visible, chance, kHidden) - chance;
  }
  return evidence;
}

void ExcludeAmbiguousMatches(const CameraModel& camera, const FeatureSet& picture, const FramePose& located,
                             LeftOut& left_out) {
  constexpr double kApartPx = 10;  // the same corner on other levels is no twin
  struct Look {
    const Descriptor* descriptor;
    Vector2d img;
    double apart_px;
  };
  std::vector<Look> looks;
  std::vector<std::optional<Vector2d>> img_of(located.candidates.size());
  for (const Feature& feature : picture.all())
    looks.push_back({&feature.descriptor, feature.img, kApartPx * LevelScale(feature.level)});
  for (const int i : located.in_view) {
    const Candidate& candidate = located.candidates[static_cast<std::size_t>(i)];
    const auto img = camera.ImgFromCam(located.cam_from_world * candidate.position);
    if (!img) continue;
    img_of[static_cast<std::size_t>(i)] = img;
    const double distance = (located.cam_from_world * candidate.position).norm();
    looks.push_back({&candidate.descriptor, *img,
                     kApartPx * LevelScale(NearestLevel(candidate.reference_distance / distance))});
  }
  left_out.resize(located.candidates.size(), false);
  for (const int i : located.looked_for) {
    const auto& img = img_of[static_cast<std::size_t>(i)];
    if (left_out[static_cast<std::size_t>(i)] || !img) continue;
    const Descriptor& descriptor = located.candidates[static_cast<std::size_t>(i)].descriptor;
    left_out[static_cast<std::size_t>(i)] = std::any_of(looks.begin(), looks.end(), [&](const Look& other) {
      return Distance(descriptor, *other.descriptor) <= kTwinBits &&
             (*img - other.img).squaredNorm() > other.apart_px * other.apart_px;
    });
  }
}

void ExcludeAmbiguousMatches(const Map& map, int keyframe, const FramePose& located, LeftOut& left_out) {
  left_out.resize(located.candidates.size(), false);
  constexpr double kApart = 0.05;  // of the distance: nearer is a second copy of the same point
  const Vector3d center = located.cam_from_world.OriginInSource();
  std::vector<const MapPoint*> others;
  for (const int id : map.keyframe(keyframe).point_of_feature)
    if (id >= 0) others.push_back(&map.point(id));
  for (const int i : located.looked_for) {
    if (left_out[static_cast<std::size_t>(i)]) continue;
    const Candidate& candidate = located.candidates[static_cast<std::size_t>(i)];
    const double apart = kApart * (candidate.position - center).norm();
    left_out[static_cast<std::size_t>(i)] =
        std::any_of(others.begin(), others.end(), [&](const MapPoint* other) {
          return Distance(candidate.descriptor, other->descriptor) <= kTwinBits &&
                 (candidate.position - other->position).squaredNorm() > apart * apart;
        });
  }
}

}  // namespace ulf::tracking
