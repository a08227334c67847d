#include "core/light_field/formats/xml_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <string_view>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf {

// The parsed nodes point into `bytes`.
struct XmlDocument {
  std::string file;
  std::string bytes;
  std::vector<std::size_t> line_ends;
  pugi::xml_document parsed;

  std::size_t LineAt(std::ptrdiff_t offset) const {
    const auto end =
        std::ranges::lower_bound(line_ends, static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, offset)));
    return static_cast<std::size_t>(end - line_ends.begin()) + 1;
  }
};

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostXmlBytes = 256u << 20;
constexpr std::string_view kXmlSpace = " \t\r\n";

pugi::xml_node NodeOf(void* node) { return pugi::xml_node(static_cast<pugi::xml_node_struct*>(node)); }

std::string WithoutSpaceAround(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kXmlSpace);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(kXmlSpace) - first + 1));
}

std::string BeginningOfWord(const std::string& text) {
  constexpr std::size_t kMost = 40;
  return text.size() > kMost ? text.substr(0, kMost) + "..." : text;
}

std::string BytesOfXml(const fs::path& file) {
  std::error_code unknown;
  if (fs::is_directory(file, unknown)) throw Error("{}: is a folder; give an XML file", file.string());
  RequireRegularFile(file);
  if (const std::uintmax_t size = fs::file_size(file); size > kMostXmlBytes)
    throw Error("{}: has {} bytes; XML of up to {} is read: is it the right file?", file.string(), size,
                kMostXmlBytes);
  return ReadWholeFile(file);
}

}  // namespace

std::string XmlElement::Name() const { return NodeOf(node_).name(); }

std::string XmlElement::Where() const {
  const pugi::xml_node node = NodeOf(node_);
  return fmt::format("{}, line {}, <{}>", document_->file, document_->LineAt(node.offset_debug()),
                     node.name());
}

std::optional<XmlElement> XmlElement::Find(const char* name) const {
  const pugi::xml_node child = NodeOf(node_).child(name);
  if (!child) return std::nullopt;
  return XmlElement(document_, child.internal_object());
}

std::optional<XmlElement> XmlElement::FindPath(const std::string& path) const {
  const pugi::xml_node found = NodeOf(node_).first_element_by_path(path.c_str());
  if (!found) return std::nullopt;
  return XmlElement(document_, found.internal_object());
}

XmlElement XmlElement::Child(const char* name) const {
  const auto child = Find(name);
  if (!child) throw Error("{}: holds no <{}>; export the file again", Where(), name);
  return *child;
}

std::vector<XmlElement> XmlElement::Children(const char* name) const {
  std::vector<XmlElement> found;
  for (const pugi::xml_node child : NodeOf(node_).children(name))
    found.push_back(XmlElement(document_, child.internal_object()));
  return found;
}

std::vector<XmlElement> XmlElement::AllChildren() const {
  std::vector<XmlElement> found;
  for (const pugi::xml_node child : NodeOf(node_).children())
    if (child.type() == pugi::node_element) found.push_back(XmlElement(document_, child.internal_object()));
  return found;
}

std::vector<XmlElement> XmlElement::Descendants(const char* name) const {
  std::vector<XmlElement> found;
  for (const pugi::xpath_node& each : NodeOf(node_).select_nodes(fmt::format("descendant::{}", name).c_str()))
    found.push_back(XmlElement(document_, each.node().internal_object()));
  return found;
}

std::optional<std::string> XmlElement::Attribute(const char* name) const {
  const pugi::xml_attribute attribute = NodeOf(node_).attribute(name);
  if (!attribute) return std::nullopt;
  return WithoutSpaceAround(attribute.value());
}

std::vector<std::string> XmlElement::AttributeNames() const {
  std::vector<std::string> names;
  for (const pugi::xml_attribute attribute : NodeOf(node_).attributes()) names.emplace_back(attribute.name());
  return names;
}

int XmlElement::IntegerAttribute(const char* name, int least, int most) const {
  const auto text = Attribute(name);
  if (!text) throw Error("{}: the attribute '{}' is missing; export the file again", Where(), name);
  const double value = NumbersOf(*text, 1, Where(), fmt::format("the attribute '{}'", name)).front();
  if (value != std::floor(value) || value < least || value > most)
    throw Error("{}: the attribute '{}' is '{}', not a whole number from {} to {}", Where(), name,
                BeginningOfWord(*text), least, most);
  return static_cast<int>(value);
}

std::string XmlElement::Text() const { return WithoutSpaceAround(NodeOf(node_).child_value()); }

double XmlElement::Number() const { return Numbers(1).front(); }

std::vector<double> XmlElement::Numbers(std::size_t count) const {
  return NumbersOf(Text(), count, Where(), "its text");
}

XmlElement ReadXmlFile(const fs::path& file) { return ReadXmlText(BytesOfXml(file), file.string()); }

XmlElement ReadXmlText(std::string text, const std::string& where) {
  const auto document = std::make_shared<XmlDocument>();
  document->file = where;
  document->bytes = std::move(text);
  for (std::size_t i = 0; i < document->bytes.size(); ++i)
    if (document->bytes[i] == '\n') document->line_ends.push_back(i);
  const pugi::xml_parse_result result =
      document->parsed.load_buffer_inplace(document->bytes.data(), document->bytes.size());
  if (!result)
    throw Error("{}, line {}: is no valid XML ({}); the file may be cut short: copy or export it again",
                where, document->LineAt(result.offset), result.description());
  return {document, document->parsed.document_element().internal_object()};
}

std::string XmlEscaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

std::vector<double> NumbersOf(const std::string& text, std::size_t count, const std::string& where,
                              const std::string& what) {
  std::vector<double> numbers;
  for (std::size_t begin = text.find_first_not_of(kXmlSpace); begin != std::string::npos;) {
    const std::size_t end = std::min(text.find_first_of(kXmlSpace, begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    double value = 0;
    if (!ParseNumber(word, value))
      throw Error("{}: {} holds '{}', which is no number", where, what, BeginningOfWord(word));
    if (!std::isfinite(value))
      throw Error("{}: {} holds '{}', which is not finite", where, what, BeginningOfWord(word));
    if (numbers.size() == count)
      throw Error("{}: {} must hold {}, there are more", where, what,
                  count == 1 ? "one number" : fmt::format("{} numbers", count));
    numbers.push_back(value);
    begin = text.find_first_not_of(kXmlSpace, end);
  }
  if (numbers.size() != count)
    throw Error("{}: {} must hold {}, not {}", where, what,
                count == 1 ? "one number" : fmt::format("{} numbers", count), numbers.size());
  return numbers;
}

}  // namespace ulf
