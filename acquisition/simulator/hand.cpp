#include "acquisition/simulator/hand.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace ulf::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// All guessed.
constexpr double kRoundingS = 0.35;       // corners of the path are rounded over twice this
constexpr double kGlanceS = 1.5;          // duration of a look away
constexpr double kPauseRampS = 0.3;       // the hand stops and starts over this time
constexpr double kDistanceChange = 0.05;  // at most, as a share of HandOptions::distance_m
constexpr double kDollyPeriodS = 12;      // once nearer, once farther, and back
constexpr double kPlannedS = 3 * 3600;    // afterwards the hand rests
constexpr double kAwayShare = 0.1;        // of a glance: above it the hand counts as looking away
enum WaveStream {
  kPositionX,
  kPositionY,
  kPositionZ,
  kYaw,
  kPitch,
  kRoll,
  kDistance,
  kRowWobble,
  kSpeed,
  kStreams
};

double Uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

// Returns the path time that a pause has cost, `since` seconds after its start. The path's speed falls along
// a cosine, rests, and rises again.
double PauseSpent(double since, double rest_s) {
  const double ramp = kPauseRampS;
  const auto lost_in_ramp = [&](double t) { return 0.5 * (t - ramp / M_PI * std::sin(M_PI * t / ramp)); };
  double spent = lost_in_ramp(std::clamp(since, 0.0, ramp));
  spent += std::clamp(since - ramp, 0.0, rest_s);
  const double after = std::clamp(since - ramp - rest_s, 0.0, ramp);
  return spent + after - lost_in_ramp(after);
}

}  // namespace

Hand::Hand(const HandOptions& options) : options_(options) {
  forward_ = options.first_direction.normalized();
  up_ = (options.up_in_world - options.up_in_world.dot(forward_) * forward_).normalized();
  side_ = up_.cross(forward_);

  // A height is the sum of the heights of all waves: the largest possible deflection. Positions are in
  // metres, angles in radians.
  waves_.resize(kStreams);
  const auto draw = [&](int stream, int count, double low_hz, double high_hz, double height) {
    return Waves(options.seed, stream, count, low_hz, high_hz, height);
  };
  const auto at = [this](int stream) -> Waves& { return waves_[static_cast<std::size_t>(stream)]; };
  for (const int stream : {kPositionX, kPositionY, kPositionZ}) {
    at(stream) = draw(stream, 3, 0.15, 0.8, 0.008);
    at(stream).Add(draw(stream + 100, 4, 4, 9, 0.0007));
  }
  for (const int stream : {kYaw, kPitch, kRoll}) {
    const double drift = stream == kRoll ? 2.5 : 1.6;
    at(stream) = draw(stream, 3, 0.1, 0.5, Radians(drift));
    at(stream).Add(draw(stream + 100, 4, 4, 9, Radians(0.12)));
  }
  at(kDistance) = draw(kDistance, 3, 0.02, 0.12, kDistanceChange);
  at(kRowWobble) = draw(kRowWobble, 3, 0.1, 0.4, Radians(0.35));
  at(kSpeed) = draw(kSpeed, 2, 0.08, 0.2, 0.15);
  PlanPath();
  PlanGlances();
}

void Hand::AddStop(double seconds, const Vector2d& angles) {
  if (stops_.empty()) {
    stops_.push_back({0, angles, Vector2d::Zero()});
    return;
  }
  const Stop& last = stops_.back();
  stops_.push_back({last.time_s + seconds, angles, last.integral + 0.5 * seconds * (last.angles + angles)});
}

void Hand::PlanPath() {
  const double half_azimuth = 0.5 * options_.cap_azimuth + options_.margin;
  const double half_elevation = 0.5 * options_.cap_elevation + options_.margin;
  const auto go_to = [&](const Vector2d& angles, double speed_share) {
    AddStop(std::max(0.15, (angles - stops_.back().angles).norm() / (options_.speed * speed_share)), angles);
  };
  // Sideways first, because a tracker needs translation to initialise.
  AddStop(0, {0, 0});
  AddStop(0.3, {0, 0});
  go_to({Radians(3.5), 0}, 0.6);
  go_to({Radians(-3.5), Radians(1.5)}, 0.6);
  go_to({0, 0}, 0.6);
  const int rows = static_cast<int>(std::ceil(2 * half_elevation / options_.row_spacing)) + 1;
  double shift = 0;
  bool downwards = true, rightwards = false;
  for (int pass = 0; stops_.back().time_s < kPlannedS; ++pass) {
    for (int i = 0; i < rows; ++i) {
      const int row = downwards ? rows - 1 - i : i;
      const double elevation =
          std::min(half_elevation, -half_elevation + (row + shift) * 2 * half_elevation / (rows - 1));
      const double start = rightwards ? -half_azimuth : half_azimuth;
      go_to({start, elevation}, i == 0 ? 1.2 : 0.5);
      go_to({-start, elevation}, 1);
      rightwards = !rightwards;
    }
    if (pass == 0) first_pass_end_path_s_ = stops_.back().time_s;
    downwards = !downwards;
    // 1/2, 1/4, 3/4, 1/8, ... (van der Corput's sequence): halves the gaps between the rows so far.
    shift = 0;
    for (int bits = pass + 1, step = 2; bits > 0; bits >>= 1, step *= 2)
      shift += (bits & 1) / static_cast<double>(step);
  }
}

