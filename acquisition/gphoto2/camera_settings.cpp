#include "acquisition/gphoto2/camera_settings.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <thread>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/lowercase.h"

namespace ulf::acquisition {
namespace {

// Two values closer than this many stops are the same setting. Cameras count in thirds of a stop; this is
// less than half of one, and more than their rounding. Guessed.
constexpr double kSameStops = 0.12;
// A camera may be busy, or report a new value late: tries to write a setting, and the pause between two.
// Guessed.
constexpr int kWriteTries = 10;
constexpr std::chrono::milliseconds kWritePause(100);

struct SettingNames {
  const char* name;
  std::vector<const char*> drivers;  // in the drivers; the first that the camera has is used
};
const SettingNames& NamesOf(ShotSetting setting) {
  // In the order of ShotSetting.
  static const std::array<SettingNames, kShotSettings.size()> kNames{{
      {"shutter", {"shutterspeed", "shutterspeed2", "exptime"}},
      {"iso", {"iso", "isospeed"}},
      {"aperture", {"aperture", "f-number"}},
      {"focus", {"focusmode", "focusmode2", "autofocus"}},
      {"imageformat", {"imageformat", "imagequality"}},
      {"program", {"expprogram", "autoexposuremode", "exposuremode"}},
  }};
  return kNames[static_cast<std::size_t>(setting)];
}

// Returns the image formats that the camera offers and that come with a JPEG.
std::string FormatsWithJpeg(GphotoCamera& camera) {
  for (const char* name : {"imageformat", "imagequality"}) {
    const auto setting = camera.Setting(name);
    if (!setting) continue;
    std::vector<std::string> with_jpeg;
    std::copy_if(setting->choices.begin(), setting->choices.end(), std::back_inserter(with_jpeg),
                 [](const std::string& format) { return FilesOf(format).jpeg; });
    return fmt::format("{}", fmt::join(with_jpeg, ", "));
  }
  return "";
}

}  // namespace

PhotographFiles FilesOf(const std::string& image_format) {
  const std::string format = Lowercase(image_format);
  const auto holds = [&](const char* word) { return format.find(word) != std::string::npos; };
  const bool both = holds("+");
  const bool raw =
      holds("raw") || holds("nef") || holds("cr2") || holds("cr3") || holds("arw") || holds("raf");
  return {raw || both, !raw || both || holds("jpeg") || holds("jpg")};
}

const char* Name(ShotSetting setting) { return NamesOf(setting).name; }

std::optional<double> PhotographicNumber(const std::string& text) {
  std::string rest = Lowercase(text);
  for (const char* prefix : {"f/", "iso", "f"})
    if (rest.starts_with(prefix)) {
      rest = rest.substr(std::string(prefix).size());
      break;
    }
  rest.erase(0, std::min(rest.find_first_not_of(' '), rest.size()));
  if (rest.empty() || !(std::isdigit(static_cast<unsigned char>(rest[0])) || rest[0] == '.'))
    return std::nullopt;
  char* end = nullptr;
  double number = std::strtod(rest.c_str(), &end);
  if (*end == '/') {
    const double below = std::strtod(end + 1, &end);
    if (!(below > 0)) return std::nullopt;
    number /= below;
  }
  while (*end == ' ') ++end;
  if (*end == 's' || *end == '"') ++end;  // seconds
  if (*end != '\0' || !(number > 0) || !std::isfinite(number)) return std::nullopt;
  return number;
}

bool IsSameSetting(const std::string& a, const std::string& b) {
  const auto x = PhotographicNumber(a), y = PhotographicNumber(b);
  if (x && y) return std::abs(std::log2(*x / *y)) < kSameStops;
  return Lowercase(a) == Lowercase(b);
}

std::optional<std::string> ChoiceFor(const std::vector<std::string>& choices, const std::string& value) {
  for (const std::string& choice : choices)
    if (Lowercase(choice) == Lowercase(value)) return choice;
  const auto number = PhotographicNumber(value);
  std::optional<std::string> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const std::string& choice : choices) {
    const auto other = PhotographicNumber(choice);
    if (!number || !other || !IsSameSetting(choice, value)) continue;
    const double off = std::abs(std::log(*other / *number));
    if (off >= least) continue;
    least = off;
    nearest = choice;
  }
  if (nearest) return nearest;
  // A part of the name is enough when only one choice contains it: "fine" of "JPEG Fine".
  std::vector<std::string> containing;
  for (const std::string& choice : choices)
    if (Lowercase(choice).find(Lowercase(value)) != std::string::npos) containing.push_back(choice);
  return containing.size() == 1 && !number ? std::optional(containing.front()) : std::nullopt;
}

std::optional<std::string> ManualChoice(const std::vector<std::string>& choices) {
  for (const char* word : {"manual", "m", "mf", "manual focus", "off", "mf (fixed)", "mf (selection)"})
    for (const std::string& choice : choices)
      if (Lowercase(choice) == word) return choice;
  return std::nullopt;
}

bool IsAutomatic(const std::string& value) {
  const std::string text = Lowercase(value);
  return text.starts_with("auto") || text == "on" || text.starts_with("af-") ||
         text.starts_with("one shot") || text.starts_with("ai ");
}

std::string RawFormatProblem(GphotoCamera& camera, const std::string& image_format) {
  if (FilesOf(image_format).jpeg) return "";
  return fmt::format(
      "the image format is '{}': ulf develops each raw file itself, and follows nothing meanwhile; where "
      "that takes too long, set imageformat= to one of {}",
      image_format, FormatsWithJpeg(camera));
}

