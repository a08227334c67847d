#include "tracking/estimation/relative_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"
#include "core/geometry/triangulation.h"
#include "tracking/estimation/opengv_bridge.h"
#include "tracking/estimation/sampling.h"

namespace ulf::tracking {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// These are guessed, except where a line says so.
constexpr int kMinReconstructed = 60;        // points in front of both views
constexpr double kMaxDirectionSigmaDeg = 4;  // standard deviation of the translation's direction
constexpr int kMinPairs = 20;                // fewer give no motion
constexpr double kDifferentDeg = 10;  // motions are clearly different whose translations' axes differ by more
// Samples that are drawn for each model at most. The last are for a rival of the essential matrix: most
// samples lead to either, so a few find the other.
constexpr int kRotationSamples = 300, kEssentialSamples = 500, kHomographySamples = 500, kRivalSamples = 40;
// A homography constrains a point in two directions, the essential matrix in one: a scene is flat where the
// homography explains this share of what the essential matrix does.
constexpr double kFlatShare = 0.85;
// A rotation takes up most of a distant wall's parallax, not nine tenths of it: where a rotation explains
// more than this share of the matches and leaves less than this share of the parallax that is needed, the
// search, which costs more than tracking a frame, cannot end well.
constexpr double kEarlyRotationShare = 0.9, kLeastLeftOver = 0.1;
// A rotation that explains more than this share of the matches that a motion explains is preferred to it.
constexpr double kRotationShare = 0.9;
constexpr int kSettlingPairs = 200;  // pairs on which far starts are refined before all take part
// rays that meet behind a camera by more times the noise are outliers
constexpr double kSurelyBehind = 5;
constexpr double kLeastNoiseRad = 1e-6;  // standard deviation of the epipolar error, at least
// The best other motion must be worse by so many variances of the noise, by this many a pair (unmodelled
// errors make some percent), and by what outliers make that lie in a motion's band by chance, with this
// probability.
constexpr double kLeastMotionMargin = 60, kMarginPerPair = 0.25, kChanceInBand = 0.03;
constexpr double kMostGrowth = 100;  // of that excess, where the parallax that would suffice is predicted

constexpr double kWider = 1.5;  // the gate of refinements over the sampler's threshold

std::optional<Matrix3d> RotationFromPairs(std::span<const RayPair> pairs, const std::vector<int>& used) {
  Matrix3d correlation = Matrix3d::Zero();
  for (const int i : used) {
    const RayPair& pair = pairs[At(i)];
    correlation += pair.second * pair.first.transpose();
  }
  const SingularValues3 svd = SingularValuesOf(correlation);
  if (!(svd.values(1) > 1e-12)) return std::nullopt;
  Matrix3d flip = Matrix3d::Identity();
  flip(2, 2) = (svd.u * svd.v.transpose()).determinant();
  return Matrix3d(svd.u * flip * svd.v.transpose());
}

std::optional<SamplingResult<Matrix3d>> SampleRotation(std::span<const RayPair> pairs,
                                                       const SamplingOptions& options) {
  return SampleConsensusByFit<Matrix3d>(
      static_cast<int>(pairs.size()), 2,
      [&](const std::vector<int>& used) { return RotationFromPairs(pairs, used); },
      [&](const Matrix3d& rotation, int i) {
        return (rotation * pairs[At(i)].first - pairs[At(i)].second).squaredNorm();
      },
      options);
}

// Compares the axes of translation: the points decide its sign.
bool DirectionsDiffer(const Rigid3& a, const Rigid3& b) {
  return std::acos(std::min(1.0, std::abs(a.translation.dot(b.translation)))) > Radians(kDifferentDeg);
}

// `counts(motion)`: whether a motion may be the result.
template <typename Counts>
std::optional<SamplingResult<Motion>> SampleEssential(std::span<const RayPair> pairs,
                                                      const SamplingOptions& options, const Counts& counts) {
  const auto solve = [&](const std::vector<int>& sample) {
    std::array<Vector3d, 5> first, second;
    for (std::size_t k = 0; k < 5; ++k) {
      first[k] = pairs[At(sample[k])].first;
      second[k] = pairs[At(sample[k])].second;
    }
    std::vector<Motion> motions;
    for (const Matrix3d& essential : SolveFivePoint(first, second)) {
      // The sample's own five pairs suffice to choose the sign of translation.
      if (const auto motion = BestMotion(essential, pairs, sample); motion && counts(*motion))
        motions.push_back(*motion);
    }
    return motions;
  };
  const auto residual2 = [&](const Motion& motion, int i) {
    const double error = EpipolarError(motion.essential, pairs[At(i)]);
    return error * error;
  };
  const auto improve = [&](const Motion& motion, const std::vector<int>& inliers) -> std::optional<Motion> {
    if (inliers.size() < 8) return std::nullopt;
    const Motion refined = RefineMotion(motion, pairs, inliers, kWider * options.threshold, 4);
    return counts(refined) ? std::optional(refined) : std::nullopt;
  };
  return SampleConsensus<Motion>(static_cast<int>(pairs.size()), 5, solve, residual2, improve, options);
}

// Estimates H with second ~ H first from four or more pairs of unit rays (direct linear transform).
std::optional<Matrix3d> HomographyFromPairs(std::span<const RayPair> pairs, const std::vector<int>& used) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (const int i : used) {
    const RayPair& pair = pairs[At(i)];
    Eigen::Matrix<double, 3, 9> rows;  // [second]x H first = 0, H row by row
    const Matrix3d cross = CrossMatrix(pair.second);
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < 3; ++k) rows.block<1, 3>(r, 3 * k) = cross(r, k) * pair.first.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::VectorXd h = EigenvaluesOfAnySize(normal).vectors.col(0);
  Matrix3d homography = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
  const double determinant = homography.determinant();
  if (std::abs(determinant) < 1e-9) return std::nullopt;
  // det > 0 puts both views on one side of the plane.
  return Matrix3d(homography / std::cbrt(determinant));
}

