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

// Throws an Error that begins with `name` if the bytes do not begin with a PLY header.
Header ParseHeader(const std::string& bytes, const std::string& name);

// Reads the numbers after the header, one after the other. `bytes` must outlive it. Throws an Error that
// begins with `name` if the file is truncated or a number is none.
class Body {
 public:
  Body(const std::string& bytes, const Header& header, std::string name);

  // Throws Error unless the rest of the file has at least the minimum size of the element's rows. Call it
  // before the element is read, so that a header cannot make you allocate more than the file contains.
  void Require(const Element& element) const;
  // Reads one number of this type.
  double Next(Number type);
  // Returns how many values of the property follow: the length of a list, which this reads, or 1.
  double Count(const Property& property);
  // Skips all rows of the element.
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

// Parses a number, also "nan" and "inf"; NaN if it is out of range. Returns false if `text` is no number.
bool ParseNumber(std::string_view text, double& value);

}  // namespace ulf
