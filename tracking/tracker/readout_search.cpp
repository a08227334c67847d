#include "tracking/tracker/readout_search.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tracking/map/map_rows.h"

namespace ulf::tracking {
namespace {

constexpr double kCertain = 6;        // standard deviations
constexpr double kWorthIt_s = 0.002;  // a shorter readout moves hardly anything by a tenth of a pixel
constexpr double kGoodEnough = 0.05;  // of the readout
constexpr int kTimesCertain = 2;      // one after the other, before it is said
constexpr int kMostTimes = 6;         // that it is changed
constexpr int kEnoughKeyframes = 24;  // to say that there is none

}  // namespace

std::string Readout::InWords() const {
  const double ms = 1000 * readout_s;
  if (!sigma_s) return fmt::format("rolling shutter of {:.1f} ms: compensated", ms);
  const std::string size =
      fmt::format("rolling shutter of about {:.0f} ms (found out, +- {:.1f}): ", ms, 1000 * *sigma_s);
  if (compensated) return size + "compensated from where it was found on";
  return size + fmt::format("poses suffer where the camera moves fast; --readout-ms {:.0f} compensates", ms);
}

nlohmann::ordered_json ToJson(const std::optional<Readout>& rolling) {
  if (!rolling) return nullptr;
  return {{"readout_ms", 1000 * rolling->readout_s},
          {"sigma_ms", rolling->sigma_s ? nlohmann::ordered_json(1000 * *rolling->sigma_s) : nullptr},
          {"compensated", rolling->compensated}};
}

ReadoutSearch::ReadoutSearch(const CameraModel& camera, RowMotion& rows, SharedMap& shared, Mapper& mapper,
                             bool compensate)
    : camera_(camera), rows_(rows), shared_(shared), mapper_(mapper), compensate_(compensate) {
  shared_.measure_readout = true;
}

void ReadoutSearch::Step() {
  if (shared_.readouts_measured == judged_) return;
  std::optional<ReadoutEstimate> estimate;
  {
    const MapLock lock(shared_);
    judged_ = shared_.readouts_measured;
    estimate = shared_.readout;
  }
  if (estimate) Judge(*estimate);
}

void ReadoutSearch::Judge(const ReadoutEstimate& estimate) {
  const double now_s = rows_.readout_s(), size_s = std::abs(estimate.readout_s);
  spdlog::debug("readout {:.2f} +- {:.2f} ms from {} keyframes, {:.2f} so far", 1e3 * estimate.readout_s,
                1e3 * estimate.sigma_s, estimate.keyframes, 1e3 * now_s);
  if (size_s < kWorthIt_s || size_s < kCertain * estimate.sigma_s) {
    certain_ = 0;
    const bool none = size_s + kCertain * estimate.sigma_s < kWorthIt_s;
    if (!none && estimate.keyframes < kEnoughKeyframes) return;
    if (now_s != 0) Apply(0);
    found_.reset();
    return End();
  }
  if (++certain_ < kTimesCertain) return;
  const bool news = !found_;
  found_ = Readout{estimate.readout_s, estimate.sigma_s, compensate_};
  if (news) spdlog::info("{}", found_->InWords());
  const double change_s = std::abs(estimate.readout_s - now_s);
  if (!compensate_ || (now_s != 0 && change_s < std::max(estimate.sigma_s, kGoodEnough * std::abs(now_s)))) {
    if (compensate_) found_->readout_s = now_s;
    if (estimate.sigma_s < kGoodEnough * size_s || estimate.keyframes >= kEnoughKeyframes) End();
    return;
  }
  Apply(estimate.readout_s);
  if (++applied_ == kMostTimes) End();
}

void ReadoutSearch::Apply(double readout_s) {
  mapper_.Rest();
  rows_.SetReadout(readout_s);
  {
    const MapLock lock(shared_);
    GiveRows(camera_, shared_.map, readout_s);
    ++shared_.revision;
  }
  mapper_.AdjustSoon();
}

void ReadoutSearch::End() { shared_.measure_readout = false; }

}  // namespace ulf::tracking
