#include "acquisition/device/feature_file.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"

namespace ulf::acquisition {
namespace {

constexpr const char* kFormat = "ulf-features";
constexpr int kVersion = 1;
// Bounds on saved tables, guessed: a look-up table of thousands of entries would take minutes to read.
constexpr std::size_t kLongestIntegerSelector = 16;
constexpr std::size_t kMostCombinations = 256;
constexpr int kMostRounds = 20;  // guessed: dependencies between settings are a few levels deep

using Selection = std::vector<std::pair<std::string, std::string>>;

// Returns the values of a selector under which features are saved; of too many only the present one.
std::vector<std::string> ValuesOf(const CameraFeature& selector) {
  if (!selector.writable) return {selector.value};
  if (selector.type == FeatureType::kEnumeration) return selector.choices;
  if (selector.type == FeatureType::kBoolean) return {"false", "true"};
  if (selector.type == FeatureType::kInteger && selector.min && selector.max) {
    const double step = std::max(1.0, selector.step.value_or(1));
    const double steps = (*selector.max - *selector.min) / step;
    if (steps < kLongestIntegerSelector) {
      std::vector<std::string> values;
      for (int i = 0; i <= steps; ++i) values.push_back(fmt::format("{:.0f}", *selector.min + i * step));
      return values;
    }
  }
  return {selector.value};
}

bool BelongsInFile(const CameraFeature& feature) {
  return feature.streamable && feature.readable && feature.writable && feature.type != FeatureType::kCommand;
}

void Select(FeatureAccess& access, const Selection& selection) {
  for (const auto& [name, value] : selection) {
    const auto selector = access.Find(name);
    if (selector && !SameValue(*selector, selector->value, value)) access.Set(name, value);
  }
}

std::vector<Selection> CombinationsOf(const std::vector<CameraFeature>& selectors) {
  std::vector<Selection> combinations{{}};
  for (const CameraFeature& selector : selectors) {
    std::vector<Selection> longer;
    const std::vector<std::string> values = ValuesOf(selector);
    const bool too_many = combinations.size() * values.size() > kMostCombinations;
    for (const Selection& selection : combinations)
      for (const std::string& value : too_many ? std::vector{selector.value} : values) {
        longer.push_back(selection);
        longer.back().emplace_back(selector.name, value);
      }
    combinations = std::move(longer);
  }
  return combinations;
}

struct Attempt {
  bool matches = false, changed = false;
  std::string reads, reason;
};

Attempt CompareOrWrite(FeatureAccess& access, const SavedFeature& wanted, bool write) {
  Attempt attempt;
  try {
    Select(access, wanted.selectors);
    auto feature = access.Find(wanted.name);
    if (!feature) {
      attempt.reason = "this camera has no such feature";
      return attempt;
    }
    attempt.reads = feature->value;
    attempt.matches = SameValue(*feature, feature->value, wanted.value);
    if (attempt.matches || !write) return attempt;
    access.Set(wanted.name, wanted.value);
    feature = access.Find(wanted.name);
    attempt.changed = !SameValue(*feature, feature->value, attempt.reads);
    attempt.reads = feature->value;
    attempt.matches = SameValue(*feature, feature->value, wanted.value);
  } catch (const Error& error) {
    attempt.reason = error.what();
  }
  return attempt;
}

}  // namespace

std::string SavedFeature::Text() const {
  if (selectors.empty()) return name;
  std::string inside;
  for (const auto& [selector, chosen] : selectors)
    inside += (inside.empty() ? "" : ",") + selector + "=" + chosen;
  return name + "[" + inside + "]";
}

FeatureFile CollectFeatures(FeatureAccess& access) {
  FeatureFile file{.device = access.Info(), .features = {}};
  const std::vector<CameraFeature> all = access.List();
  std::map<std::string, std::vector<CameraFeature>> selectors_of;
  for (const CameraFeature& feature : all)
    for (const std::string& selected : feature.selects) selectors_of[selected].push_back(feature);
  std::vector<SavedFeature> selectors;  // written last, so that loading the file ends with these selections
  for (const CameraFeature& feature : all) {
    const auto found = selectors_of.find(feature.name);
    if (!feature.selects.empty()) {
      if (feature.writable) selectors.push_back({feature.name, feature.value, {}});
      continue;
    }
    if (found == selectors_of.end()) {
      if (BelongsInFile(feature)) file.features.push_back({feature.name, feature.value, {}});
      continue;
    }
    // Whether it can be written may differ from one selection to the next.
    if (!feature.streamable || feature.type == FeatureType::kCommand) continue;
    for (const Selection& selection : CombinationsOf(found->second)) {
      try {
        Select(access, selection);
      } catch (const Error&) {
        continue;  // a combination that the camera does not have
      }
      const auto here = access.Find(feature.name);
      if (here && BelongsInFile(*here)) file.features.push_back({here->name, here->value, selection});
    }
    for (const CameraFeature& selector : found->second)
      if (selector.writable) Select(access, {{selector.name, selector.value}});
  }
  file.features.insert(file.features.end(), selectors.begin(), selectors.end());
  return file;
}

void WriteFeatureFile(const std::filesystem::path& path, const FeatureFile& file) {
  nlohmann::ordered_json features = nlohmann::ordered_json::array();
  for (const SavedFeature& saved : file.features) {
    nlohmann::ordered_json entry{{"name", saved.name}, {"value", saved.value}};
    for (const auto& [selector, value] : saved.selectors) entry["selectors"][selector] = value;
    features.push_back(entry);
  }
  const nlohmann::ordered_json document{{"format", kFormat},
                                        {"version", kVersion},
                                        {"device",
                                         {{"maker", file.device.maker},
                                          {"model", file.device.model},
                                          {"serial", file.device.serial},
                                          {"bus", file.device.bus}}},
                                        {"features", features}};
  WriteFileAtomically(path, document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

FeatureFile ReadFeatureFile(const std::filesystem::path& path) {
  const std::string text = ReadWholeFile(path);
  const nlohmann::json plain =
      ParseJson(text, path.string(), "write it with 'ulf features URI --save FILE', or mend that place");
  const auto document = nlohmann::ordered_json::parse(text);
  const JsonPlace place{plain, path.string()};
  if (!plain.is_object() || place.Text("format", "") != kFormat)
    throw Error("{}: is not a feature file; write one with 'ulf features URI --save {}'", path.string(),
                path.filename().string());
  if (place.Integer("version") != kVersion)
    throw Error("{}: has version {}, this program reads {}; save it again", path.string(),
                place.Integer("version"), kVersion);
  FeatureFile file;
  if (place.Has("device")) {
    const JsonPlace device{place.Raw("device"), path.string() + ", device"};
    file.device.maker = device.Text("maker", "");
    file.device.model = device.Text("model", "");
    file.device.serial = device.Text("serial", "");
    file.device.bus = device.Text("bus", "");
  }
  if (!place.Raw("features").is_array()) throw Error("{}: 'features' must be a list", path.string());
  std::size_t number = 0;
  for (const nlohmann::ordered_json& ordered : document.at("features")) {
    const std::string where = fmt::format("{}, feature {}", path.string(), ++number);
    const nlohmann::json entry(ordered);
    const JsonPlace feature{entry, where};
    SavedFeature saved{.name = feature.Text("name"), .value = feature.Text("value"), .selectors = {}};
    if (feature.Has("selectors")) {
      if (!entry.at("selectors").is_object()) throw Error("{}: 'selectors' must be an object", where);
      for (const auto& [selector, value] : ordered.at("selectors").items()) {
        if (!value.is_string()) throw Error("{}: the selector '{}' must be text", where, selector);
        saved.selectors.emplace_back(selector, value.get<std::string>());
      }
    }
    file.features.push_back(std::move(saved));
  }
  return file;
}

FeatureLoadSummary ApplyFeatures(const FeatureFile& file, FeatureAccess& access) {
  FeatureLoadSummary summary;
  std::set<std::string> selectors;  // every round changes them, so they do not count as progress
  for (const SavedFeature& saved : file.features)
    for (const auto& [selector, value] : saved.selectors) selectors.insert(selector);
  std::set<std::size_t> written;
  std::vector<std::string> reasons(file.features.size());
  bool progress = true;
  while (progress && summary.rounds < kMostRounds) {
    progress = false;
    ++summary.rounds;
    for (std::size_t i = 0; i < file.features.size(); ++i) {
      const Attempt attempt = CompareOrWrite(access, file.features[i], true);
      reasons[i] = attempt.reason;
      if (attempt.changed && !selectors.count(file.features[i].name)) {
        written.insert(i);
        progress = true;
      }
    }
  }
  for (std::size_t i = 0; i < file.features.size(); ++i) {
    // Reading changes the selectors. They come last in the file and are restored here.
    const bool is_selector = selectors.count(file.features[i].name) > 0;
    const Attempt found = CompareOrWrite(access, file.features[i], is_selector);
    if (found.matches) {
      ++summary.taken;
      summary.changed += written.count(i);
    } else {
      summary.refused.push_back(
          {file.features[i], found.reads, reasons[i].empty() ? found.reason : reasons[i]});
    }
  }
  return summary;
}

}  // namespace ulf::acquisition
