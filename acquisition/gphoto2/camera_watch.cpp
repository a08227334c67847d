#include "acquisition/gphoto2/camera_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace ulf::acquisition {
namespace {

constexpr int kBatteryLow = 15;  // percent; at or below, a notice tells it; guessed

}  // namespace

void CameraWatch::Begin(bool target_is_memory) {
  target_is_memory_ = target_is_memory;
  LookAtFormat();
  has_storage_ = camera_.Storages(storages_).ok();
  LookAtBatteryAndCard();
}

GphotoResult CameraWatch::Poll() {
  for (const std::string& change : settings_.Changes()) notice_(change);
  LookAtFormat();
  if (has_storage_)
    if (GphotoResult result = camera_.Storages(storages_); !result.ok() && !result.Busy()) return result;
  LookAtBatteryAndCard();
  return {};
}

void CameraWatch::LookAtFormat() {
  if (said_raw_only_) return;
  const std::string words = RawFormatProblem(camera_, settings_.Value(ShotSetting::kFormat));
  if (!words.empty()) notice_(words);
  said_raw_only_ = !words.empty();
}

void CameraWatch::LookAtBatteryAndCard() {
  if (const auto battery = camera_.Setting("batterylevel")) {
    const int percent = std::atoi(battery->value.c_str());
    const bool low = battery->value.find('%') != std::string::npos ? percent <= kBatteryLow
                                                                   : battery->value.starts_with("Low");
    if (low && !said_battery_)
      notice_(fmt::format("the battery is low ({}); keep another ready", battery->value));
    said_battery_ = low;
  }
  const bool full = !target_is_memory_ && std::ranges::any_of(storages_, &GphotoStorage::is_card) &&
                    std::ranges::all_of(storages_, &GphotoStorage::is_full);
  if (full && !said_full_) notice_("the card is full; change it, or use target=ram");
  said_full_ = full;
}

}  // namespace ulf::acquisition
