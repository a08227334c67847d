// Reads XML through pugixml, with checks: a value that is missing, no number or not finite becomes an Error
// that names the file, the line and the element, as "cameras.xml, line 12, <sensor>". Names of elements and
// attributes include their prefix.
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

// An element shares ownership of its document.
class XmlElement {
 public:
  std::string Name() const;
  // Returns the file, the line and the element for messages.
  std::string Where() const;

  // Returns the first child of this name; none if there is none.
  std::optional<XmlElement> Find(const char* name) const;
  // Returns the first element along a path of names, "calibration/resolution"; none if there is none.
  std::optional<XmlElement> FindPath(const std::string& path) const;
  // Returns the first child of this name. Throws Error if there is none.
  XmlElement Child(const char* name) const;
  std::vector<XmlElement> Children(const char* name) const;
  // Returns children of every name.
  std::vector<XmlElement> AllChildren() const;
  // Returns all descendants of this name, in the file's order.
  std::vector<XmlElement> Descendants(const char* name) const;

  std::optional<std::string> Attribute(const char* name) const;
  std::vector<std::string> AttributeNames() const;
  // Throws Error if the attribute is missing or no whole number from `least` to `most`.
  int IntegerAttribute(const char* name, int least, int most) const;
  // Returns the element's own text without white space around it.
  std::string Text() const;
  // These return one number, or exactly `count` separated by white space, and throw Error for any other text.
  double Number() const;
  std::vector<double> Numbers(std::size_t count) const;

 private:
  friend XmlElement ReadXmlText(std::string text, const std::string& where);
  XmlElement(std::shared_ptr<const XmlDocument> document, void* node)
      : document_(std::move(document)), node_(node) {}

  std::shared_ptr<const XmlDocument> document_;
  void* node_ = nullptr;
};

// Returns the outermost element. Throws Error for a file that cannot be read, is larger than 256 MB or is no
// XML, with the line of the fault.
XmlElement ReadXmlFile(const std::filesystem::path& file);
// Does the same for a text in memory; `where` stands for the file.
XmlElement ReadXmlText(std::string text, const std::string& where);

// Escapes text for an element or an attribute, of XML and of HTML.
std::string XmlEscaped(std::string_view text);

// Parses exactly `count` finite numbers separated by white space. Throws an Error that begins with `where`
// and names `what` for any other text.
std::vector<double> NumbersOf(const std::string& text, std::size_t count, const std::string& where,
                              const std::string& what);

}  // namespace ulf
