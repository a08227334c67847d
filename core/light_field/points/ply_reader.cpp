#include "core/light_field/points/ply_reader.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/base/error.h"

namespace ulf {
namespace ply {
namespace {

template <typename T>
double As(const std::array<char, 8>& bytes) {
  T value;
  std::memcpy(&value, bytes.data(), sizeof(T));
  return static_cast<double>(value);
}

struct NumberType {
  std::string_view name, other_name;
  std::size_t size = 0;
  double (*value)(const std::array<char, 8>& bytes) = nullptr;  // in this machine's byte order
};

constexpr std::array<NumberType, 8> kNumberTypes{{{"char", "int8", 1, As<std::int8_t>},
                                                  {"uchar", "uint8", 1, As<std::uint8_t>},
                                                  {"short", "int16", 2, As<std::int16_t>},
                                                  {"ushort", "uint16", 2, As<std::uint16_t>},
                                                  {"int", "int32", 4, As<std::int32_t>},
                                                  {"uint", "uint32", 4, As<std::uint32_t>},
                                                  {"float", "float32", 4, As<float>},
                                                  {"double", "float64", 8, As<double>}}};

std::optional<Number> NumberNamed(std::string_view name) {
  for (std::size_t i = 0; i < kNumberTypes.size(); ++i)
    if (name == kNumberTypes[i].name || name == kNumberTypes[i].other_name) return static_cast<Number>(i);
  return std::nullopt;
}

const NumberType& TypeOf(Number number) { return kNumberTypes[static_cast<std::size_t>(number)]; }

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kSpace = " \t\r";
  for (std::size_t at = line.find_first_not_of(kSpace); at < line.size();
       at = line.find_first_not_of(kSpace, at)) {
    const std::size_t end = std::min(line.find_first_of(kSpace, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

}  // namespace

Header ParseHeader(const std::string& bytes, const std::string& name) {
  Header header;
  bool format_known = false;
  const std::string_view text = bytes;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos)
      throw Error("{}: the PLY header has no end; the file is truncated", name);
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    const auto words = Words(line);
    if (words.size() > 1 && words[0] == "comment")
      header.comments.emplace_back(words[1].begin(), words.back().end());
    if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") {
      header.size = at;
      break;
    }
    double count = 0;
    if (words[0] == "format" && words.size() >= 2) {
      format_known = true;
      if (words[1] == "binary_little_endian")
        header.format = Format::kLittleEndian;
      else if (words[1] == "binary_big_endian")
        header.format = Format::kBigEndian;
      else
        format_known = words[1] == "ascii";
    } else if (words[0] == "element" && words.size() == 3 && ParseNumber(words[2], count) && count >= 0 &&
               count < 4e9) {
      header.elements.push_back({std::string(words[1]), static_cast<std::size_t>(count), {}});
    } else if (words[0] == "property" && !header.elements.empty() && words.size() >= 3) {
      const bool list = words[1] == "list" && words.size() == 5;
      const auto type = NumberNamed(words[list ? 3 : 1]);
      const auto count_type = list ? NumberNamed(words[2]) : std::nullopt;
      if (!type || (list && !count_type))
        throw Error("{}: the PLY header's line '{}' is unknown", name, line);
      header.elements.back().properties.push_back({std::string(words.back()), *type, count_type});
    } else {
      throw Error("{}: the PLY header's line '{}' is unknown", name, line);
    }
  }
  if (!format_known) throw Error("{}: the PLY header names no known format (ascii or binary)", name);
  return header;
}

Body::Body(const std::string& bytes, const Header& header, std::string name)
    : at_(bytes.data() + header.size),
      end_(bytes.data() + bytes.size()),
      format_(header.format),
      name_(std::move(name)) {}

void Body::Require(const Element& element) const {
  std::size_t least_bytes = 0;  // for text a digit and a space each
  for (const Property& property : element.properties)
    least_bytes += format_ == Format::kAscii ? 2 : TypeOf(property.count_type.value_or(property.type)).size;
  // The last number of a text file may have no space behind it.
  if (format_ == Format::kAscii && least_bytes > 0) --least_bytes;
  if (element.count * least_bytes > static_cast<std::size_t>(end_ - at_)) Truncated();
}

double Body::Next(Number type) {
  if (format_ == Format::kAscii) return NextText();
  const std::size_t size = TypeOf(type).size;
  if (static_cast<std::size_t>(end_ - at_) < size) Truncated();
  std::array<char, 8> bytes{};
  const bool turn = (format_ == Format::kBigEndian) == (std::endian::native == std::endian::little);
  for (std::size_t i = 0; i < size; ++i) bytes[turn ? size - 1 - i : i] = at_[i];
  at_ += size;
  return TypeOf(type).value(bytes);
}

double Body::Count(const Property& property) { return property.count_type ? Next(*property.count_type) : 1; }

void Body::Skip(const Element& element) {
  if (element.properties.empty()) return;
  for (std::size_t i = 0; i < element.count; ++i)
    for (const Property& property : element.properties) {
      double left = Count(property);
      while (left-- > 0) Next(property.type);
    }
}

double Body::NextText() {
  const auto space = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; };
  while (at_ < end_ && space(*at_)) ++at_;
  const char* begin = at_;
  while (at_ < end_ && !space(*at_)) ++at_;
  if (begin == at_) Truncated();
  double value = 0;
  const std::string_view word(begin, static_cast<std::size_t>(at_ - begin));
  if (!ParseNumber(word, value)) throw Error("{}: '{}' is not a number; export it again", name_, word);
  return value;
}

void Body::Truncated() const {
  throw Error("{}: the file ends before what its header announces; it is truncated: copy or export it again",
              name_);
}

}  // namespace ply

bool ParseNumber(std::string_view text, double& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return false;
  if (error == std::errc::result_out_of_range) value = std::nan("");
  return error == std::errc() || error == std::errc::result_out_of_range;
}

}  // namespace ulf
