#include "acquisition/aravis/aravis_description.h"

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
  return {
      .kind_of = [description](
                     const std::string& name) { return KindOf(arv_gc_get_node(description, name.c_str())); },
      .choices_of =
          [description](const std::string& name) {
            return EntriesOf(arv_gc_get_node(description, name.c_str()));
          }};
}

NamedFeatures FeaturesOf(ArvCamera* camera) {
  return {
      .kind_of =
          [camera](const std::string& name) {
            if (!Maybe([&](GError** e) { return arv_camera_is_feature_available(camera, name.c_str(), e); },
                       false))
              return NodeKind::kNone;
            return KindOf(arv_device_get_feature(arv_camera_get_device(camera), name.c_str()));
          },
      .choices_of =
          [camera](const std::string& name) {
            return MaybeNames([&](guint* count, GError** e) {
              return arv_camera_dup_available_enumerations_as_strings(camera, name.c_str(), count, e);
            });
          }};
}

}  // namespace ulf::acquisition
