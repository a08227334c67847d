#include "acquisition/gphoto2/shutter_bracket.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/host_time.h"

namespace ulf::acquisition {

using Clock = std::chrono::steady_clock;

bool ShutterBracket::IsPossible() const {
  return settings_.Number(ShotSetting::kShutter).value_or(0) > 0 &&
         settings_.Choices(ShotSetting::kShutter).size() > 1;
}

void ShutterBracket::Begin(const std::vector<double>& stops) {
  stops_.assign(stops.begin(), stops.end());
  before_ = settings_.Value(ShotSetting::kShutter);
  before_s_ = settings_.Number(ShotSetting::kShutter).value_or(0);
  used_ = {before_};
}

// Returns the choice nearest to so many stops from the time before; none if it has been used.
std::optional<std::string> ShutterBracket::ShutterAt(double stops) const {
  const double wanted_s = before_s_ * std::exp2(stops);
  std::optional<std::string> nearest;
  double off = std::numeric_limits<double>::infinity();
  for (const std::string& choice : settings_.Choices(ShotSetting::kShutter)) {
    const double seconds = PhotographicNumber(choice).value_or(0);
    if (seconds <= 0 || std::abs(std::log2(seconds / wanted_s)) >= off) continue;
    off = std::abs(std::log2(seconds / wanted_s));
    nearest = choice;
  }
  return nearest && used_.contains(*nearest) ? std::nullopt : nearest;
}

// Returns false when the camera is busy, or refuses.
bool ShutterBracket::Set(const std::string& shutter) {
  try {
    settings_.Lock(ShotSetting::kShutter, shutter);
    refused_since_.reset();
    return true;
  } catch (const Error& error) {
    if (!refused_since_) refused_since_ = Clock::now();
    if (SecondsSince(*refused_since_) >= busy_s_) refusal_ = error.what();
    return false;
  }
}

std::optional<double> ShutterBracket::Next() {
  if (stops_.empty()) {
    Restore();
    return std::nullopt;
  }
  const double stops = stops_.front();
  const std::optional<std::string> shutter = ShutterAt(stops);
  if (shutter && Set(*shutter)) {
    used_.insert(*shutter);
    stops_.pop_front();
    return stops;
  }
  if (shutter && refusal_.empty()) return std::nullopt;
  if (shutter)
    notice_(std::exchange(refusal_, {}) + "; the bracket goes on without this exposure");
  else
    notice_(
        fmt::format("the camera has no other shutter time near {:+g} stops from {}: the bracket goes on "
                    "without this exposure; begin with another shutter time, or bracket fewer stops",
                    stops, before_));
  refused_since_.reset();
  stops_.pop_front();
  return std::nullopt;
}

void ShutterBracket::Restore() {
  if (!IsRunning()) return;
  if (!Set(before_)) {
    if (refusal_.empty()) return;
    notice_(std::exchange(refusal_, {}) + fmt::format("; set the shutter back to {} on the camera", before_));
    refused_since_.reset();
  }
  before_.clear();
}

void ShutterBracket::GiveUp(bool camera_is_gone) {
  stops_.clear();
  if (!IsRunning()) return;
  if (!camera_is_gone) Restore();
  if (IsRunning())
    notice_(fmt::format("a bracket was not taken to its end: set the camera's shutter back to {}", before_));
  before_.clear();
}

}  // namespace ulf::acquisition
