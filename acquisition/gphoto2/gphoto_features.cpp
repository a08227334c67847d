// Gives access to the configuration tree of a tethered camera, for `ulf features gphoto2:...`.
#include <fmt/format.h>

#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/gphoto_device.h"
#include "acquisition/gphoto2/gphoto_options.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"

namespace ulf::acquisition {
namespace {

class GphotoFeatures : public FeatureAccess {
 public:
  explicit GphotoFeatures(const DeviceUri& uri) : uri_(uri.Text()), camera_(uri_, ResolveGphotoAddress(uri)) {
    uri.AllowOnly({});
    info_ = DescribeGphoto(camera_, uri_, "PTP");
  }

  DeviceInfo Info() const override { return info_; }
  std::vector<CameraFeature> List() override { return camera_.Settings(); }
  std::optional<CameraFeature> Find(const std::string& name) override {
    for (CameraFeature& setting : camera_.Settings())
      if (setting.name == name) return std::move(setting);
    return std::nullopt;
  }

  void Set(const std::string& name, const std::string& value) override {
    const auto feature = Find(name);
    if (!feature)
      throw Refused(uri_, fmt::format("there is no feature '{}'", name),
                    fmt::format("'ulf features {}' lists them", ShellWord(uri_)));
    if (!feature->writable) throw Refused(uri_, fmt::format("{} cannot be written", name));
    std::string written = value;
    if (feature->type != FeatureType::kEnumeration) {
      written = CheckedValue(uri_, *feature, value);
    } else if (!feature->choices.empty()) {
      const auto choice = ChoiceFor(feature->choices, value);
      if (!choice)
        throw Refused(uri_, fmt::format("{} cannot be '{}'", name, value),
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
