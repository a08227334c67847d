// Gives access to the configuration tree of a tethered camera, for `ulf features gphoto2:...`.
#include <fmt/format.h>

#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/gphoto_device.h"
#include "acquisition/gphoto2/gphoto_options.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"

namespace ulf::acquisition {
namespace {

FeatureType TypeOf(GphotoSettingType type) {
  switch (type) {
    case GphotoSettingType::kChoice:
      return FeatureType::kEnumeration;
    case GphotoSettingType::kRange:
      return FeatureType::kFloat;
    case GphotoSettingType::kToggle:
      return FeatureType::kBoolean;
    case GphotoSettingType::kDate:
      return FeatureType::kInteger;
    case GphotoSettingType::kButton:
      return FeatureType::kCommand;
    case GphotoSettingType::kText:
      break;
  }
  return FeatureType::kString;
}

CameraFeature FeatureOf(const GphotoSetting& setting) {
  CameraFeature feature;
  feature.name = setting.name;
  feature.category = setting.category;
  feature.type = TypeOf(setting.type);
  feature.value = setting.value;
  // libgphoto2 runs buttons by its own callbacks, so they cannot be written.
  feature.readable = setting.type != GphotoSettingType::kButton;
  feature.writable = !setting.read_only && setting.type != GphotoSettingType::kButton;
  feature.read_only = setting.type == GphotoSettingType::kButton;
  feature.choices = setting.choices;
  feature.description = setting.label;
  if (setting.type == GphotoSettingType::kDate) feature.unit = "s since 1970";
  if (setting.type == GphotoSettingType::kRange) {
    feature.min = setting.min;
    feature.max = setting.max;
    if (setting.step > 0) feature.step = setting.step;
  }
  return feature;
}

class GphotoFeatures : public FeatureAccess {
 public:
  explicit GphotoFeatures(const DeviceUri& uri) : uri_(uri.Text()), camera_(uri_, ResolveGphotoAddress(uri)) {
    uri.AllowOnly({});
    info_ = DescribeGphoto(camera_, uri_, "PTP");
  }

  DeviceInfo Info() const override { return info_; }
  std::vector<CameraFeature> List() override {
    std::vector<CameraFeature> features;
    for (const GphotoSetting& setting : camera_.Settings()) features.push_back(FeatureOf(setting));
    return features;
  }
  std::optional<CameraFeature> Find(const std::string& name) override {
    for (const GphotoSetting& setting : camera_.Settings())
      if (setting.name == name) return FeatureOf(setting);
    return std::nullopt;
  }

  void Set(const std::string& name, const std::string& value) override {
    const auto feature = Find(name);
    if (!feature)
      throw Refusal(uri_, "", fmt::format("there is no feature '{}'", name),
                    fmt::format("'ulf features {}' lists them", ShellWord(uri_)));
    if (!feature->writable) throw Refusal(uri_, "", fmt::format("{} cannot be written", name), "");
    std::string written = value;
    if (feature->type != FeatureType::kEnumeration) {
      written = CheckedValue(uri_, *feature, value);
    } else if (!feature->choices.empty()) {
      const auto choice = ChoiceFor(feature->choices, value);
      if (!choice)
        throw Refusal(uri_, "", fmt::format("{} cannot be '{}'", name, value),
                      fmt::format("it takes {}", fmt::join(feature->choices, ", ")));
      written = *choice;
    }
    if (feature->type == FeatureType::kBoolean) written = std::string(written == "true" ? "1" : "0");
    const GphotoResult result = camera_.Set(name, written);
    if (!result.ok()) throw Error("{}: the camera refused {}={}: {}", uri_, name, value, result.text);
  }

 private:
  std::string uri_;
  GphotoCamera camera_;
  DeviceInfo info_;
};

}  // namespace

std::unique_ptr<FeatureAccess> OpenGphotoFeatures(const DeviceUri& uri) {
  return std::make_unique<GphotoFeatures>(uri);
}

}  // namespace ulf::acquisition
