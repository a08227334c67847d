// A thin door to pugixml: XML read with checks. The only files that know the library are these two.
//
// What is missing, no number or not finite becomes an Error that names the file, the line and the element, as
// "cameras.xml, line 12, <sensor>". Names of elements and attributes have their prefix, as in the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ulf {

struct XmlDocument;

// Keeps the document that it belongs to.
class XmlElement {
 public:
  std::string Name() const;
  // For messages: the file, the line and the element.
  std::string Where() const;

  // The first child of this name; none: there is none.
  std::optional<XmlElement> Find(const char* name) const;
  // The same after each name of a path, "calibration/resolution".
  std::optional<XmlElement> FindPath(const std::string& path) const;
  // The first child of this name. Throws Error where there is none.
  XmlElement Child(const char* name) const;
  std::vector<XmlElement> Children(const char* name) const;
  // Those of every name.
  std::vector<XmlElement> AllChildren() const;
  // All of this name inside this element, at any depth, in the file's order.
  std::vector<XmlElement> Below(const char* name) const;

  std::optional<std::string> Attribute(const char* name) const;
  std::vector<std::string> AttributeNames() const;
  // Throws Error where it is missing or no whole number from `least` to `most`.
  int IntegerAttribute(const char* name, int least, int most) const;
  // The element's own text without white space around it.
  std::string Text() const;
  double Number() const;
  // Exactly `count` numbers between white space.
  std::vector<double> Numbers(std::size_t count) const;

 private:
  friend XmlElement ReadXmlText(std::string text, const std::string& where);
  XmlElement(std::shared_ptr<const XmlDocument> document, void* node)
      : document_(std::move(document)), node_(node) {}

  std::shared_ptr<const XmlDocument> document_;
  void* node_ = nullptr;
};

// The outermost element. Throws Error for a file that cannot be read, is larger than 256 MB or is no XML,
// with the line at which it ceases to be one.
XmlElement ReadXmlFile(const std::filesystem::path& file);
// The same of a text that was read already; `where` stands for the file.
XmlElement ReadXmlText(std::string text, const std::string& where);

// Text as it may stand in an element or an attribute, of XML and of HTML.
std::string XmlEscaped(std::string_view text);

// Exactly `count` finite numbers between white space. Throws Error that begins with `where` and names `what`.
std::vector<double> NumbersOf(const std::string& text, std::size_t count, const std::string& where,
                              const std::string& what);

}  // namespace ulf