bool ChooseTarget(GphotoCamera& camera, const std::string& uri, std::optional<bool> to_card) {
  const auto target = camera.Setting("capturetarget");
  if (!target) return false;
  const auto choice = [&](const char* word) -> std::optional<std::string> {
    for (const std::string& offered : target->choices)
      if (offered.find(word) != std::string::npos) return offered;
    return std::nullopt;
  };
  const auto card = choice("card"), ram = choice("RAM");
  bool wants_card = to_card.value_or(false);
  std::vector<GphotoStorage> storages;
  if (!to_card && camera.Storages(storages).ok())
    wants_card = std::any_of(storages.begin(), storages.end(), [](const GphotoStorage& storage) {
      return storage.is_card && !storage.is_full;
    });
  const auto wanted = wants_card ? card : ram;
  if (to_card && !wanted)
    throw Refused(uri, fmt::format("this camera does not offer target={}", wants_card ? "card" : "ram"),
                  "leave it out");
  if (wanted && target->value != *wanted) {
    const GphotoResult result = camera.Set("capturetarget", *wanted);
    if (!result.ok() && to_card)
      throw Error("{}: the target cannot be set ({}); leave target= out", uri, result.text);
  }
  const auto now = camera.Setting("capturetarget");
  return now && now->value.find("RAM") != std::string::npos;
}

bool IsInCameraMemory(const std::string& folder, bool target_is_memory) {
  return target_is_memory && !folder.starts_with("/store_");
}

CameraSettings::CameraSettings(GphotoCamera& camera, const std::string& uri) : camera_(camera), uri_(uri) {
  for (const ShotSetting setting : kShotSettings)
    for (const char* name : NamesOf(setting).drivers)
      if (const auto found = camera_.Setting(name)) {
        known_[setting] = {name, found->value};
        break;
      }
}

void CameraSettings::Lock(ShotSetting setting, const std::string& value) {
  const auto known = known_.find(setting);
  if (known == known_.end())
    throw Refused(uri_, fmt::format("this camera has no setting for {}", Name(setting)),
                  fmt::format("leave {}= out and set it on the camera", Name(setting)));
  const auto now = camera_.Setting(known->second.name);
  const std::vector<std::string> choices = now ? now->choices : std::vector<std::string>{};
  std::optional<std::string> wanted = setting == ShotSetting::kFocus && Lowercase(value) == "manual"
                                          ? ManualChoice(choices)
                                          : ChoiceFor(choices, value);
  if (!wanted && choices.empty()) wanted = value;
  if (!wanted)
    throw Refused(uri_, fmt::format("the camera does not offer {}={} now", Name(setting), value),
                  fmt::format("it offers {}", fmt::join(choices, ", ")));
  GphotoResult result;
  std::string kept = now ? now->value : "";
  for (int i = 0; i < kWriteTries && !IsSameSetting(kept, *wanted); ++i) {
    if (i > 0) std::this_thread::sleep_for(kWritePause);
    if (now && !now->writable) break;
    result = camera_.Set(known->second.name, *wanted);
    if (const auto read = camera_.Setting(known->second.name)) kept = read->value;
  }
  known->second.value = kept;
  if (IsSameSetting(kept, *wanted)) return;
  throw Error(
      "{}: {}={} could not be set: the camera keeps '{}'{}; set it on the camera (its dial, the lens's "
      "switch)",
      uri_, Name(setting), value, kept, result.ok() ? "" : " (" + result.text + ")");
}

std::vector<std::string> CameraSettings::LockRemaining(const std::vector<ShotSetting>& given) {
  std::vector<std::string> automatic;
  if (const auto program = known_.find(ShotSetting::kProgram); program != known_.end()) {
    const auto now = camera_.Setting(program->second.name);
    const auto manual = now ? ManualChoice(now->choices) : std::nullopt;
    if (manual && now->value != *manual && now->writable) camera_.Set(program->second.name, *manual);
    if (const auto read = camera_.Setting(program->second.name)) program->second.value = read->value;
    if (manual && program->second.value != *manual)
      automatic.push_back(
          fmt::format("the exposure program is '{}': turn the camera's dial to M, or the brightness "
                      "will change from photograph to photograph",
                      program->second.value));
  }
  for (const ShotSetting setting :
       {ShotSetting::kShutter, ShotSetting::kIso, ShotSetting::kAperture, ShotSetting::kFocus}) {
    const auto known = known_.find(setting);
    if (known == known_.end() || std::find(given.begin(), given.end(), setting) != given.end()) continue;
    if (const auto read = camera_.Setting(known->second.name)) known->second.value = read->value;
    if (IsAutomatic(known->second.value))
      automatic.push_back(fmt::format(
          "{} is automatic ('{}'): it may change from photograph to photograph; give {}=", Name(setting),
          known->second.value, Name(setting)));
  }
  return automatic;
}

std::vector<std::string> CameraSettings::Changes() {
  std::vector<std::string> changes;
  for (auto& [setting, known] : known_) {
    const auto read = camera_.Setting(known.name);
    if (!read || read->value == known.value) continue;
    changes.push_back(
        fmt::format("{} changed from '{}' to '{}' on the camera", Name(setting), known.value, read->value));
    known.value = read->value;
  }
  return changes;
}

std::vector<std::string> CameraSettings::Choices(ShotSetting setting) const {
  const auto known = known_.find(setting);
  if (known == known_.end()) return {};
  const auto now = camera_.Setting(known->second.name);
  return now && now->writable ? now->choices : std::vector<std::string>{};
}

std::string CameraSettings::Value(ShotSetting setting) const {
  const auto known = known_.find(setting);
  return known == known_.end() ? "" : known->second.value;
}

}  // namespace ulf::acquisition