std::optional<SamplingResult<Matrix3d>> SampleHomography(std::span<const RayPair> pairs,
                                                         const SamplingOptions& options) {
  return SampleConsensusByFit<Matrix3d>(
      static_cast<int>(pairs.size()), 4,
      [&](const std::vector<int>& used) { return HomographyFromPairs(pairs, used); },
      [&](const Matrix3d& homography, int i) {
        return ((homography * pairs[At(i)].first).normalized() - pairs[At(i)].second).squaredNorm();
      },
      options);
}

std::vector<Rigid3> DecomposeHomography(const Matrix3d& homography) {
  cv::Mat matrix;
  cv::eigen2cv(homography, matrix);
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(matrix, cv::Mat::eye(3, 3, CV_64F), rotations, translations, normals);
  std::vector<Rigid3> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    Matrix3d rotation;
    Vector3d translation;
    cv::cv2eigen(rotations[i], rotation);
    cv::cv2eigen(translations[i], translation);
    if (translation.norm() < 1e-9 || rotation.determinant() < 0.5) continue;
    poses.push_back({Eigen::Quaterniond(rotation).normalized(), translation.normalized()});
  }
  return poses;
}

// The points that a motion gives: in front of both views, with reprojections that agree.
struct Reconstruction {
  Rigid3 pose;
  std::vector<std::optional<Vector3d>> points;
  int count = 0;
  double median_parallax_deg = 0;
};

Reconstruction Reconstruct(const Rigid3& pose, std::span<const RayPair> pairs, double threshold) {
  Reconstruction result{pose, std::vector<std::optional<Vector3d>>(pairs.size()), 0, 0};
  const Vector3d center2 = pose.OriginInSource();
  std::vector<double> parallax_deg;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto point = TriangulatePoint(Rigid3{}, pairs[i].first, pose, pairs[i].second);
    if (!point || AngleBetween(*point, pairs[i].first) > threshold ||
        AngleBetween(pose * *point, pairs[i].second) > threshold)
      continue;
    result.points[i] = point;
    ++result.count;
    parallax_deg.push_back(Degrees(ParallaxAngle(*point, Vector3d::Zero(), center2)));
  }
  result.median_parallax_deg = Median(parallax_deg);
  return result;
}

// The motion of least truncated epipolar cost, and by how much the best clearly different one is worse.
struct MotionChoice {
  std::optional<Motion> best;
  double noise = 0;      // standard deviation of the epipolar error, radians
  double runner_up = 0;  // excess cost over noise²
};

// Directions of translation over a half sphere: the points decide the sign.
std::vector<Vector3d> FanOfDirections() {
  std::vector<Vector3d> fan;
  for (const double x : {-1.0, 0.0, 1.0})
    for (const double y : {-1.0, 0.0, 1.0})
      for (const double z : {0.0, 1.0})
        if (z > 0 || y > 0 || (y == 0 && x > 0)) fan.push_back(Vector3d(x, y, z).normalized());
  return fan;
}

// Refines a start on all pairs; a far one first on some of them, within a gate that closes.
std::optional<Motion> SettleMotion(const Rigid3& start, bool far, std::span<const RayPair> pairs,
                                   const std::vector<int>& all, double threshold) {
  Motion motion(start);
  if (far) {
    std::vector<int> some;
    const std::size_t step = std::max<std::size_t>(1, all.size() / At(kSettlingPairs));
    for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
    for (const double widen : {8.0, 4.0, 2.0})
      motion = RefineMotion(motion, pairs, some, widen * threshold, 4);
  }
  motion = RefineMotion(motion, pairs, all, kWider * threshold);
  std::vector<int> near;
  for (const int i : all)
    if (EpipolarError(motion.essential, pairs[At(i)]) < threshold) near.push_back(i);
  if (near.size() < At(kMinPairs)) return std::nullopt;
  auto in_front = BestMotion(motion.essential, pairs, near);
  if (in_front) in_front->direction_sigma = motion.direction_sigma;
  return in_front;
}

