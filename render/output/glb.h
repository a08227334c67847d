// The frame of a .glb file (glTF 2.0, registry.khronos.org/glTF/specs/2.0): a JSON document and one buffer.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ulf::render {

// These are constants of the specification.
inline constexpr int kGltfFloat = 5126, kGltfUnsignedInt = 5125, kGltfUnsignedShort = 5123;
inline constexpr int kGltfVertices = 34962, kGltfIndices = 34963;  // ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER

// The file's one buffer, in views that begin at multiples of four bytes and are listed in the document.
class GlbBuffer {
 public:
  explicit GlbBuffer(nlohmann::ordered_json& document) : document_(document) {}
  // Returns the view's index. A `target` of 0 is left out.
  std::size_t AddView(const void* data, std::size_t size, int target);
  // Returns the accessor's index; `type` is VEC3 and the like, `count` the number of elements.
  template <typename Value>
  std::size_t AddAccessor(const std::vector<Value>& values, int component, const char* type,
                          std::size_t count, int target) {
    const std::size_t view = AddView(values.data(), values.size() * sizeof(Value), target);
    document_["accessors"].push_back(
        {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return document_["accessors"].size() - 1;
  }
  std::string Take();  // the bytes, padded to a multiple of four

 private:
  nlohmann::ordered_json& document_;
  std::string bytes_;
};

// Adds the buffer to the document and returns the file. Throws Error for `name` if it would be larger than
// the format's 4 GB; `remedy` says what to give: "fewer triangles".
std::string GlbOf(nlohmann::ordered_json& document, GlbBuffer& buffer, const std::string& name,
                  const std::string& remedy);

}  // namespace ulf::render
