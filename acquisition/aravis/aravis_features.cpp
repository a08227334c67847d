#include "acquisition/aravis/aravis_device.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <sstream>

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_description.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/aravis_setting.h"
#include "core/base/error.h"
#include "core/frames/pixel_format.h"

namespace ulf::acquisition {
namespace {

constexpr double kUnlimitedFps = 1e9;  // a limit of this or more is the library's, not the camera's

std::string SquashSpace(const std::string& text) {
  std::istringstream words(text);
  std::string squashed;
  for (std::string word; words >> word;) squashed += (squashed.empty() ? "" : " ") + word;
  return squashed;
}

// Returns a property (Streamable, Visibility) among a node's children; none if there is none.
template <typename Value, typename Read>
std::optional<Value> Property(ArvGcNode* node, const char* name, Value undefined, Read read) {
  for (ArvDomNode* child = arv_dom_node_get_first_child(ARV_DOM_NODE(node)); child;
       child = arv_dom_node_get_next_sibling(child))
    if (ARV_IS_GC_PROPERTY_NODE(child) && Text(arv_dom_node_get_node_name(child)) == name) {
      const Value value = read(ARV_GC_PROPERTY_NODE(child), undefined);
      if (value != undefined) return value;
    }
  return std::nullopt;
}

std::optional<bool> StreamableOf(ArvGcNode* node) {
  const auto value =
      Property(node, "Streamable", ARV_GC_STREAMABLE_UNDEFINED, arv_gc_property_node_get_streamable);
  if (!value) return std::nullopt;
  return *value == ARV_GC_STREAMABLE_YES;
}

FeatureVisibility VisibilityOf(ArvGcNode* node) {
  switch (Property(node, "Visibility", ARV_GC_VISIBILITY_UNDEFINED, arv_gc_property_node_get_visibility)
              .value_or(ARV_GC_VISIBILITY_BEGINNER)) {
    case ARV_GC_VISIBILITY_EXPERT:
      return FeatureVisibility::kExpert;
    case ARV_GC_VISIBILITY_GURU:
      return FeatureVisibility::kGuru;
    case ARV_GC_VISIBILITY_INVISIBLE:
      return FeatureVisibility::kInvisible;
    default:
      return FeatureVisibility::kBeginner;
  }
}

class AravisFeatures : public FeatureAccess {
 public:
  explicit AravisFeatures(const DeviceUri& uri) {
    if (!uri.options.empty())
      throw Refused(uri, "ulf features sets features by name", "leave the options after '?' out");
    info_.uri = uri.Text();
    session_ =
        AravisSession::Open(info_.uri, ResolveAravis(info_.uri, uri.path), AravisSession::Wanted::kReading);
    session_->Describe(info_);
    genicam_ = arv_device_get_genicam(session_->Device());
    arv_device_set_range_check_policy(session_->Device(), ARV_RANGE_CHECK_POLICY_ENABLE);
    arv_device_set_access_check_policy(session_->Device(), ARV_ACCESS_CHECK_POLICY_ENABLE);
    Walk("Root", "");
    WalkOrphans(ARV_DOM_NODE(genicam_));
    for (const auto& [name, category] : tree_)
      description_marks_streamable_ |= StreamableOf(arv_gc_get_node(genicam_, name.c_str())).value_or(false);
  }

  DeviceInfo Info() const override { return info_; }

