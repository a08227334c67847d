// Reads Stanford PLY of any kind (text, little or big endian, any elements and properties), number by number.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ulf::ply {

enum class Number { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
enum class Format { kAscii, kLittleEndian, kBigEndian };

struct Property {
  std::string name;
  Number type = Number::kFloat;
  std::optional<Number> count_type;  // set for a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Format format = Format::kAscii;
  std::vector<Element> elements;
  std::vector<std::string> comments;
  std::size_t size = 0;  // length of the header in bytes
};

// Throws Error that begins with `name`.
Header ParseHeader(const std::string& bytes, const std::string& name);

// Reads the numbers after the header. `bytes` and `header` must outlive it. Throws Error that begins with
// `name` if the file is truncated.
class Body {
 public:
  Body(const std::string& bytes, const Header& header, std::string name);

  // Called at the start of an element, throws unless the file has at least the minimum size of its rows, so
  // that a header cannot make the caller allocate more than the file contains.
  void Require(const Element& element) const;
  double Next(Number type);
  // Returns the number of values that follow: the length of a list, or 1.
  double Count(const Property& property);
  void Skip(const Element& element);

 private:
  double NextText();
  [[noreturn]] void Truncated() const;

  const char* at_;
  const char* end_;
  Format format_;
  std::string name_;
};

}  // namespace ulf::ply

namespace ulf {

// Parses a number, also "nan" and "inf". Returns false if `text` is no number.
bool ParseNumber(std::string_view text, double& value);

}  // namespace ulf
