#include "acquisition/aravis/genicam_file.h"

#include <memory>

#include "acquisition/aravis/aravis_description.h"
#include "core/base/atomic_file.h"

namespace ulf::acquisition {
namespace {

std::size_t CountFeatures(ArvDomNode* node) {
  std::size_t count = 0;
  for (ArvDomNode* child = arv_dom_node_get_first_child(node); child;
       child = arv_dom_node_get_next_sibling(child)) {
    if (ARV_IS_GC_NODE(child) && KindOf(ARV_GC_NODE(child))) ++count;
    count += CountFeatures(child);
  }
  return count;
}

std::string Attribute(ArvDomElement* element, const char* name) {
  return Text(arv_dom_element_get_attribute(element, name));
}

}  // namespace

GenicamFile ReadGenicamFile(const std::filesystem::path& file) {
  const std::string text = ReadWholeFile(file);
  struct Release {
    void operator()(ArvGc* description) const { g_object_unref(description); }
  };
  const std::unique_ptr<ArvGc, Release> description(arv_gc_new(nullptr, text.data(), text.size()));
  if (!description)
    throw Error("{}: is no GenICam description that Aravis reads; copy it from the camera again",
                file.string());
  GenicamFile read;
  ArvDomElement* root = arv_dom_document_get_document_element(ARV_DOM_DOCUMENT(description.get()));
  if (root) {
    read.vendor = Attribute(root, "VendorName");
    read.model = Attribute(root, "ModelName");
    read.features = CountFeatures(ARV_DOM_NODE(root));
  }
  const NamedFeatures named = FeaturesOf(description.get());
  read.names = FindFeatureNames(named);
  if (!read.names.pixel_format.empty()) read.pixel_formats = named.choices_of(read.names.pixel_format);
  return read;
}

}  // namespace ulf::acquisition
