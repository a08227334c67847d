#include "acquisition/v4l2/v4l2_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "acquisition/v4l2/v4l2_controls.h"
#include "acquisition/v4l2/v4l2_modes.h"
#include "acquisition/v4l2/v4l2_node.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

FeatureType TypeOf(const V4l2Control& control) {
  if (control.IsMenu()) return FeatureType::kEnumeration;
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN) return FeatureType::kBoolean;
  return control.type == V4L2_CTRL_TYPE_BUTTON ? FeatureType::kCommand : FeatureType::kInteger;
}

const char* UnitOf(const V4l2Control& control) {
  if (control.id == V4L2_CID_EXPOSURE_ABSOLUTE) return "100 us";
  // No standard defines their unit.
  if (control.id == V4L2_CID_GAIN || control.id == V4L2_CID_ANALOGUE_GAIN ||
      control.id == V4L2_CID_DIGITAL_GAIN)
    return "driver units";
  return control.id == V4L2_CID_WHITE_BALANCE_TEMPERATURE ? "K" : "";
}

class V4l2Features : public FeatureAccess {
 public:
  explicit V4l2Features(const DeviceUri& uri)
      : camera_(ResolveV4l2Camera(uri.Text(), uri.path)), node_(camera_.node) {
    if (!uri.options.empty())
      throw Refused(uri, "ulf features sets features by name", "leave the options after '?' out");
  }

  DeviceInfo Info() const override { return camera_.info; }

  std::vector<OfferedFormat> Formats() override {
    std::vector<OfferedFormat> formats;
    for (const V4l2Mode& mode : V4l2Modes(node_))
      formats.push_back({.name = std::string(mode.format.name),
                         .code = FourccText(mode.fourcc),
                         .width = mode.width,
                         .height = mode.height,
                         .fps = mode.fps,
                         .any_fps = mode.any_fps});
    for (const std::uint32_t code : UnreadV4l2Formats(node_))
      formats.push_back({.name = FourccText(code), .code = FourccText(code), .supported = false});
    return formats;
  }

  std::vector<CameraFeature> List() override {
    std::vector<CameraFeature> features;
    // Queried each time, because switching an automatic off makes the control that it changed writable.
    for (const V4l2Control& control : V4l2Controls(node_)) features.push_back(FeatureOf(control));
    return features;
  }

  std::optional<CameraFeature> Find(const std::string& name) override {
    const auto control = FindControl(name);
    return control ? std::optional(FeatureOf(*control)) : std::nullopt;
  }

  void Set(const std::string& name, const std::string& value) override {
    const auto control = FindControl(name);
    if (!control) {
      std::vector<std::string> names;
      for (const V4l2Control& known : V4l2Controls(node_))
        if (!(known.flags & V4L2_CTRL_FLAG_READ_ONLY)) names.push_back(known.name);
      throw Refused(camera_.info.uri, fmt::format("there is no control '{}'", name),
                    fmt::format("the nearest are {}", fmt::join(NearestNames(name, names), ", ")));
    }
    if (control->flags & V4L2_CTRL_FLAG_READ_ONLY)
      throw Refused(camera_.info.uri, fmt::format("{} is read-only", name));
    const bool is_button = control->type == V4L2_CTRL_TYPE_BUTTON;
    const int number = is_button ? 1 : V4l2ControlValue(camera_.info.uri, *control, value);
    if (const int error = SetV4l2Control(node_, control->id, number); error != 0)
      throw Error("{}: {} cannot be set to {}: {}", camera_.info.uri, name, value,
                  control->flags & V4L2_CTRL_FLAG_INACTIVE ? "an automatic sets it; switch that off first"
                                                           : std::strerror(error));
  }

 private:
  std::optional<V4l2Control> FindControl(const std::string& name) const {
    const auto controls = V4l2Controls(node_);
    const auto found = std::find_if(controls.begin(), controls.end(),
                                    [&](const V4l2Control& control) { return control.Answers(name); });
    return found == controls.end() ? std::nullopt : std::optional(*found);
  }

  CameraFeature FeatureOf(const V4l2Control& control) const {
    CameraFeature feature;
    feature.name = control.name;
    feature.category = control.category;
    feature.type = TypeOf(control);
    feature.unit = UnitOf(control);
    feature.description = control.title;
    if (!control.short_name.empty()) feature.description += " (also called " + control.short_name + ")";
    feature.writable =
        !(control.flags & (V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_INACTIVE | V4L2_CTRL_FLAG_GRABBED));
    feature.read_only = control.flags & V4L2_CTRL_FLAG_READ_ONLY;
    const auto value =
        control.flags & V4L2_CTRL_FLAG_WRITE_ONLY ? std::nullopt : GetV4l2Control(node_, control.id);
    feature.readable = value.has_value();
    if (value && feature.type != FeatureType::kCommand) feature.value = V4l2ControlText(control, *value);
    feature.streamable = feature.readable && feature.type != FeatureType::kCommand &&
                         !(control.flags & V4L2_CTRL_FLAG_READ_ONLY);
    if (feature.type == FeatureType::kInteger) {
      feature.min = control.min;
      feature.max = control.max;
      feature.step = control.step;
    }
    for (const auto& [number, words] : control.menu) feature.choices.push_back(words);
    return feature;
  }

  const V4l2Camera camera_;
  const V4l2Node node_;
};

}  // namespace

std::unique_ptr<FeatureAccess> OpenV4l2Features(const DeviceUri& uri) {
  return std::make_unique<V4l2Features>(uri);
}

}  // namespace ulf::acquisition
