// Makes the data files of a light field's page. A page that is opened from a folder may neither fetch() files
// nor read the pixels of an <img>, but it may run scripts: the data are scripts that pass the page a JSON
// object and bytes in base64.
//
//   ulfData({"kind":"scene",...},"AAAA...");
//
// Numbers are little-endian, as in all browsers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace ulf::render {

std::string Base64(std::string_view bytes);

// Concatenates several arrays or pictures for one data file.
class WebBytes {
 public:
  // Returns the byte at which the values begin, a multiple of four.
  std::size_t Add(std::span<const float> values);
  std::size_t Add(std::span<const std::uint16_t> values);
  std::size_t Add(std::span<const std::uint32_t> values);
  std::size_t Add(std::string_view bytes);
  const std::string& bytes() const { return bytes_; }

 private:
  std::size_t AddRaw(const void* data, std::size_t size);
  std::string bytes_;
};

// Arrays and their places in a file, as the page reads them: name to [type, first byte, count].
class WebArrays {
 public:
  template <typename Number>
  void Add(const char* name, const std::vector<Number>& values) {
    const char* type = std::is_same_v<Number, float>           ? "f32"
                       : std::is_same_v<Number, std::uint16_t> ? "u16"
                                                               : "u32";
    places_[name] = {type, bytes_.Add(std::span<const Number>(values)), values.size()};
  }
  // Adds the indices with 16 bits each, or with 32 if one of them needs more.
  void AddIndices(const char* name, const std::vector<std::uint32_t>& indices);
  const std::string& bytes() const { return bytes_.bytes(); }
  const nlohmann::ordered_json& places() const { return places_; }

 private:
  WebBytes bytes_;
  nlohmann::ordered_json places_ = nlohmann::ordered_json::object();
};

// Returns the script of a data file.
std::string WebFileText(const nlohmann::ordered_json& header, std::string_view bytes);
// Returns the size of a script with a header of `header_bytes` as text and of this number of bytes.
std::size_t WebFileSize(std::size_t header_bytes, std::size_t bytes);

}  // namespace ulf::render