void Hand::PlanGlances() {
  if (!options_.looks_away) return;
  std::mt19937_64 random(options_.seed * 1000003u + 7777u);
  double start = 14;
  while (start < 2 * kPlannedS) {
    start += 6 + 22 * Uniform(random);
    const double side = Uniform(random) < 0.5 ? -1 : 1;
    glances_.push_back({start, side * Radians(40 + 8 * Uniform(random)), Radians(10 * Uniform(random) - 2)});
    start += kGlanceS;
  }
}

// Returns the integral of the planned angles over path time: piecewise parabolas.
Vector2d Hand::PathIntegral(double path_s) const {
  if (path_s <= stops_.front().time_s) return path_s * stops_.front().angles;
  if (path_s >= stops_.back().time_s)
    return stops_.back().integral + (path_s - stops_.back().time_s) * stops_.back().angles;
  const auto next = std::upper_bound(stops_.begin(), stops_.end(), path_s,
                                     [](double t, const Stop& stop) { return t < stop.time_s; });
  const auto from = next - 1;
  const double since = path_s - from->time_s;
  const Vector2d rate = (next->angles - from->angles) / (next->time_s - from->time_s);
  return from->integral + since * from->angles + 0.5 * since * since * rate;
}

// The mean over a window turns the plan's corners into parabolas, so that position and velocity are
// continuous.
Vector2d Hand::PathAngles(double path_s) const {
  return (PathIntegral(path_s + kRoundingS) - PathIntegral(path_s - kRoundingS)) / (2 * kRoundingS);
}

double Hand::PathTime(double time_s) const {
  double path_s = time_s;
  for (const Glance& glance : glances_) {
    const double pause_start = glance.start_s - kPauseRampS;
    if (time_s <= pause_start) break;
    path_s -= PauseSpent(time_s - pause_start, kGlanceS);
  }
  // The hand's speed varies by the sum of these waves and never becomes negative.
  for (const Waves::Wave& wave : waves_[kSpeed].parts()) {
    const double rate = 2 * M_PI * wave.frequency_hz;
    path_s += wave.height / rate * (std::cos(wave.phase) - std::cos(rate * path_s + wave.phase));
  }
  return path_s;
}

double Hand::GlanceShare(double time_s, const Glance& glance) const {
  const double since = (time_s - glance.start_s) / kGlanceS;
  if (since <= 0 || since >= 1) return 0;
  const double rise = std::sin(M_PI * since);
  return rise * rise;
}

bool Hand::LooksAway(double time_s) const {
  return std::any_of(glances_.begin(), glances_.end(),
                     [&](const Glance& glance) { return GlanceShare(time_s, glance) > kAwayShare; });
}

double Hand::FirstPassEndS() const {
  double low = 0, high = first_pass_end_path_s_ * 2 + 60;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (PathTime(middle) < first_pass_end_path_s_ ? low : high) = middle;
  }
  return high;
}

Rigid3 Hand::CamFromWorld(double time_s) const {
  Vector2d angles = PathAngles(PathTime(time_s));
  angles.y() += waves_[kRowWobble].At(time_s);
  const Vector3d direction =
      std::cos(angles.y()) * (std::cos(angles.x()) * forward_ + std::sin(angles.x()) * side_) +
      std::sin(angles.y()) * up_;
  const double dolly = std::pow(options_.dolly, -std::sin(2 * M_PI * time_s / kDollyPeriodS));
  const double distance = options_.distance_m * dolly * (1 + waves_[kDistance].At(time_s));
  const Vector3d sway(waves_[kPositionX].At(time_s), waves_[kPositionY].At(time_s),
                      waves_[kPositionZ].At(time_s));
  const Vector3d center = options_.subject_in_world + distance * direction + sway;
  const Rigid3 aimed = LookAt(center, options_.subject_in_world, options_.up_in_world);

  double yaw = waves_[kYaw].At(time_s), pitch = waves_[kPitch].At(time_s);
  for (const Glance& glance : glances_) {
    if (glance.start_s > time_s) break;
    const double share = GlanceShare(time_s, glance);
    yaw += share * glance.yaw;
    pitch += share * glance.pitch;
  }
  return Turned(aimed, yaw, pitch, waves_[kRoll].At(time_s));
}

Vector2d Hand::CapAngles(const Vector3d& center_in_world) const {
  const Vector3d direction = (center_in_world - options_.subject_in_world).normalized();
  return {std::atan2(direction.dot(side_), direction.dot(forward_)),
          std::asin(std::clamp(direction.dot(up_), -1.0, 1.0))};
}

Rigid3 Turned(const Rigid3& cam_from_world, double yaw, double pitch, double roll) {
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(roll, Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(pitch, Vector3d::UnitX()) *
                                  Eigen::AngleAxisd(yaw, Vector3d::UnitY());
  return Rigid3{turn, Vector3d::Zero()} * cam_from_world;
}

Waves::Waves(std::uint64_t seed, int stream, int count, double low_hz, double high_hz, double height) {
  std::mt19937_64 random(seed * 1000003u + static_cast<std::uint64_t>(stream));
  for (int i = 0; i < count; ++i) {
    const double share = (i + Uniform(random)) / count;
    parts_.push_back(
        {height / count, low_hz * std::pow(high_hz / low_hz, share), 2 * M_PI * Uniform(random)});
  }
}

void Waves::Add(const Waves& more) { parts_.insert(parts_.end(), more.parts_.begin(), more.parts_.end()); }

double Waves::At(double time_s) const {
  double sum = 0;
  for (const Wave& wave : parts_)
    sum += wave.height * std::sin(2 * M_PI * wave.frequency_hz * time_s + wave.phase);
  return sum;
}

}  // namespace ulf::acquisition
