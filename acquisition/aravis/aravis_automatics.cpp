#include "acquisition/aravis/aravis_automatics.h"

#include <algorithm>
#include <array>
#include <optional>

#include "acquisition/aravis/aravis_description.h"

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

// The first of these features that the camera has and that is a number, with its value.
struct Held {
  const char* option;
  std::string feature;
  double value;
  bool is_whole;
};
std::optional<Held> FirstNumber(const AravisSession& session,
                                std::initializer_list<std::pair<const char*, std::string>> candidates) {
  for (const auto& [option, name] : candidates) {
    const char* feature = name.c_str();
    ArvGcNode* node = name.empty() ? nullptr : arv_device_get_feature(session.Device(), feature);
    const bool is_whole = node && ARV_IS_GC_INTEGER(node) && !ARV_IS_GC_FLOAT(node);
    if (!node || (!is_whole && !ARV_IS_GC_FLOAT(node))) continue;
    GError* error = nullptr;
    const double value = is_whole
                             ? static_cast<double>(arv_camera_get_integer(session.Camera(), feature, &error))
                             : arv_camera_get_float(session.Camera(), feature, &error);
    if (!error) return Held{option, name, value, is_whole};
    g_clear_error(&error);
  }
  return std::nullopt;
}

std::optional<Held> ControlledValue(const AravisSession& session, const Automatic& automatic) {
  const std::string_view feature = automatic.feature;
  const FeatureNames names = FindFeatureNames(FeaturesOf(session.Camera()));
  if (feature == "ExposureAuto") return FirstNumber(session, {{"exposure_us", names.exposure}});
  if (feature == "BlackLevelAuto")
    return FirstNumber(session, {{"black_level", "BlackLevel"}, {"black_level", "BlackLevelRaw"}});
  if (feature != "GainAuto") return std::nullopt;
  return FirstNumber(session, {{"gain_db", names.gain_db}, {"gain_raw", names.gain_raw}});
}

void WriteBack(const AravisSession& session, const Held& held) {
  Try([&](GError** e) {
    if (held.is_whole)
      arv_camera_set_integer(session.Camera(), held.feature.c_str(), static_cast<gint64>(held.value), e);
    else
      arv_camera_set_float(session.Camera(), held.feature.c_str(), held.value, e);
  });
}

struct ColourRatios {
  std::string feature, selector;
  double red = 0, blue = 0;
};
std::optional<ColourRatios> ReadRatios(const AravisSession& session) {
  const FeatureNames names = FindFeatureNames(FeaturesOf(session.Camera()));
  ColourRatios ratios{.feature = names.balance_ratio, .selector = names.balance_selector};
  if (ratios.feature.empty()) return std::nullopt;
  for (const auto& [colour, value] : {std::pair("Red", &ratios.red), std::pair("Blue", &ratios.blue)}) {
    GError* error = nullptr;
    arv_camera_set_string(session.Camera(), ratios.selector.c_str(), colour, &error);
    if (!error) *value = arv_camera_get_float(session.Camera(), ratios.feature.c_str(), &error);
    if (!error) continue;
    g_clear_error(&error);
    return std::nullopt;
  }
  return ratios;
}

void WriteBack(const AravisSession& session, const ColourRatios& ratios) {
  for (const auto& [colour, value] : {std::pair("Red", ratios.red), std::pair("Blue", ratios.blue)}) {
    Try([&, c = colour](GError** e) {
      arv_camera_set_string(session.Camera(), ratios.selector.c_str(), c, e);
    });
    Try([&, v = value](GError** e) { arv_camera_set_float(session.Camera(), ratios.feature.c_str(), v, e); });
  }
}

void Freeze(const AravisSession& session, const Automatic& automatic, AravisFrozen& frozen) {
  const auto controlled = ControlledValue(session, automatic);
  const auto ratios =
      std::string_view(automatic.feature) == "BalanceWhiteAuto" ? ReadRatios(session) : std::nullopt;
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
    WriteBack(session, *controlled);
    value = {controlled->option, fmt::format("{}", controlled->value)};
  } else if (ratios) {
    WriteBack(session, *ratios);
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
