#include "render/web/web_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace ulf::render {

static_assert(std::endian::native == std::endian::little);

namespace {

constexpr std::string_view kBegin = "ulfData(", kBetween = ",\"", kEnd = "\");\n";

}  // namespace

std::string Base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kDigits[three >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::size_t WebBytes::AddRaw(const void* data, std::size_t size) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  const std::size_t at = bytes_.size();
  bytes_.append(static_cast<const char*>(data), size);
  return at;
}

std::size_t WebBytes::Add(std::span<const float> values) {
  return AddRaw(values.data(), values.size_bytes());
}
std::size_t WebBytes::Add(std::span<const std::uint16_t> values) {
  return AddRaw(values.data(), values.size_bytes());
}
std::size_t WebBytes::Add(std::span<const std::uint32_t> values) {
  return AddRaw(values.data(), values.size_bytes());
}
std::size_t WebBytes::Add(std::string_view bytes) { return AddRaw(bytes.data(), bytes.size()); }

void WebArrays::AddIndices(const char* name, const std::vector<std::uint32_t>& indices) {
  if (std::ranges::all_of(indices, [](std::uint32_t index) { return index <= 0xFFFF; }))
    Add(name, std::vector<std::uint16_t>(indices.begin(), indices.end()));
  else
    Add(name, indices);
}

std::string WebFileText(const nlohmann::ordered_json& header, std::string_view bytes) {
  return fmt::format("{}{}{}{}{}", kBegin, header.dump(-1, ' ', true), kBetween, Base64(bytes), kEnd);
}

std::size_t WebFileSize(std::size_t header_bytes, std::size_t bytes) {
  return kBegin.size() + header_bytes + kBetween.size() + (bytes + 2) / 3 * 4 + kEnd.size();
}

}  // namespace ulf::render