  std::vector<OfferedFormat> Formats() override {
    ArvCamera* camera = session_->Camera();
    // With the present binning. Offsets reduce the limit of Width, but not WidthMax.
    const auto largest = [&](const char* of_image, void (*bounds)(ArvCamera*, gint*, gint*, GError**)) {
      gint low = 0, high = 0;
      FailureOf(bounds, camera, &low, &high);
      const auto feature = Read(of_image, "");
      return feature && feature->readable ? std::max(high, std::atoi(feature->value.c_str())) : high;
    };
    OfferedFormat common{.width = largest("WidthMax", arv_camera_get_width_bounds),
                         .height = largest("HeightMax", arv_camera_get_height_bounds),
                         .any_size = true};
    double slowest = 0, fastest = 0;
    if (TryCall(arv_camera_is_frame_rate_available, camera).value_or(false))
      FailureOf(arv_camera_get_frame_rate_bounds, camera, &slowest, &fastest);
    common.any_fps = fastest > 0 && fastest < kUnlimitedFps;
    if (common.any_fps) common.fps = {slowest, fastest};
    std::vector<OfferedFormat> formats;
    for (const std::string& name : CallForNames(arv_camera_dup_available_pixel_formats_as_strings, camera)) {
      formats.push_back(common);
      formats.back().name = name;
      formats.back().supported = PixelFormatByName(name).has_value();
    }
    return formats;
  }

  std::vector<CameraFeature> List() override {
    std::vector<CameraFeature> features;
    for (const auto& [name, category] : tree_)
      if (auto feature = Read(name, category)) features.push_back(std::move(*feature));
    return features;
  }

  std::optional<CameraFeature> Find(const std::string& name) override {
    for (const auto& [known, category] : tree_)
      if (known == name) return Read(name, category);
    return Read(name, "");
  }

  void Set(const std::string& name, const std::string& text) override {
    const auto feature = Find(name);
    if (!feature) throw Refused(info_.uri, fmt::format("has no feature '{}'", name));
    if (!session_->IsController())
      throw Error("{}: {} cannot be written: {}", info_.uri, name, session_->WhoControls());
    if (!feature->writable) {
      if (feature->readable && SameValue(*feature, feature->value, text)) return;
      throw Refused(info_.uri, fmt::format("{} is read-only, or locked by another setting{}", name,
                                           feature->readable ? ", at " + feature->value : ""));
    }
    const std::string value = CheckedValue(info_.uri, *feature, text);
    if (feature->type == FeatureType::kCommand)
      return CallOrThrow(info_.uri, name, arv_device_execute_command, session_->Device(), name.c_str());
    if (const std::string why = WriteSetting(*session_, name, value); !why.empty())
      throw Error("{}: {}={}: {}", info_.uri, name, value, why);
  }

 private:
  void Walk(const std::string& name, const std::string& category) {
    ArvGcNode* node = arv_gc_get_node(genicam_, name.c_str());
    if (!node || !walked_.insert(name).second) return;
    if (!ARV_IS_GC_CATEGORY(node)) {
      if (KindOf(node)) tree_.emplace_back(name, category);
      return;
    }
    const std::string inner = name == "Root" ? "" : category.empty() ? name : category + "/" + name;
    for (const GSList* entry = arv_gc_category_get_features(ARV_GC_CATEGORY(node)); entry;
         entry = entry->next)
      Walk(Text(static_cast<const char*>(entry->data)), inner);
  }

  // Adds categories that the description does not link into the tree.
  void WalkOrphans(ArvDomNode* node) {
    for (ArvDomNode* child = arv_dom_node_get_first_child(node); child;
         child = arv_dom_node_get_next_sibling(child)) {
      if (ARV_IS_GC_CATEGORY(child))
        Walk(Text(arv_gc_feature_node_get_name(ARV_GC_FEATURE_NODE(child))), "");
      else if (!ARV_IS_GC_FEATURE_NODE(child))
        WalkOrphans(child);
    }
  }

