#include "acquisition/aravis/aravis_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "acquisition/aravis/aravis_description.h"
#include "acquisition/aravis/aravis_setting.h"

namespace ulf::acquisition {
namespace {

constexpr std::int64_t kUntold = std::numeric_limits<int>::max();  // a limit that no camera means

struct Steps {
  std::int64_t low = 0, high = 0, step = 1;
  std::string fixed = {};  // why there is one value alone: "Width is read-only"

  std::int64_t Nearest(std::int64_t value) const {
    const std::int64_t most = low + std::max<std::int64_t>(0, high - low) / step * step;
    return std::clamp(low + (std::max<std::int64_t>(0, value - low) + step / 2) / step * step, low, most);
  }
};

Steps StepsOf(const AravisSession& session, const std::string& who, const char* feature) {
  if (IsReadOnly(session, feature))
    if (const std::optional<double> now = AravisNumber(session, feature).Read())
      return {std::llround(*now), std::llround(*now), 1, fmt::format("{} is read-only", feature)};
  gint64 low = 0, high = 0;
  CallOrThrow(who, feature, arv_camera_get_integer_bounds, session.Camera(), feature, &low, &high);
  const gint64 step = TryCall(arv_camera_get_integer_increment, session.Camera(), feature).value_or(1);
  // A description without limits has those of its registers.
  return {std::max<std::int64_t>(low, -kUntold), std::min<std::int64_t>(high, kUntold),
          std::max<gint64>(1, step)};
}

struct Axis {
  const char *offset, *sensor, *largest, *binning, *decimation;
};
constexpr Axis kAxes[] = {{"OffsetX", "SensorWidth", "WidthMax", "BinningHorizontal", "DecimationHorizontal"},
                          {"OffsetY", "SensorHeight", "HeightMax", "BinningVertical", "DecimationVertical"}};

// Returns the sensor along an axis, in pixels of the image, beside a size that is fixed; 0: the camera does
// not tell it. A largest size that is the fixed one tells nothing, because no other size is possible.
std::int64_t SensorBeside(const AravisSession& session, const Axis& axis, std::int64_t size) {
  const auto read = [&](const char* feature) {
    return std::llround(AravisNumber(session, feature).Read().value_or(0));
  };
  const std::int64_t sensor =
      read(axis.sensor) / (ReductionOf(session, axis.binning) * ReductionOf(session, axis.decimation));
  if (sensor >= size) return sensor;
  const std::int64_t largest = read(axis.largest);
  return largest > size ? largest : 0;
}

// Returns where an image of `size` may begin, which is one of `sizes`. The camera's limits belong to the
// present size: they hold for one that is fixed, and are computed for others.
Steps OffsetsOf(const AravisSession& session, const std::string& who, const Axis& axis, const Steps& sizes,
                std::int64_t size) {
  Steps offsets = StepsOf(session, who, axis.offset);
  if (!offsets.fixed.empty()) return offsets;
  if (sizes.fixed.empty())
    offsets.high = sizes.high - size;
  else if (const std::int64_t sensor = SensorBeside(session, axis, size))
    offsets.high = std::min(offsets.high, sensor - size);
  return offsets;
}

// Returns where the last pixel that the camera can send ends along an axis; 0: it has no limit. A size that
// is fixed is not the sensor's; the offsets beside it reach as far as the sensor does.
int EndOf(const AravisSession& session, const std::string& who, const Axis& axis, const Steps& sizes,
          bool has_offsets) {
  std::int64_t end = sizes.fixed.empty() ? sizes.high : SensorBeside(session, axis, sizes.low);
  if (end == 0) {
    end = sizes.low;
    try {
      if (has_offsets) end += OffsetsOf(session, who, axis, sizes, sizes.low).high;
    } catch (const Error&) {  // they have no limits that can be read
    }
  }
  return end < kUntold ? static_cast<int>(end) : 0;
}

std::string RegionText(const AravisRegion& region) {
  return fmt::format("{}x{}+{}+{}", region.width, region.height, region.x, region.y);
}

std::string RegionText(const Steps& steps) {
  if (!steps.fixed.empty()) return fmt::format("{} alone, because {}", steps.low, steps.fixed);
  return fmt::format("{} to {}{}", steps.low, steps.high,
                     steps.step > 1 ? fmt::format(" in steps of {}", steps.step) : "");
}

bool IsChoice(const AravisSession& session, const char* feature) {
  return KindOf(session.Node(feature)) == FeatureType::kEnumeration;
}

// "BinningHorizontal2": 2; "Off": 1; none: the name has no number.
std::optional<int> ReductionIn(const std::string& choice) {
  if (choice == "Off") return 1;
  const std::size_t last = choice.find_last_not_of("0123456789");
  const std::size_t from = last == std::string::npos ? 0 : last + 1;
  int factor = 0;
  const auto [end, error] = std::from_chars(choice.data() + from, choice.data() + choice.size(), factor);
  return error == std::errc() && factor > 0 ? std::optional(factor) : std::nullopt;
}

void WriteReduction(const AravisSession& session, const std::string& who, const char* feature, int factor) {
  const std::string asked = fmt::format("binning={}", factor);
  if (!IsChoice(session, feature)) {
    const Steps steps = StepsOf(session, who, feature);
    if (factor < steps.low || factor > steps.high)
      throw Refused(who,
                    fmt::format("binning={} is out of the camera's range, {}", factor, RegionText(steps)));
    return RequireSetting(session, who, asked, feature, fmt::format("{}", factor));
  }
  const std::vector<std::string> choices = session.Choices(feature);
  const auto choice = std::find_if(choices.begin(), choices.end(),
                                   [&](const std::string& name) { return ReductionIn(name) == factor; });
  if (choice == choices.end()) throw NoSuchChoice(who, asked, choices);
  RequireSetting(session, who, asked, feature, *choice);
}

}  // namespace

int ReductionOf(const AravisSession& session, const char* feature) {
  if (!session.Has(feature)) return 1;
  if (IsChoice(session, feature))
    return ReductionIn(Text(TryCall(arv_camera_get_string, session.Camera(), feature).value_or(nullptr)))
        .value_or(1);
  return static_cast<int>(
      std::max(gint64{1}, TryCall(arv_camera_get_integer, session.Camera(), feature).value_or(1)));
}

void WriteAravisBinning(const AravisSession& session, const std::string& who, const AravisBinning& asked) {
  for (const auto& [feature, factor] :
       {std::pair("BinningHorizontal", asked.x), std::pair("BinningVertical", asked.y)}) {
    if (factor == ReductionOf(session, feature)) continue;
    if (factor != 1) {
      if (!session.Has(feature)) throw Refused(who, "the camera cannot bin", "leave binning out");
      WriteReduction(session, who, feature, factor);
    } else {
      try {
        WriteReduction(session, who, feature, 1);
      } catch (const Error&) {  // then the window tells the binning that stays
      }
    }
  }
}

AravisImageLimits WriteAravisRegion(const AravisSession& session, const std::string& who,
                                    const std::optional<AravisRegion>& asked, bool is_mosaic,
                                    std::vector<std::string>& notes) {
  const bool has_offsets = TryCall(arv_camera_is_region_offset_available, session.Camera()).value_or(false);
  // The offsets must be zero first, because they limit the sizes.
  if (has_offsets)
    for (const char* offset : {"OffsetX", "OffsetY"})
      if (const std::string why = WriteSetting(session, offset, "0"); !why.empty() && !asked)
        notes.push_back("keeps its offset: " + why);
  const Steps widths = StepsOf(session, who, "Width"), heights = StepsOf(session, who, "Height");
  const AravisImageLimits limits{EndOf(session, who, kAxes[0], widths, has_offsets),
                                 EndOf(session, who, kAxes[1], heights, has_offsets)};
  if (!asked) {
    // A value that is fixed is taken as it is, where nobody asked for another.
    for (const auto& [feature, steps] : {std::pair("Width", &widths), std::pair("Height", &heights)}) {
      if (!steps->fixed.empty())
        notes.push_back(fmt::format("sends a {} of {}: {}", feature, steps->low, steps->fixed));
      else if (const std::string why =
                   WriteSetting(session, feature, fmt::format("{}", steps->Nearest(steps->high)));
               !why.empty())
        notes.push_back("keeps its size: " + why);
    }
    return limits;
  }
  AravisRegion nearest{static_cast<int>(widths.Nearest(asked->width)),
                       static_cast<int>(heights.Nearest(asked->height)), 0, 0};
  Steps xs, ys;
  if (has_offsets) {
    xs = OffsetsOf(session, who, kAxes[0], widths, nearest.width);
    ys = OffsetsOf(session, who, kAxes[1], heights, nearest.height);
    if (is_mosaic)
      for (Steps* steps : {&xs, &ys})
        if (steps->fixed.empty()) steps->step = std::lcm(steps->step, std::int64_t{2});
    nearest.x = static_cast<int>(xs.Nearest(asked->x));
    nearest.y = static_cast<int>(ys.Nearest(asked->y));
  }
  const auto refuse = [&](const AravisRegion& instead) {
    throw Refused(
        who, fmt::format("the camera cannot send roi={}", RegionText(*asked)),
        fmt::format("nearest is roi={} (width {}, height {}, offsets {} and {}{})", RegionText(instead),
                    RegionText(widths), RegionText(heights), RegionText(xs), RegionText(ys),
                    is_mosaic
                        ? "; offsets must be even, because an odd one would exchange the mosaic's colours"
                        : ""));
  };
  const auto set = [&](const char* feature, std::int64_t value) {
    RequireSetting(session, who, "roi=" + RegionText(*asked), feature, fmt::format("{}", value));
  };
  if (!(nearest == *asked)) refuse(nearest);
  set("Width", asked->width);
  set("Height", asked->height);
  if (!has_offsets) return limits;
  // Some cameras limit the offsets further once the size is set.
  for (const auto& [feature, steps, value] :
       {std::tuple("OffsetX", &xs, &nearest.x), std::tuple("OffsetY", &ys, &nearest.y)}) {
    const Steps now = StepsOf(session, who, feature);
    steps->low = std::max(steps->low, now.low);
    steps->high = std::min(steps->high, now.high);
    *value = static_cast<int>(steps->Nearest(*value));
  }
  if (!(nearest == *asked)) refuse(nearest);
  set("OffsetX", asked->x);
  set("OffsetY", asked->y);
  return limits;
}

}  // namespace ulf::acquisition
