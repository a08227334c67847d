#include "acquisition/aravis/aravis_description.h"

#include <fmt/format.h>

#include <cfloat>
#include <cmath>
#include <limits>

namespace ulf::acquisition {
namespace {

// Names all entries of an enumeration, also those that are not available now.
std::vector<std::string> EntriesOf(ArvGcNode* node) {
  std::vector<std::string> names;
  if (!node || !ARV_IS_GC_ENUMERATION(node)) return names;
  for (const GSList* entry = arv_gc_enumeration_get_entries(ARV_GC_ENUMERATION(node)); entry;
       entry = entry->next)
    if (ARV_IS_GC_FEATURE_NODE(entry->data))
      names.push_back(Text(arv_gc_feature_node_get_name(ARV_GC_FEATURE_NODE(entry->data))));
  return names;
}

std::string UnitOf(ArvGcNode* node) {
  if (KindOf(node) == FeatureType::kFloat) return Text(arv_gc_float_get_unit(ARV_GC_FLOAT(node)));
  if (KindOf(node) == FeatureType::kInteger) return Text(arv_gc_integer_get_unit(ARV_GC_INTEGER(node)));
  return "";
}

// Reads what stands in the description, not what a register would say.
std::optional<double> LeastInText(ArvGcNode* node) {
  if (!node) return std::nullopt;
  for (ArvDomNode* child = arv_dom_node_get_first_child(ARV_DOM_NODE(node)); child;
       child = arv_dom_node_get_next_sibling(child))
    if (ARV_IS_GC_PROPERTY_NODE(child) && Text(arv_dom_node_get_node_name(child)) == "Min") {
      const auto least = TryCall(arv_gc_property_node_get_double, ARV_GC_PROPERTY_NODE(child));
      if (least) return least;
    }
  return std::nullopt;
}

std::optional<double> LeastNow(ArvGcNode* node) {
  std::optional<double> least;
  if (KindOf(node) == FeatureType::kFloat) {
    least = TryCall(arv_gc_float_get_min, ARV_GC_FLOAT(node));
  } else if (KindOf(node) == FeatureType::kInteger) {
    const auto whole = TryCall(arv_gc_integer_get_min, ARV_GC_INTEGER(node));
    if (whole && *whole > std::numeric_limits<gint64>::min()) least = static_cast<double>(*whole);
  }
  return least && *least > -DBL_MAX && std::isfinite(*least) ? least : std::nullopt;
}

}  // namespace

std::optional<FeatureType> KindOf(ArvGcNode* node) {
  if (!node) return std::nullopt;
  if (ARV_IS_GC_ENUMERATION(node)) return FeatureType::kEnumeration;
  if (ARV_IS_GC_COMMAND(node)) return FeatureType::kCommand;
  if (ARV_IS_GC_BOOLEAN(node)) return FeatureType::kBoolean;
  if (ARV_IS_GC_FLOAT(node)) return FeatureType::kFloat;
  if (ARV_IS_GC_INTEGER(node)) return FeatureType::kInteger;
  if (ARV_IS_GC_STRING(node)) return FeatureType::kString;
  return std::nullopt;
}

std::optional<std::string> ValueOf(ArvGcNode* node) {
  const auto as_text = [](const auto& value) -> std::optional<std::string> {
    return value ? std::optional(fmt::format("{}", *value)) : std::nullopt;
  };
  const auto kind = KindOf(node);
  if (kind == FeatureType::kInteger) return as_text(TryCall(arv_gc_integer_get_value, ARV_GC_INTEGER(node)));
  if (kind == FeatureType::kFloat) return as_text(TryCall(arv_gc_float_get_value, ARV_GC_FLOAT(node)));
  if (kind == FeatureType::kBoolean)
    if (const auto value = TryCall(arv_gc_boolean_get_value, ARV_GC_BOOLEAN(node)))
      return *value ? "true" : "false";
  // On failure the library returns memory that nothing ends.
  if (kind == FeatureType::kEnumeration)
    if (const auto value = TryCall(arv_gc_enumeration_get_string_value, ARV_GC_ENUMERATION(node)))
      return Text(*value);
  if (kind == FeatureType::kString)
    if (const auto value = TryCall(arv_gc_string_get_value, ARV_GC_STRING(node))) return Text(*value);
  return std::nullopt;
}

NamedFeatures FeaturesOf(ArvGc* description) {
  const auto node_of = [description](const std::string& name) {
    return arv_gc_get_node(description, name.c_str());
  };
  return {.kind_of = [node_of](const std::string& name) { return KindOf(node_of(name)); },
          .is_available = [](const std::string&) { return true; },
          .choices_of = [node_of](const std::string& name) { return EntriesOf(node_of(name)); },
          .unit_of = [node_of](const std::string& name) { return UnitOf(node_of(name)); },
          .least_of = [node_of](const std::string& name) { return LeastInText(node_of(name)); }};
}

NamedFeatures FeaturesOf(ArvCamera* camera) {
  const auto node_of = [camera](const std::string& name) {
    return arv_device_get_feature(arv_camera_get_device(camera), name.c_str());
  };
  return {.kind_of =
              [camera, node_of](const std::string& name) {
                return TryCall(arv_camera_is_feature_implemented, camera, name.c_str()).value_or(false)
                           ? KindOf(node_of(name))
                           : std::nullopt;
              },
          .is_available =
              [camera](const std::string& name) {
                return TryCall(arv_camera_is_feature_available, camera, name.c_str()).value_or(false);
              },
          .choices_of =
              [camera](const std::string& name) {
                return CallForNames(arv_camera_dup_available_enumerations_as_strings, camera, name.c_str());
              },
          .unit_of = [node_of](const std::string& name) { return UnitOf(node_of(name)); },
          .least_of = [node_of](const std::string& name) { return LeastNow(node_of(name)); }};
}

}  // namespace ulf::acquisition
