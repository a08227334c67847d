#include "acquisition/aravis/aravis_automatics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "acquisition/aravis/aravis_description.h"
#include "acquisition/aravis/aravis_number.h"
#include "acquisition/aravis/aravis_white_balance.h"

namespace ulf::acquisition {
namespace {

struct Automatic {
  const char* feature;
  const char* option;
  std::optional<bool> AravisOptions::*asked;
};
constexpr std::array kAutomatics{
    Automatic{"ExposureAuto", "auto_exposure", &AravisOptions::auto_exposure},
    Automatic{"GainAuto", "auto_gain", &AravisOptions::auto_gain},
    Automatic{"BalanceWhiteAuto", "auto_white_balance", &AravisOptions::auto_white_balance},
    Automatic{"BlackLevelAuto", "auto_black_level", &AravisOptions::auto_black_level},
};

// "Off", "Once", "Continuous"; empty: the camera has no such automatic.
std::string AutomaticMode(const AravisSession& session, const char* feature) {
  if (!Maybe([&](GError** e) { return arv_camera_is_feature_available(session.Camera(), feature, e); },
             false))
    return "";
  return Text(Maybe([&](GError** e) { return arv_camera_get_string(session.Camera(), feature, e); },
                    static_cast<const char*>(nullptr)));
}

bool IsOnUnasked(const AravisSession& session, const AravisOptions& options, const Automatic& automatic) {
  if (options.*automatic.asked) return false;
  const bool once = &AravisOptions::auto_white_balance == automatic.asked && options.white_balance &&
                    options.white_balance->by_camera;
  const std::string mode = once ? "" : AutomaticMode(session, automatic.feature);
  return !mode.empty() && mode != "Off";
}

struct Held {
  const char* option;
  AravisNumber number;
  double value;  // of the number
  double option_value;
};
std::optional<Held> HeldNumber(const char* option, const AravisNumber& number) {
  const std::optional<double> value = number.Read();
  return value ? std::optional(Held{option, number, *value, *value}) : std::nullopt;
}

std::optional<Held> HeldGain(const AravisSession& session, const FeatureNames& names) {
  auto held = HeldNumber("gain_db", {session, names.gain});
  if (!held) return HeldNumber("gain_raw", {session, names.gain_raw});
  if (names.gain_is_factor) held->option_value = 20 * std::log10(held->value);
  return held;
}

std::optional<Held> ControlledValue(const AravisSession& session, const Automatic& automatic,
                                    const FeatureNames& names) {
  const std::string_view feature = automatic.feature;
  if (feature == "ExposureAuto")
    return HeldNumber("exposure_us", {session, names.exposure, names.exposure_us});
  if (feature == "GainAuto") return HeldGain(session, names);
  if (feature != "BlackLevelAuto") return std::nullopt;
  for (const char* name : {"BlackLevel", "BlackLevelRaw"})
    if (KindOf(arv_device_get_feature(session.Device(), name)) != NodeKind::kNone)
      if (auto held = HeldNumber("black_level", {session, name})) return held;
  return std::nullopt;
}

// Some cameras have kept the value by themselves and refuse it now.
template <typename Write>
void TryToWrite(Write&& write) {
  try {
    write();
  } catch (const Error&) {
  }
}

void Freeze(const AravisSession& session, const Automatic& automatic, AravisFrozen& frozen) {
  const FeatureNames names = FindFeatureNames(FeaturesOf(session.Camera()));
  const auto controlled = ControlledValue(session, automatic, names);
  const auto ratios = std::string_view(automatic.feature) == "BalanceWhiteAuto"
                          ? ReadWhiteBalance(session, names)
                          : std::nullopt;
  GError* error = nullptr;
  arv_camera_set_string(session.Camera(), automatic.feature, "Off", &error);
  const std::string reason = error ? Text(error->message) : "the camera does not switch it off";
  g_clear_error(&error);
  if (AutomaticMode(session, automatic.feature) != "Off") {
    frozen.said.push_back(
        fmt::format("{} stays on: {}; pictures may change between views", automatic.option, reason));
    return;
  }
  std::pair<std::string, std::string> value;
  if (controlled) {
    TryToWrite([&] { controlled->number.Write("the camera", controlled->value); });
    value = {controlled->option, fmt::format("{}", controlled->option_value)};
  } else if (ratios) {
    TryToWrite([&] { WriteWhiteBalance(session, "the camera", names, *ratios); });
    value = {"white_balance", fmt::format("{},{}", ratios->red, ratios->blue)};
  }
  const std::string held =
      value.first.empty() ? "" : fmt::format(", held at {}={}", value.first, value.second);
  frozen.said.push_back(fmt::format("{} off{} ({}=on keeps it)", automatic.option, held, automatic.option));
  if (!value.first.empty()) frozen.values.push_back(value);
}

}  // namespace

void WriteAravisAutomatics(const AravisSession& session, const std::string& who,
                           const AravisOptions& options) {
  for (const Automatic& automatic : kAutomatics) {
    const std::optional<bool> asked = options.*automatic.asked;
    if (!asked) continue;
    if (AutomaticMode(session, automatic.feature).empty()) {
      if (*asked) throw UsageError("{}: the camera has no {}; leave it out", who, automatic.option);
      continue;
    }
    Must(who, automatic.option, [&](GError** e) {
      arv_camera_set_string(session.Camera(), automatic.feature, *asked ? "Continuous" : "Off", e);
    });
  }
}

bool HasAutomaticOn(const AravisSession& session, const AravisOptions& options) {
  return std::any_of(kAutomatics.begin(), kAutomatics.end(),
                     [&](const Automatic& automatic) { return IsOnUnasked(session, options, automatic); });
}

AravisFrozen FreezeAravisAutomatics(const AravisSession& session, const AravisOptions& options) {
  AravisFrozen frozen;
  for (const Automatic& automatic : kAutomatics)
    if (IsOnUnasked(session, options, automatic)) Freeze(session, automatic, frozen);
  return frozen;
}

}  // namespace ulf::acquisition
