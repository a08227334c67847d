#include "acquisition/device/frame_id_counter.h"

#include <algorithm>
#include <cstdlib>

namespace ulf::acquisition {
namespace {

constexpr std::int64_t kIds16 = 65535;  // 1 to 65535: 0 is left out at the wrap

// Returns how far `id` lies ahead of `newest`; negative when it is a late arrival.
std::int64_t Ahead(std::uint64_t newest, std::uint64_t id) {
  const auto difference = static_cast<std::int64_t>(id - newest);
  if (std::max(newest, id) > kIds16 || std::abs(difference) <= kIds16 / 2) return difference;
  return difference < 0 ? difference + kIds16 : difference - kIds16;
}

}  // namespace

void FrameIdCounter::Arrived(std::uint64_t id) {
  if (!newest_) {
    newest_ = id;
    without_id_ = 0;  // frames before the first number fill no gap after it
    return;
  }
  const std::int64_t ahead = Ahead(*newest_, id);
  if (ahead <= 0) {
    if (ahead < 0) ++out_of_order_;
    if (ahead < 0 && missing_ > 0) --missing_;  // late, not lost
    return;
  }
  const auto gap = static_cast<std::uint64_t>(ahead - 1);
  const std::uint64_t filled = std::min(gap, without_id_);
  missing_ += gap - filled;
  without_id_ -= filled;
  newest_ = id;
}

}  // namespace ulf::acquisition
