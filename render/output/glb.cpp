#include "render/output/glb.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/json_text.h"

namespace ulf::render {
namespace {

static_assert(std::endian::native == std::endian::little,
              "glTF's numbers are little-endian, and written as they are");

std::size_t Padded(std::size_t size) { return (size + 3) / 4 * 4; }

void AppendChunk(std::string& file, const std::string& type, const std::string& bytes) {
  const auto size = static_cast<std::uint32_t>(bytes.size());
  file.append(reinterpret_cast<const char*>(&size), sizeof(size));
  file += type;
  file += bytes;
}

}  // namespace

std::size_t GlbBuffer::AddView(const void* data, std::size_t size, int target) {
  bytes_.resize(Padded(bytes_.size()));
  nlohmann::ordered_json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
  if (target != 0) view["target"] = target;
  bytes_.append(static_cast<const char*>(data), size);
  document_["bufferViews"].push_back(std::move(view));
  return document_["bufferViews"].size() - 1;
}

std::string GlbBuffer::Take() {
  bytes_.resize(Padded(bytes_.size()));
  return std::move(bytes_);
}

std::string GlbOf(nlohmann::ordered_json& document, GlbBuffer& buffer, const std::string& name,
                  const std::string& remedy) {
  const std::string bytes = buffer.Take();
  document["buffers"] = nlohmann::ordered_json::array({{{"byteLength", bytes.size()}}});
  std::string text = JsonText(document);
  text.resize(Padded(text.size()), ' ');

  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  const std::size_t size = kHeader + 2 * kChunkHeader + text.size() + bytes.size();
  if (size > std::numeric_limits<std::uint32_t>::max())
    throw Error("{}: {:.1f} GB; a .glb has at most 4: give {}", name, static_cast<double>(size) / 1e9,
                remedy);
  std::string file("glTF");
  for (const std::uint32_t number : {std::uint32_t{2}, static_cast<std::uint32_t>(size)})
    file.append(reinterpret_cast<const char*>(&number), sizeof(number));
  AppendChunk(file, "JSON", text);
  AppendChunk(file, std::string("BIN\0", 4), bytes);
  return file;
}

}  // namespace ulf::render
