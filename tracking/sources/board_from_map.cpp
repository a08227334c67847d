#include "tracking/sources/board_from_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace ulf::tracking {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kBoardMostPairs = 400, kBoardLeastPairs = 4;  // of poses. Guessed
// One standard deviation of the scale; above it the map's adjustment would have too far to go. Guessed.
constexpr double kBoardMaxScaleError = 0.05;
// The least standard deviation of a board's pose, as a share of its distance, whatever its corners say.
// Guessed.
constexpr double kBoardLeastSigma = 1e-4;
constexpr int kBoardRounds = 3;         // the fit is weighted anew so many times. Guessed
constexpr double kBoardGateSigmas = 3;  // pairs with larger errors weigh less. Guessed

}  // namespace

void BoardFromMap::Add(const Anchored& anchor, const MarkerPose& pose) {
  pairs_.push_back(
      {anchor, pose.cam_from_world, std::max(pose.center_sigma, kBoardLeastSigma * pose.distance)});
  // Keep both ends: they determine the scale.
  if (pairs_.size() > kBoardMostPairs)
    pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(kBoardMostPairs / 2));
}

std::optional<Similarity3> BoardFromMap::Fit(const Tracker& tracker) const {
  if (pairs_.size() < kBoardLeastPairs) return std::nullopt;
  std::vector<Rigid3> in_map;
  std::vector<double> weights;
  for (const Pair& pair : pairs_) {
    in_map.push_back(tracker.PoseOf(pair.anchor));
    weights.push_back(1 / (pair.sigma * pair.sigma));
  }
  std::optional<Similarity3> fitted;
  for (int round = 0; round < kBoardRounds; ++round) {
    fitted = Fit(in_map, weights);
    if (!fitted) return std::nullopt;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const double off =
          (*fitted * in_map[i].OriginInSource() - pairs_[i].cam_from_board.OriginInSource()).norm();
      weights[i] = std::min(1.0, kBoardGateSigmas * pairs_[i].sigma / std::max(1e-12, off)) /
                   (pairs_[i].sigma * pairs_[i].sigma);
    }
  }
  return fitted;
}

std::optional<Similarity3> BoardFromMap::Fit(const std::vector<Rigid3>& in_map,
                                             const std::vector<double>& weights) const {
  Eigen::Matrix4d turns = Eigen::Matrix4d::Zero();
  Vector3d mean_map = Vector3d::Zero(), mean_board = Vector3d::Zero();
  double total = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Eigen::Quaterniond turn = pairs_[i].cam_from_board.rotation.conjugate() * in_map[i].rotation;
    turns += weights[i] * turn.coeffs() * turn.coeffs().transpose();
    mean_map += weights[i] * in_map[i].OriginInSource();
    mean_board += weights[i] * pairs_[i].cam_from_board.OriginInSource();
    total += weights[i];
  }
  mean_map /= total;
  mean_board /= total;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> axes(turns);
  const Eigen::Quaterniond turn(Eigen::Vector4d(axes.eigenvectors().col(3)));
  Similarity3 fitted;
  fitted.rotation = turn.normalized().toRotationMatrix();
  double across = 0, along = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Vector3d in_turned_map = fitted.rotation * (in_map[i].OriginInSource() - mean_map);
    across += weights[i] * in_turned_map.dot(pairs_[i].cam_from_board.OriginInSource() - mean_board);
    along += weights[i] * in_turned_map.squaredNorm();
  }
  if (!(along > 0) || !(across > 0)) return std::nullopt;
  fitted.scale = across / along;
  // The scale's standard deviation: each centre's error over its distance from their middle.
  if (1 / std::sqrt(along * fitted.scale * fitted.scale) > kBoardMaxScaleError) return std::nullopt;
  fitted.translation = mean_board - fitted.scale * (fitted.rotation * mean_map);
  return fitted;
}

}  // namespace ulf::tracking
