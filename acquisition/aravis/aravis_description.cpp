#include "acquisition/aravis/aravis_description.h"

#include <cfloat>
#include <cmath>
#include <limits>

namespace ulf::acquisition {
namespace {

// Of an enumeration, also those that are not available now.
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
  if (KindOf(node) == NodeKind::kReal) return Text(arv_gc_float_get_unit(ARV_GC_FLOAT(node)));
  if (KindOf(node) == NodeKind::kInteger) return Text(arv_gc_integer_get_unit(ARV_GC_INTEGER(node)));
  return "";
}

// Of a description alone: what stands in it, not what a register would say.
std::optional<double> LeastInText(ArvGcNode* node) {
  if (!node) return std::nullopt;
  for (ArvDomNode* child = arv_dom_node_get_first_child(ARV_DOM_NODE(node)); child;
       child = arv_dom_node_get_next_sibling(child))
    if (ARV_IS_GC_PROPERTY_NODE(child) && Text(arv_dom_node_get_node_name(child)) == "Min") {
      GError* error = nullptr;
      const double least = arv_gc_property_node_get_double(ARV_GC_PROPERTY_NODE(child), &error);
      if (!error) return least;
      g_clear_error(&error);
    }
  return std::nullopt;
}

std::optional<double> LeastNow(ArvGcNode* node) {
  GError* error = nullptr;
  double least = -DBL_MAX;
  if (KindOf(node) == NodeKind::kReal) {
    least = arv_gc_float_get_min(ARV_GC_FLOAT(node), &error);
  } else if (KindOf(node) == NodeKind::kInteger) {
    const gint64 whole = arv_gc_integer_get_min(ARV_GC_INTEGER(node), &error);
    if (whole > std::numeric_limits<gint64>::min()) least = static_cast<double>(whole);
  }
  const bool told = !error && least > -DBL_MAX && std::isfinite(least);
  g_clear_error(&error);
  return told ? std::optional(least) : std::nullopt;
}

}  // namespace

NodeKind KindOf(ArvGcNode* node) {
  if (!node) return NodeKind::kNone;
  if (ARV_IS_GC_ENUMERATION(node)) return NodeKind::kChoice;
  if (ARV_IS_GC_COMMAND(node)) return NodeKind::kCommand;
  if (ARV_IS_GC_BOOLEAN(node)) return NodeKind::kBoolean;
  if (ARV_IS_GC_FLOAT(node)) return NodeKind::kReal;
  if (ARV_IS_GC_INTEGER(node)) return NodeKind::kInteger;
  if (ARV_IS_GC_STRING(node)) return NodeKind::kText;
  return NodeKind::kNone;
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
  return {
      .kind_of =
          [camera, node_of](const std::string& name) {
            if (!CallOr(
                    [&](GError** e) { return arv_camera_is_feature_implemented(camera, name.c_str(), e); },
                    false))
              return NodeKind::kNone;
            return KindOf(node_of(name));
          },
      .is_available =
          [camera](const std::string& name) {
            return CallOr(
                [&](GError** e) { return arv_camera_is_feature_available(camera, name.c_str(), e); }, false);
          },
      .choices_of =
          [camera](const std::string& name) {
            return CallForNames([&](guint* count, GError** e) {
              return arv_camera_dup_available_enumerations_as_strings(camera, name.c_str(), count, e);
            });
          },
      .unit_of = [node_of](const std::string& name) { return UnitOf(node_of(name)); },
      .least_of = [node_of](const std::string& name) { return LeastNow(node_of(name)); }};
}

}  // namespace ulf::acquisition