  std::optional<CameraFeature> Read(const std::string& name, const std::string& category) {
    ArvGcNode* node = arv_gc_get_node(genicam_, name.c_str());
    const auto type = KindOf(node);
    if (!type) return std::nullopt;
    ArvGcFeatureNode* feature_node = ARV_GC_FEATURE_NODE(node);
    if (!TryCall(arv_gc_feature_node_is_implemented, feature_node).value_or(true)) return std::nullopt;
    CameraFeature feature;
    feature.name = name;
    feature.category = category;
    feature.type = *type;
    feature.description = SquashSpace(Text(arv_gc_feature_node_get_description(feature_node)));
    if (feature.description.empty())
      feature.description = SquashSpace(Text(arv_gc_feature_node_get_tooltip(feature_node)));
    feature.visibility = VisibilityOf(node);
    feature.streamable = StreamableOf(node).value_or(!description_marks_streamable_);
    const bool available = TryCall(arv_gc_feature_node_is_available, feature_node).value_or(true);
    // The library's access mode does not include the lock.
    const bool locked = TryCall(arv_gc_feature_node_is_locked, feature_node).value_or(false);
    const ArvGcAccessMode access = arv_gc_feature_node_get_actual_access_mode(feature_node);
    feature.readable = available && access != ARV_GC_ACCESS_MODE_WO && *type != FeatureType::kCommand;
    feature.writable = available && !locked && access != ARV_GC_ACCESS_MODE_RO;
    feature.read_only = access == ARV_GC_ACCESS_MODE_RO;
    if (available) ReadRange(node, feature);
    const auto value = feature.readable ? ValueOf(node) : std::nullopt;
    feature.readable = value.has_value();
    feature.value = value.value_or("");
    if (ARV_IS_GC_SELECTOR(node))
      for (const GSList* entry = arv_gc_selector_get_selected_features(ARV_GC_SELECTOR(node)); entry;
           entry = entry->next)
        if (ARV_IS_GC_FEATURE_NODE(entry->data))
          feature.selects.push_back(Text(arv_gc_feature_node_get_name(ARV_GC_FEATURE_NODE(entry->data))));
    return feature;
  }

  // If a description gives no limits, the library returns those of its types; they are left out.
  void ReadRange(ArvGcNode* node, CameraFeature& feature) {
    if (feature.type == FeatureType::kInteger) {
      constexpr gint64 kLeast = std::numeric_limits<gint64>::min(),
                       kMost = std::numeric_limits<gint64>::max();
      ArvGcInteger* integer = ARV_GC_INTEGER(node);
      const gint64 low = TryCall(arv_gc_integer_get_min, integer).value_or(kLeast);
      const gint64 high = TryCall(arv_gc_integer_get_max, integer).value_or(kMost);
      const gint64 step = TryCall(arv_gc_integer_get_inc, integer).value_or(1);
      if (low != kLeast) feature.min = static_cast<double>(low);
      if (high != kMost) feature.max = static_cast<double>(high);
      if (step > 0) feature.step = static_cast<double>(step);
      feature.unit = Text(arv_gc_integer_get_unit(integer));
    } else if (feature.type == FeatureType::kFloat) {
      ArvGcFloat* real = ARV_GC_FLOAT(node);
      const double low = TryCall(arv_gc_float_get_min, real).value_or(-DBL_MAX);
      const double high = TryCall(arv_gc_float_get_max, real).value_or(DBL_MAX);
      const double step = TryCall(arv_gc_float_get_inc, real).value_or(0.0);
      if (std::isfinite(low) && low > -DBL_MAX) feature.min = low;
      if (std::isfinite(high) && high < DBL_MAX) feature.max = high;
      if (std::isfinite(step) && step > 2 * DBL_MIN) feature.step = step;
      feature.unit = Text(arv_gc_float_get_unit(real));
    } else if (feature.type == FeatureType::kEnumeration) {
      feature.choices =
          CallForNames(arv_gc_enumeration_dup_available_string_values, ARV_GC_ENUMERATION(node));
    }
  }

  DeviceInfo info_;
  std::unique_ptr<AravisSession> session_;
  ArvGc* genicam_ = nullptr;
  std::vector<std::pair<std::string, std::string>> tree_;  // name, category
  std::set<std::string> walked_;
  bool description_marks_streamable_ = false;
};

}  // namespace

std::unique_ptr<FeatureAccess> OpenAravisFeatures(const DeviceUri& uri) {
  return std::make_unique<AravisFeatures>(uri);
}

}  // namespace ulf::acquisition
