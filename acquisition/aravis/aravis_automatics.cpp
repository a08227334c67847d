#include "acquisition/aravis/aravis_automatics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "acquisition/aravis/aravis_description.h"
#include "acquisition/aravis/aravis_setting.h"
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

// Lower-case letters and digits.
std::string Plain(const std::string& word) {
  std::string plain;
  for (const char c : word)
    if (g_ascii_isalnum(c)) plain += g_ascii_tolower(c);
  return plain;
}

std::optional<AutomaticMode> InList(const std::string& word) {
  using Words = std::initializer_list<std::string_view>;
  const auto is_in = [&](Words words) { return std::find(words.begin(), words.end(), word) != words.end(); };
  if (is_in({"off", "manual", "disable", "disabled", "false", "no", "none", "fixed", "inactive", "stop"}))
    return AutomaticMode::kOff;
  if (is_in({"once", "onepush", "oneshot", "onetime", "single", "singleshot"})) return AutomaticMode::kOnce;
  if (is_in({"on", "auto", "automatic", "continuous", "continously", "continuously", "cont", "enable",
             "enabled", "true", "yes", "active", "run"}))
    return AutomaticMode::kOn;
  return std::nullopt;
}

// "Off", "ExposureAuto_Off", "AutoOnce", "ManualGain". `feature`: "ExposureAuto".
std::optional<AutomaticMode> MeaningOf(const std::string& word, const std::string& feature) {
  std::string plain = Plain(word);
  if (const auto mode = InList(plain)) return mode;
  std::string controlled = Plain(feature);
  if (controlled.ends_with("auto")) controlled.resize(controlled.size() - 4);
  if (const std::size_t at = plain.find(controlled); !controlled.empty() && at != std::string::npos)
    plain.erase(at, controlled.size());
  if (const auto mode = InList(plain)) return mode;
  if (plain.starts_with("auto")) return InList(plain.substr(4));
  if (plain.ends_with("auto")) return InList(plain.substr(0, plain.size() - 4));
  return std::nullopt;
}

const char* Name(AutomaticMode mode) {
  return mode == AutomaticMode::kOff ? "off" : mode == AutomaticMode::kOnce ? "once" : "on";
}

bool IsOnUnasked(const AravisSession& session, const AravisOptions& options, const Automatic& automatic) {
  if (options.*automatic.asked) return false;
  const bool once = &AravisOptions::auto_white_balance == automatic.asked && options.white_balance &&
                    options.white_balance->by_camera;
  return !once && IsAutomaticOn(session, automatic.feature);
}

std::string LeftAlone(const std::string& feature, const std::string& why) {
  return fmt::format("keeps {} as it is: {}", feature, why);
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
    if (KindOf(session.Node(name)))
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
  std::string reason = SwitchAutomatic(session, automatic.feature, AutomaticMode::kOff);
  if (reason.empty() && IsAutomaticOn(session, automatic.feature))
    reason = "the camera does not switch it off";
  if (!reason.empty()) {
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

AutomaticMode ModeOf(const AravisSession& session, const std::string& feature) {
  if (!session.Has(feature)) return AutomaticMode::kNone;
  const std::optional<std::string> reads = ReadSetting(session, feature);
  if (!reads) return AutomaticMode::kUnknown;
  if (KindOf(session.Node(feature)) == FeatureType::kInteger)
    return *reads == "0" ? AutomaticMode::kOff : AutomaticMode::kOn;
  return MeaningOf(*reads, feature).value_or(AutomaticMode::kUnknown);
}

std::string WordFor(const AravisSession& session, const std::string& feature, AutomaticMode mode) {
  for (const std::string& word : session.Choices(feature))
    if (MeaningOf(word, feature) == mode) return word;
  return "";
}

bool IsAutomaticOn(const AravisSession& session, const std::string& feature) {
  const AutomaticMode mode = ModeOf(session, feature);
  return mode == AutomaticMode::kOn || mode == AutomaticMode::kOnce;
}

std::string SwitchAutomatic(const AravisSession& session, const std::string& feature, AutomaticMode wanted) {
  const AutomaticMode now = ModeOf(session, feature);
  if (now == wanted || now == AutomaticMode::kNone) return "";
  const std::optional<FeatureType> kind = KindOf(session.Node(feature));
  if (kind == FeatureType::kBoolean && wanted != AutomaticMode::kOnce)
    return WriteSetting(session, feature, wanted == AutomaticMode::kOn ? "true" : "false");
  if (kind == FeatureType::kInteger && wanted == AutomaticMode::kOff)
    return WriteSetting(session, feature, "0");
  // Nobody knows what numbers above 1 mean.
  if (kind == FeatureType::kInteger && wanted == AutomaticMode::kOn &&
      (AravisNumber(session, feature).Bounds("the camera").second <= 1 || Plain(feature).ends_with("enable")))
    return WriteSetting(session, feature, "1");
  if (const std::string word = WordFor(session, feature, wanted); !word.empty())
    return WriteSetting(session, feature, word);
  const std::vector<std::string> words = session.Choices(feature);
  const std::optional<std::string> reads = ReadSetting(session, feature);
  return fmt::format(
      "{}{} and offers nothing that means {} ({})", feature, reads ? " reads " + *reads : " cannot be read",
      Name(wanted),
      words.empty() ? "it has no choices" : fmt::format("its choices are {}", fmt::join(words, ", ")));
}

std::string SwitchOffFor(const AravisSession& session, const std::string& who, const std::string& asked,
                         const std::string& feature) {
  const std::string why = SwitchAutomatic(session, feature, AutomaticMode::kOff);
  if (why.empty()) return "";
  if (!IsAutomaticOn(session, feature)) return LeftAlone(feature, why);
  throw Refused(who, fmt::format("{} needs {} off, but {}", asked, feature, why),
                fmt::format("leave {} out", asked.substr(0, asked.find('='))));
}

std::vector<std::string> WriteAravisAutomatics(const AravisSession& session, const std::string& who,
                                               const AravisOptions& options) {
  std::vector<std::string> notes;
  for (const Automatic& automatic : kAutomatics) {
    const std::optional<bool> asked = options.*automatic.asked;
    const AutomaticMode mode = ModeOf(session, automatic.feature);
    if (!asked && mode == AutomaticMode::kUnknown)
      notes.push_back(LeftAlone(automatic.feature, "it says in no word that ulf knows whether it is on"));
    if (!asked) continue;
    if (mode == AutomaticMode::kNone && *asked)
      throw Refused(who, fmt::format("the camera has no {}", automatic.option), "leave it out");
    const std::string why =
        SwitchAutomatic(session, automatic.feature, *asked ? AutomaticMode::kOn : AutomaticMode::kOff);
    if (!why.empty())
      throw Refused(who, fmt::format("{}={}: {}", automatic.option, *asked ? "on" : "off", why),
                    fmt::format("leave {} out", automatic.option));
  }
  return notes;
}

void BalanceWhiteOnce(const AravisSession& session, const std::string& who) {
  const std::string why = SwitchAutomatic(session, "BalanceWhiteAuto", AutomaticMode::kOnce);
  if (!why.empty())
    throw Refused(who, fmt::format("white_balance=auto: {}", why), "give white_balance=RED,BLUE");
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
