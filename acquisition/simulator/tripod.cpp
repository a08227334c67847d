#include "acquisition/simulator/tripod.h"

#include <algorithm>
#include <cmath>

namespace ulf::acquisition {
namespace {

using Eigen::Vector3d;

constexpr double kLeastRaiseS = 0.8;  // guessed

}  // namespace

Tripod::Tripod(const HandOptions& options, double stands_s, double unsteady)
    : options_(options),
      stands_s_(stands_s),
      heights_(1 + static_cast<int>(std::floor(options.cap_elevation / options.row_spacing))),
      raised_in_s_(std::max(kLeastRaiseS, options.row_spacing / options.speed)) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    shifts_[i] = Waves(options.seed, 400 + axis, 3, 0.15, 0.8, 0.008 * unsteady);
    shifts_[i].Add(Waves(options.seed, 410 + axis, 4, 4, 9, 0.0007 * unsteady));
    turns_[i] = Waves(options.seed, 420 + axis, 3, 0.1, 0.5, Radians(1.6 * unsteady));
    turns_[i].Add(Waves(options.seed, 430 + axis, 4, 4, 9, Radians(0.12 * unsteady)));
  }
}

double Tripod::Elevation(double time_s) const {
  // Up and down again: 0 1 2 1 0 1 ...
  const auto height_of = [this](int stand) {
    const int round = std::max(1, 2 * (heights_ - 1)), i = stand % round;
    return i < heights_ ? i : round - i;
  };
  const double period_s = stands_s_ + raised_in_s_;
  const int stand = static_cast<int>(std::floor(std::max(0.0, time_s) / period_s));
  const double share = std::max(0.0, std::max(0.0, time_s) - stand * period_s - stands_s_) / raised_in_s_;
  const double eased = share * share * (3 - 2 * share);
  const double row = (1 - eased) * height_of(stand) + eased * height_of(stand + 1);
  return (row - 0.5 * (heights_ - 1)) * options_.row_spacing;
}

Rigid3 Tripod::CamFromWorld(double time_s) const {
  const Vector3d forward = options_.first_direction.normalized();
  const Vector3d up = (options_.up_in_world - options_.up_in_world.dot(forward) * forward).normalized();
  const double elevation = Elevation(time_s);
  const Vector3d direction = std::cos(elevation) * forward + std::sin(elevation) * up;
  const Vector3d shift(shifts_[0].At(time_s), shifts_[1].At(time_s), shifts_[2].At(time_s));
  const Rigid3 aimed = LookAt(options_.subject_in_world + options_.distance_m * direction + shift,
                              options_.subject_in_world, options_.up_in_world);
  return Turned(aimed, turns_[0].At(time_s), turns_[1].At(time_s), turns_[2].At(time_s));
}

}  // namespace ulf::acquisition