MotionChoice ChooseMotion(const std::vector<std::pair<Rigid3, bool>>& starts, std::span<const RayPair> pairs,
                          double threshold) {
  std::vector<Motion> motions;
  std::vector<int> all(pairs.size());
  std::iota(all.begin(), all.end(), 0);
  for (const auto& [start, far] : starts)
    if (const auto motion = SettleMotion(start, far, pairs, all, threshold)) motions.push_back(*motion);
  MotionChoice choice;
  if (motions.empty()) return choice;
  const auto costs_by = [&](const auto& cost_of) {
    std::vector<double> costs;
    for (const Motion& motion : motions) costs.push_back(cost_of(motion));
    return costs;
  };
  const auto index_of_least = [](const std::vector<double>& costs) {
    return At(std::ranges::min_element(costs) - costs.begin());
  };
  const std::size_t nearest = index_of_least(
      costs_by([&](const Motion& motion) { return TruncatedCost(motion, pairs, all, threshold); }));
  std::vector<double> errors;
  for (const RayPair& pair : pairs) {
    const double error = EpipolarError(motions[nearest].essential, pair);
    if (error < threshold) errors.push_back(error);
  }
  constexpr double kSigmaOverMedian = 1.4826;  // of a normal error's absolute value
  choice.noise = std::max(kLeastNoiseRad, kSigmaOverMedian * Median(errors));
  // A plane's second motion fits the epipolar lines as well, but puts many points behind the cameras: visible
  // where the noise is small enough.
  const std::vector<double> costs = costs_by([&](const Motion& motion) {
    return CostInFront(motion, pairs, threshold, std::min(2 * threshold, kSurelyBehind * choice.noise));
  });
  const std::size_t best = index_of_least(costs);
  choice.best = motions[best];
  double runner_up = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < motions.size(); ++i)
    if (DirectionsDiffer(motions[i].second_from_first, choice.best->second_from_first))
      runner_up = std::min(runner_up, costs[i] - costs[best]);
  choice.runner_up = runner_up / (choice.noise * choice.noise);
  // Refine within a narrower gate: outliers that lie in the threshold's band by chance pull no longer.
  const double direction_sigma = choice.best->direction_sigma;
  if (const auto polished =
          BestMotion(RefineMotion(*choice.best, pairs, all, std::min(threshold, 4 * choice.noise)).essential,
                     pairs, all)) {
    choice.best = polished;
    choice.best->direction_sigma = direction_sigma;
  }
  return choice;
}

}  // namespace

const char* Name(RelativePoseOutcome outcome) {
  constexpr std::array kNames{"found",          "too few matches", "rotation only",      "low parallax",
                              "too few points", "ambiguous",       "conflicting motions"};
  return kNames[static_cast<std::size_t>(outcome)];
}

Eigen::Quaterniond FitRotation(std::span<const RayPair> pairs, double focal_px, double threshold_px,
                               unsigned seed) {
  const auto found = SampleRotation(
      pairs, {.threshold = threshold_px / focal_px, .max_iterations = kRotationSamples, .seed = seed});
  return found ? Eigen::Quaterniond(found->model).normalized() : Eigen::Quaterniond::Identity();
}

