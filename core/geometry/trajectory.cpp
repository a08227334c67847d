#include "core/geometry/trajectory.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"

namespace ulf {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::vector<TimedPose> ReadTum(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file)
    throw Error("{}: cannot be read; give a file with lines `time tx ty tz qx qy qz qw`", path.string());
  std::vector<TimedPose> poses;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (number == 1 && line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
    const auto start = line.find_first_not_of(" \t\r");
    if (start == std::string::npos || line[start] == '#') continue;
    std::istringstream fields(line);
    double time_s, x, y, z, qx, qy, qz, qw;
    if (!(fields >> time_s >> x >> y >> z >> qx >> qy >> qz >> qw))
      throw Error("{}:{}: expected eight numbers `time tx ty tz qx qy qz qw`, found \"{}\"", path.string(),
                  number, line);
    const Eigen::Quaterniond rotation(qw, qx, qy, qz);
    const Rigid3 cam_from_world = Rigid3{rotation.normalized(), {x, y, z}}.Inverse();
    const bool is_finite = std::isfinite(time_s) && cam_from_world.translation.allFinite();
    if (!is_finite || !(std::abs(rotation.norm() - 1) < 1e-2))
      throw Error("{}:{}: not a pose: the quaternion must have length 1 and all numbers be finite",
                  path.string(), number);
    poses.push_back({time_s, cam_from_world});
  }
  return poses;
}

void WriteTum(const std::filesystem::path& path, std::span<const TimedPose> poses, const std::string& note) {
  std::string text = "# time tx ty tz qx qy qz qw (camera to world)\n";
  if (!note.empty()) text += "# " + note + "\n";
  for (const TimedPose& pose : poses) {
    const Rigid3 world_from_cam = pose.cam_from_world.Inverse();
    const Vector3d& t = world_from_cam.translation;
    const Eigen::Quaterniond& q = world_from_cam.rotation;
    text += fmt::format("{:.9f} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n", pose.time_s, t.x(),
                        t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  WriteFileAtomically(path, text);
}

namespace {

double RootMeanSquare(const std::vector<double>& values) {
  double squared = 0;
  for (const double value : values) squared += value * value;
  return values.empty() ? 0 : std::sqrt(squared / static_cast<double>(values.size()));
}

struct Pair {
  double time_s;
  Rigid3 estimated;
  Rigid3 truth;
};

std::vector<Pair> PairByTime(std::span<const TimedPose> estimated, std::span<const TimedPose> truth,
                             double tolerance_s) {
  std::vector<TimedPose> sorted(truth.begin(), truth.end());
  std::ranges::sort(sorted, [](const TimedPose& a, const TimedPose& b) { return a.time_s < b.time_s; });
  std::vector<Pair> pairs;
  for (const TimedPose& pose : estimated) {
    auto after = std::lower_bound(sorted.begin(), sorted.end(), pose.time_s,
                                  [](const TimedPose& p, double time_s) { return p.time_s < time_s; });
    if (after != sorted.begin() &&
        (after == sorted.end() || pose.time_s - std::prev(after)->time_s < after->time_s - pose.time_s))
      --after;
    if (after != sorted.end() && std::abs(after->time_s - pose.time_s) <= tolerance_s)
      pairs.push_back({pose.time_s, pose.cam_from_world, after->cam_from_world});
  }
  return pairs;
}

// Averages each pair's estimate of the rotation between the two worlds.
Eigen::Quaterniond TruthFromEstimated(const std::vector<Pair>& pairs) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const Pair& pair : pairs) {
    const Eigen::Vector4d one = (pair.truth.rotation.conjugate() * pair.estimated.rotation).coeffs();
    sum += one.dot(sum) < 0 ? Eigen::Vector4d(-one) : one;
  }
  return Eigen::Quaterniond(sum).normalized();
}

}  // namespace

std::optional<TrajectoryError> CompareTrajectories(std::span<const TimedPose> estimated,
                                                   std::span<const TimedPose> truth, double tolerance_s,
                                                   double rpe_step_s) {
  const std::vector<Pair> pairs = PairByTime(estimated, truth, tolerance_s);
  std::vector<Vector3d> source, target;
  for (const Pair& pair : pairs) {
    source.push_back(pair.estimated.OriginInSource());
    target.push_back(pair.truth.OriginInSource());
  }
  const auto similarity = AlignPoints(source, target);
  if (!similarity) return std::nullopt;
  TrajectoryError error;
  error.matched = static_cast<int>(pairs.size());
  error.scale = similarity->scale;
  error.truth_from_estimated = *similarity;
  std::vector<double> distances, angles;
  const Eigen::Quaterniond world_turn = TruthFromEstimated(pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    distances.push_back((*similarity * source[i] - target[i]).norm());
    const Matrix3d world_from_cam = similarity->rotation * pairs[i].estimated.RotationMatrix().transpose();
    angles.push_back(RotationAngle(Eigen::Quaterniond(pairs[i].truth.RotationMatrix() * world_from_cam)));
    error.errors.push_back({pairs[i].time_s, distances.back(),
                            Degrees(RotationAngle(pairs[i].truth.rotation * world_turn *
                                                  pairs[i].estimated.rotation.conjugate()))});
  }
  error.ate_rmse = RootMeanSquare(distances);
  error.ate_median = Median(distances);
  error.ate_max = *std::ranges::max_element(distances);
  error.rotation_rmse_deg = Degrees(RootMeanSquare(angles));

  // The truth may be sparse: take the step nearest to rpe_step_s and scale its error to that length.
  std::vector<double> spacing_s, step_errors, step_angles, step_drifts;
  for (std::size_t i = 1; i < pairs.size(); ++i) spacing_s.push_back(pairs[i].time_s - pairs[i - 1].time_s);
  constexpr double kHalfSpacing = 0.51;  // half a spacing, with room for rounding
  const double step_tolerance_s = std::max(tolerance_s, kHalfSpacing * Median(spacing_s));
  const auto off_s = [&](std::size_t i, std::size_t j) {
    return std::abs(pairs[j].time_s - pairs[i].time_s - rpe_step_s);
  };
  std::size_t j = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    j = std::max(j, i);
    while (j + 1 < pairs.size() && off_s(i, j + 1) <= off_s(i, j)) ++j;
    if (j == i || off_s(i, j) > step_tolerance_s) continue;
    const double share = rpe_step_s / (pairs[j].time_s - pairs[i].time_s);
    // Motion of j in i's camera frame, estimated (in truth units) against true.
    const Vector3d moved = similarity->scale * (pairs[i].estimated.rotation * (source[j] - source[i]));
    const Vector3d true_move = pairs[i].truth.rotation * (target[j] - target[i]);
    step_errors.push_back(share * (moved - true_move).norm());
    if (true_move.norm() > 0) step_drifts.push_back((moved - true_move).norm() / true_move.norm());
    const Eigen::Quaterniond turned = pairs[j].estimated.rotation * pairs[i].estimated.rotation.conjugate();
    const Eigen::Quaterniond true_turn = pairs[j].truth.rotation * pairs[i].truth.rotation.conjugate();
    step_angles.push_back(share * RotationAngle(turned * true_turn.conjugate()));
  }
  error.steps = static_cast<int>(step_errors.size());
  error.rpe_rmse = RootMeanSquare(step_errors);
  error.rpe_rotation_rmse_deg = Degrees(RootMeanSquare(step_angles));
  error.drift = Median(step_drifts);
  return error;
}

}  // namespace ulf
