#include "tracking/map/pose_log_odds.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/at.h"
#include "tracking/features/matching.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Checked by the tests of relocalisation (docs/measured/tracking.md, "Found again"); guessed one by one.
constexpr int kOddsColumns = 4,
              kOddsRows = 3;  // of the grid: smaller cells hold too few points, larger ones hide as a whole
constexpr double kOddsByChance = 0.05;  // share of the searched points that a wrong pose finds, at most
constexpr double kOddsHidden = 0.5;     // prior probability that a cell is hidden
constexpr double kOddsSpread = 0.4;     // relative spread of the counts from cell to cell
constexpr double kOddsUnnoticed = 0.1;  // share of the repetitive points that is not excluded

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

double PoseLogOdds(const CameraModel& camera, const FramePose& frame_pose,
                   const ExcludedCandidates& left_out) {
  struct Cell {
    double looked_for = 0, expected = 0, found = 0, repeats = 0;
  };
  std::vector<Cell> cells(At(kOddsColumns * kOddsRows));
  const auto cell_of = [&](const Vector2d& img) -> Cell& {
    return cells[CellOf(img, camera, kOddsColumns, kOddsRows)];
  };
  const auto counts = [&](int i) { return left_out.empty() || !left_out[At(i)]; };
  for (const int i : frame_pose.looked_for) {
    const Candidate& candidate = frame_pose.candidates[At(i)];
    const auto img = camera.ImgFromCam(frame_pose.cam_from_world * candidate.position);
    if (!img || !counts(i)) continue;
    Cell& cell = cell_of(*img);
    ++cell.looked_for;
    cell.expected += candidate.find_rate;
  }
  for (const PointMatch& match : frame_pose.matches) {
    Cell& cell = cell_of(match.img);
    ++(counts(match.candidate) ? cell.found : cell.repeats);
  }
  double evidence = 0;
  for (const Cell& cell : cells) {
    const double by_chance = kOddsByChance * cell.looked_for + kOddsUnnoticed * cell.repeats;
    if (by_chance == 0) continue;
    const double chance = LogCount(cell.found, by_chance, kOddsSpread);
    const double visible = LogCount(cell.found, std::max(cell.expected, by_chance), kOddsSpread);
    evidence += LogMixture(visible, chance, kOddsHidden) - chance;
  }
  return evidence;
}

void ExcludeAmbiguousMatches(const CameraModel& camera, const FeatureSet& picture,
                             const FramePose& frame_pose, ExcludedCandidates& left_out) {
  struct Look {
    const Descriptor* descriptor;
    Vector2d img;
    double apart_px;
  };
  std::vector<Look> looks;
  std::vector<std::optional<Vector2d>> img_of(frame_pose.candidates.size());
  for (const Feature& feature : picture.all())
    looks.push_back({&feature.descriptor, feature.img, kRepetitionApartPx * LevelScale(feature.level)});
  for (const int i : frame_pose.in_view) {
    const Candidate& candidate = frame_pose.candidates[At(i)];
    const auto img = camera.ImgFromCam(frame_pose.cam_from_world * candidate.position);
    if (!img) continue;
    img_of[At(i)] = img;
    const double distance = (frame_pose.cam_from_world * candidate.position).norm();
    looks.push_back({&candidate.descriptor, *img,
                     kRepetitionApartPx * LevelScale(NearestLevel(candidate.reference_distance / distance))});
  }
  left_out.resize(frame_pose.candidates.size(), false);
  for (const int i : frame_pose.looked_for) {
    const auto& img = img_of[At(i)];
    if (left_out[At(i)] || !img) continue;
    const Descriptor& descriptor = frame_pose.candidates[At(i)].descriptor;
    left_out[At(i)] = std::ranges::any_of(looks, [&](const Look& other) {
      return Distance(descriptor, *other.descriptor) <= kSureDistance &&
             (*img - other.img).squaredNorm() > other.apart_px * other.apart_px;
    });
  }
}

void ExcludeAmbiguousMatches(const Map& map, int keyframe, const FramePose& frame_pose,
                             ExcludedCandidates& left_out, double apart_share) {
  left_out.resize(frame_pose.candidates.size(), false);
  const Vector3d center = frame_pose.cam_from_world.OriginInSource();
  std::vector<const MapPoint*> others;
  for (const int id : map.PointsSeenBy(keyframe)) others.push_back(&map.point(id));
  for (const int i : frame_pose.looked_for) {
    if (left_out[At(i)]) continue;
    const Candidate& candidate = frame_pose.candidates[At(i)];
    const double apart = apart_share * (candidate.position - center).norm();
    left_out[At(i)] = std::ranges::any_of(others, [&](const MapPoint* other) {
      return Distance(candidate.descriptor, other->descriptor) <= kSureDistance &&
             (candidate.position - other->position).squaredNorm() > apart * apart;
    });
  }
}

}  // namespace ulf::tracking
