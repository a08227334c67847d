#include "acquisition/aravis/aravis_white_balance.h"

#include <fmt/format.h>

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_setting.h"

namespace ulf::acquisition {
namespace {

void Select(const AravisSession& session, const std::string& who, const std::string& selector,
            const std::string& choice) {
  if (const std::string why = WriteSetting(session, selector, choice); !why.empty())
    throw Error("{}: {}={}: {}", who, selector, choice, why);
}

// If the ratios are gains, the selector must not stay at one colour: the gain of all is set by it, too.
class BackToAll {
 public:
  BackToAll(const AravisSession& session, const FeatureNames& names) : session_(session), names_(names) {}
  BackToAll(const BackToAll&) = delete;
  BackToAll& operator=(const BackToAll&) = delete;
  ~BackToAll() {
    if (names_.balance_is_gain && !names_.gain_of_all.empty())
      WriteSetting(session_, names_.gain_selector, names_.gain_of_all);
  }

 private:
  const AravisSession& session_;
  const FeatureNames& names_;
};

std::optional<double> ReadColour(const AravisSession& session, const FeatureNames& names,
                                 const char* colour) {
  try {
    Select(session, "the camera", names.balance_selector, colour);
  } catch (const Error&) {
    return std::nullopt;
  }
  return AravisNumber(session, names.balance_ratio).Read();
}

// Returns what a ratio of 1 is.
double GreenOf(const AravisSession& session, const FeatureNames& names) {
  const double green = names.balance_is_gain ? ReadColour(session, names, "Green").value_or(1) : 1;
  return green > 0 ? green : 1;
}

}  // namespace

std::optional<AravisWhiteBalance> ReadWhiteBalance(const AravisSession& session, const FeatureNames& names) {
  if (names.balance_ratio.empty()) return std::nullopt;
  const BackToAll back(session, names);
  const double green = GreenOf(session, names);
  const auto red = ReadColour(session, names, "Red"), blue = ReadColour(session, names, "Blue");
  if (!red || !blue) return std::nullopt;
  return AravisWhiteBalance{.by_camera = false, .red = *red / green, .blue = *blue / green};
}

void WriteWhiteBalance(const AravisSession& session, const std::string& who, const FeatureNames& names,
                       const AravisWhiteBalance& balance) {
  const BackToAll back(session, names);
  const double green = GreenOf(session, names);
  const AravisNumber ratio(session, names.balance_ratio, 1 / green);
  for (const auto& [colour, value] : {std::pair("Red", balance.red), std::pair("Blue", balance.blue)}) {
    Select(session, who, names.balance_selector, colour);
    if (ratio.Reads(value)) continue;
    if (const std::string why = ratio.WhyFixed(); !why.empty())
      throw Refused(who,
                    fmt::format("white_balance={:g} ({}): {} {} at {:g}", value, colour, ratio.Feature(), why,
                                ratio.Read().value_or(0)),
                    "leave white_balance out");
    const auto [low, high] = ratio.Bounds(who);
    if (value < low || value > high)
      throw Refused(who,
                    fmt::format("white_balance={} is out of the camera's range, {} to {}", value, low, high));
    ratio.Write(who, value);
  }
}

double WhiteBalanceStep(const AravisSession& session, const FeatureNames& names) {
  const BackToAll back(session, names);
  return AravisNumber(session, names.balance_ratio).Step() / GreenOf(session, names);
}

}  // namespace ulf::acquisition