RelativePoseResult RelativePose(std::span<const RayPair> pairs, const RelativePoseOptions& options) {
  RelativePoseResult result;
  result.parallax_needed_deg = options.min_parallax_deg;
  if (static_cast<int>(pairs.size()) < kMinPairs) return result;
  const double threshold = options.threshold_px / options.focal_px;

  const auto share_of_pairs = [&](double share) { return share * static_cast<double>(pairs.size()); };

  const auto rotation = SampleRotation(
      pairs, {.threshold = kWider * threshold, .max_iterations = kRotationSamples, .seed = options.seed});
  if (rotation) {
    std::vector<double> left_over;
    for (const RayPair& pair : pairs)
      left_over.push_back(Degrees(AngleBetween(rotation->model * pair.first, pair.second)));
    result.median_parallax_deg = Median(left_over);
    const bool hardly_any_parallax = result.median_parallax_deg < kLeastLeftOver * options.min_parallax_deg;
    const double explained = static_cast<double>(rotation->inliers.size());
    if (hardly_any_parallax && explained > share_of_pairs(kEarlyRotationShare)) {
      result.outcome = RelativePoseOutcome::kRotationOnly;
      return result;
    }
  }
  const auto essential = SampleEssential(
      pairs, {.threshold = threshold, .max_iterations = kEssentialSamples, .seed = options.seed + 1},
      [](const Motion&) { return true; });
  const auto homography = SampleHomography(
      pairs, {.threshold = threshold, .max_iterations = kHomographySamples, .seed = options.seed + 2});
  const bool flat = homography && essential &&
                    static_cast<double>(homography->inliers.size()) >
                        kFlatShare * static_cast<double>(essential->inliers.size());
  result.model = flat ? RelativePoseModel::kHomography : RelativePoseModel::kEssential;
  std::vector<std::pair<Rigid3, bool>> starts;  // and whether it may be far off
  if (essential) {
    starts.emplace_back(essential->model.second_from_first, false);
    // Points on a ruled quadric through both centres have a second motion that explains them all.
    const auto other = [&](const Motion& motion) {
      return DirectionsDiffer(motion.second_from_first, essential->model.second_from_first);
    };
    if (const auto rival = SampleEssential(
            pairs, {.threshold = threshold, .max_iterations = kRivalSamples, .seed = options.seed + 3},
            other))
      starts.emplace_back(rival->model.second_from_first, false);
  }
  if (homography)
    for (const Rigid3& pose : DecomposeHomography(homography->model)) starts.emplace_back(pose, false);
  if (rotation)
    for (const Vector3d& direction : FanOfDirections())
      starts.emplace_back(Rigid3{Eigen::Quaterniond(rotation->model).normalized(), direction}, true);
  const MotionChoice choice = ChooseMotion(starts, pairs, threshold);
  // Any motion fits the matches of a rotation. So compare what the best motion explains with what the
  // rotation does, whose residual has two dimensions and the noise of both views.
  const double noise = std::max(choice.noise, 0.05 * threshold);
  const auto explained = !choice.best ? 0 : std::ranges::count_if(pairs, [&](const RayPair& pair) {
    return EpipolarError(choice.best->essential, pair) < std::min(threshold, 3 * noise);
  });
  const auto turned = !rotation ? 0 : std::ranges::count_if(pairs, [&](const RayPair& pair) {
    return (rotation->model * pair.first - pair.second).norm() < (choice.best ? 4.5 * noise : threshold);
  });
  if (turned >= kMinPairs && static_cast<double>(turned) > kRotationShare * static_cast<double>(explained)) {
    result.outcome = RelativePoseOutcome::kRotationOnly;
    return result;
  }
  if (!choice.best) return result;
  result.direction_sigma_deg = Degrees(choice.best->direction_sigma * choice.noise);
  const auto support = [](const auto& found) { return found ? static_cast<int>(found->inliers.size()) : 0; };
  result.evidence = {static_cast<int>(pairs.size()),
                     static_cast<int>(turned),
                     support(homography),
                     support(essential),
                     choice.runner_up,
                     0};
  const double outliers = static_cast<double>(pairs.size()) - static_cast<double>(explained);
  const double by_chance = (2 + 3 * std::sqrt(2 * kChanceInBand * outliers)) * threshold * threshold /
                           (choice.noise * choice.noise);
  const double margin = std::max(kLeastMotionMargin, share_of_pairs(kMarginPerPair)) + by_chance;
  result.evidence.runner_up_needed = margin;
  if (choice.runner_up < margin) {
    result.outcome = RelativePoseOutcome::kAmbiguous;
    // The excess grows with the square of the parallax.
    const double growth = std::clamp(margin / std::max(1e-9, choice.runner_up), 1.0, kMostGrowth);
    result.parallax_needed_deg =
        std::max(options.min_parallax_deg, result.median_parallax_deg * std::sqrt(growth));
    return result;
  }
  const Reconstruction reconstruction = Reconstruct(choice.best->second_from_first, pairs, 2 * threshold);
  result.points = reconstruction.count;
  if (reconstruction.count < share_of_pairs(options.min_point_share)) {
    result.outcome = RelativePoseOutcome::kConflicting;
    return result;
  }
  if (reconstruction.count < kMinReconstructed) {
    result.outcome = RelativePoseOutcome::kTooFewPoints;
    return result;
  }
  result.median_parallax_deg = reconstruction.median_parallax_deg;
  if (reconstruction.median_parallax_deg < options.min_parallax_deg ||
      result.direction_sigma_deg > kMaxDirectionSigmaDeg) {
    result.outcome = RelativePoseOutcome::kLowParallax;
    // The direction's error falls as the parallax grows.
    result.parallax_needed_deg =
        std::max(options.min_parallax_deg,
                 result.median_parallax_deg * result.direction_sigma_deg / kMaxDirectionSigmaDeg);
    return result;
  }
  result.outcome = RelativePoseOutcome::kFound;
  result.second_from_first = reconstruction.pose;
  result.points_in_first = reconstruction.points;
  return result;
}

}  // namespace ulf::tracking
