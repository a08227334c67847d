#include "acquisition/calibration/lens_files/lens_tree.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>
#include <unordered_map>

#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/light_field/formats/xml_file.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf::acquisition {
namespace {

constexpr int kMostLensLevels = 100;
constexpr std::size_t kMostLensNodes = 1'000'000;

// Counts what all conversions have made: a short text may refer to itself and become an endless tree.
struct LensTreeSize {
  const std::string& where;
  std::size_t nodes = 0;

  void Add(int level) {
    if (level > kMostLensLevels) throw Error("{}: values are nested too deeply for a calibration", where);
    if (++nodes > kMostLensNodes) throw Error("{}: holds too many values for a calibration", where);
  }
};

void AddLensKey(LensNode& map, std::unordered_map<std::string, std::size_t>& at, const std::string& key,
                LensNode value, const std::string& where) {
  const auto [found, is_new] = at.try_emplace(key, map.keys.size());
  if (!is_new) {
    if (map.items[found->second] == value) return;
    throw Error("{}: the key '{}' is there twice with different values; delete the wrong one", where, key);
  }
  map.Add(key, std::move(value));
}

// ---- YAML ----

// Parsers of YAML go into brackets, indented keys and items by recursion.
bool IsNestedDeeply(const std::string& text) {
  int levels = 0, levels_of_line = 0;
  bool is_indentation = true;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at], next = at + 1 < text.size() ? text[at + 1] : ' ';
    const bool is_item = c == '-' && std::isspace(static_cast<unsigned char>(next)) != 0;
    if (c == '[' || c == '{') ++levels;
    if (c == ']' || c == '}') levels = std::max(0, levels - 1);
    // Below its indentation stands what it belongs to, one column a level at least.
    is_indentation = c == '\n' || (is_indentation && c == ' ');
    if (c == '\n') levels_of_line = 0;
    const bool is_key = c == ':' && levels == 0 && std::isspace(static_cast<unsigned char>(next)) != 0;
    if (is_key || is_item || (is_indentation && c == ' ')) ++levels_of_line;
    if (std::max(levels, levels_of_line) > kMostLensLevels) return true;
  }
  return false;
}

// One of YAML's documents, and the lines before it.
struct LensDocument {
  std::string text;
  int lines_before = 0;
};

// OpenCV's YAML as YAML: its head is no directive that other parsers know, and its own parser wants no blank
// behind a key, which files written by hand make use of. Documents are parted here, and not by the library,
// which for some faults finds documents without end.
std::vector<LensDocument> PlainYaml(const std::string& text) {
  std::istringstream lines(text);
  std::vector<LensDocument> documents(1);
  bool is_opencv = false;
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    if (line.starts_with("%YAML")) {
      is_opencv = is_opencv || line.starts_with("%YAML:");
      line.clear();
    }
    if (line.starts_with("---") || line.starts_with("...")) {
      documents.push_back({"", count});
      line = line.substr(3);
    }
    const std::size_t key = line.find_first_not_of(" \t");
    const std::size_t colon = key == std::string::npos ? key : line.find(':', key);
    const bool is_word = colon != std::string::npos && colon + 1 < line.size() &&
                         std::all_of(line.begin() + static_cast<std::ptrdiff_t>(key),
                                     line.begin() + static_cast<std::ptrdiff_t>(colon), [](unsigned char c) {
                                       return std::isalnum(c) != 0 || c == '_' || c == '.' || c == ' ';
                                     });
    if (is_word && (line[colon + 1] == '[' || (is_opencv && line[colon + 1] != ' ')))
      line.insert(colon + 1, " ");
    documents.back().text += line + '\n';
  }
  return documents;
}

LensNode FromYaml(const YAML::Node& node, LensTreeSize& size, int level) {
  size.Add(level);
  LensNode made;
  if (node.IsScalar()) {
    made.kind = LensNode::Kind::kText;
    made.text = node.Scalar();
  } else if (node.IsSequence()) {
    made.kind = LensNode::Kind::kList;
    for (const auto& item : node) made.items.push_back(FromYaml(item, size, level + 1));
  } else if (node.IsMap()) {
    made.kind = LensNode::Kind::kMap;
    std::unordered_map<std::string, std::size_t> at;
    for (const auto& field : node)
      AddLensKey(made, at, field.first.IsScalar() ? field.first.Scalar() : "",
                 FromYaml(field.second, size, level + 1), size.where);
  }
  return made;
}

std::vector<LensNode> FromYamlText(const std::string& text, const std::string& where) {
  if (IsNestedDeeply(text)) throw Error("{}: values are nested too deeply for a calibration", where);
  LensTreeSize size{where};
  std::vector<LensNode> documents;
  for (const LensDocument& document : PlainYaml(text)) {
    try {
      const YAML::Node node = YAML::Load(document.text);
      if (node.IsMap() || node.IsSequence()) documents.push_back(FromYaml(node, size, 0));
    } catch (const YAML::Exception& error) {
      throw Error("{}, line {}: not valid YAML: {}; correct or write the file again", where,
                  document.lines_before + std::max(0, error.mark.line) + 1, error.msg);
    }
  }
  return documents;
}

// ---- JSON, XML ----

// The library keeps the last of two values, silently.
void RefuseJsonKeysTwice(const std::string& text, const std::string& where) {
  std::vector<std::set<std::string>> open;
  const auto look = [&](int, nlohmann::json::parse_event_t event, const nlohmann::json& value) {
    if (event == nlohmann::json::parse_event_t::object_start) open.emplace_back();
    if (event == nlohmann::json::parse_event_t::object_end) open.pop_back();
    if (event == nlohmann::json::parse_event_t::key && !open.back().insert(value.get<std::string>()).second)
      throw Error("{}: the key '{}' is there twice; delete the wrong one", where, value.get<std::string>());
    return true;
  };
  [[maybe_unused]] const auto looked_at = nlohmann::json::parse(text, look);
}

LensNode FromJsonValue(const nlohmann::json& json, LensTreeSize& size, int level) {
  size.Add(level);
  LensNode made;
  if (json.is_object()) {
    made.kind = LensNode::Kind::kMap;
    for (const auto& [key, value] : json.items()) made.Add(key, FromJsonValue(value, size, level + 1));
  } else if (json.is_array()) {
    made.kind = LensNode::Kind::kList;
    for (const auto& item : json) made.items.push_back(FromJsonValue(item, size, level + 1));
  } else if (!json.is_null()) {
    made.kind = LensNode::Kind::kText;
    made.text = json.is_string() ? json.get<std::string>() : JsonText(json);
  }
  return made;
}

// Values that stand in attributes, as in <camera fx="600" fy="600"/>, are of the element's map.
void AddXmlAttributes(const XmlElement& element, LensNode& map) {
  for (const std::string& name : element.AttributeNames()) {
    map.kind = LensNode::Kind::kMap;
    map.Add(name, {.kind = LensNode::Kind::kText, .text = *element.Attribute(name.c_str())});
  }
}

LensNode FromXml(const XmlElement& element, bool is_storage, LensTreeSize& size, int level) {
  size.Add(level);
  const std::vector<XmlElement> children = element.AllChildren();
  LensNode made;
  if (children.empty()) {
    made.kind = LensNode::Kind::kText;
    made.text = element.Text();
    if (made.text.empty() && !is_storage) AddXmlAttributes(element, made);
    if (made.text.size() >= 2 && made.text.front() == '"' && made.text.back() == '"')
      made.text = made.text.substr(1, made.text.size() - 2);
    return made;
  }
  const bool is_list =
      std::ranges::all_of(children, [](const XmlElement& child) { return child.Name() == "_"; });
  made.kind = is_list ? LensNode::Kind::kList : LensNode::Kind::kMap;
  std::unordered_map<std::string, std::size_t> at;
  for (const XmlElement& child : children) {
    LensNode value = FromXml(child, is_storage, size, level + 1);
    if (!is_list && is_storage) {
      AddLensKey(made, at, child.Name(), std::move(value), child.Where());
      continue;
    }
    if (!is_list) made.keys.push_back(child.Name());
    made.items.push_back(std::move(value));
  }
  if (!is_list && !is_storage) AddXmlAttributes(element, made);
  return made;
}

LensNode FromXmlText(const std::string& text, const std::string& where) {
  const XmlElement top = ReadXmlText(text, where);
  LensTreeSize size{where};
  const bool is_storage = top.Name() == "opencv_storage";
  LensNode inner = FromXml(top, is_storage, size, 0);
  if (is_storage) return inner;
  LensNode outer{.kind = LensNode::Kind::kMap};
  outer.Add(top.Name(), std::move(inner));
  return outer;
}

// ---- Sections ----

std::string WithoutBlanksAround(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
}

bool IsSectionHead(const std::string& line) {
  return line.size() > 2 && line.front() == '[' && line.back() == ']' &&
         std::isalpha(static_cast<unsigned char>(line[1])) != 0 && line.find(',') == std::string::npos;
}

// Returns the key of a line "key = value", one word as in ini and TOML; empty for other lines.
std::string AssignedKey(const std::string& line) {
  const std::size_t equals = line.find('=');
  if (equals == std::string::npos || line.substr(equals).starts_with("==")) return "";
  const std::string key = WithoutBlanksAround(line.substr(0, equals));
  const bool is_word = std::ranges::all_of(
      key, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '-'; });
  return is_word ? key : "";
}

int OpenBrackets(const std::string& text) {
  return static_cast<int>(std::ranges::count(text, '[') - std::ranges::count(text, ']'));
}

// Returns the value of a line of ini or TOML: a list in brackets, with commas, or, as MATLAB writes it, with
// blanks and semicolons; a text else.
LensNode AssignedValue(std::string value, LensTreeSize& size) {
  if (value.starts_with('[') && value.find(',') == std::string::npos) {
    std::ranges::replace_if(
        value, [](char c) { return c == '[' || c == ']' || c == ';'; }, ' ');
  } else if (value.starts_with('[')) {
    if (IsNestedDeeply(value)) size.Add(kMostLensLevels + 1);
    try {
      return FromYaml(YAML::Load(value), size, 1);
    } catch (const YAML::Exception& error) {
      throw Error("{}: the list '{}' cannot be read: {}; correct or write the file again", size.where,
                  value.substr(0, 40), error.msg);
    }
  }
  value = WithoutBlanksAround(value.substr(0, value.find(';')));
  if (value.size() >= 2 && (value.front() == '"' || value.front() == '\'') && value.back() == value.front())
    value = value.substr(1, value.size() - 2);
  return {.kind = LensNode::Kind::kText, .text = value};
}

// In ROS's ost.ini a name stands on a line of its own, its numbers on those below; ini and TOML have both in
// one line, and lists over several. The size, a section before the cameras, becomes part of each of them.
LensNode FromSections(const std::string& text, const std::string& where) {
  LensNode top{.kind = LensNode::Kind::kMap};
  LensNode image{.kind = LensNode::Kind::kMap};
  LensNode* section = nullptr;
  LensTreeSize size{where};
  std::istringstream lines(text);
  for (std::string raw; std::getline(lines, raw);) {
    std::string line = WithoutBlanksAround(raw.substr(0, raw.find('#')));
    if (line.empty() || line[0] == ';') continue;
    if (IsSectionHead(line)) {
      const std::string name = line.substr(1, line.size() - 2);
      if (name == "image") {
        image = {.kind = LensNode::Kind::kMap};
        section = &image;
        continue;
      }
      if (top.Has(name))
        throw Error("{}: the section [{}] is there twice; delete the wrong one", where, name);
      top.Add(name, image);
      section = &top.items.back();
      continue;
    }
    if (const std::string key = AssignedKey(line); !key.empty()) {
      while (OpenBrackets(line) > 0 && std::getline(lines, raw)) line += " " + raw.substr(0, raw.find('#'));
      if (OpenBrackets(line) > 0)
        throw Error("{}: the list behind '{}' has no end: the file may be cut; write it again", where, key);
      size.Add(1);
      LensNode& map = section ? *section : top;
      if (map.Has(key)) throw Error("{}: the key '{}' is there twice; delete the wrong one", where, key);
      map.Add(key, AssignedValue(WithoutBlanksAround(line.substr(line.find('=') + 1)), size));
      continue;
    }
    if (!section) continue;
    const LensNode numbers{.kind = LensNode::Kind::kText, .text = line};
    if (!LensNumbersIn(numbers)) {
      section->Add(line, {.kind = LensNode::Kind::kText});
    } else if (!section->items.empty()) {
      std::string& known = section->items.back().text;
      known += (known.empty() ? "" : " ") + line;
    }
  }
  return top;
}

// Returns the first line that is neither empty nor a comment, which ; begins in ini.
std::string FirstLine(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line = WithoutBlanksAround(line);
    if (!line.empty() && line[0] != '#' && line[0] != ';') return line;
  }
  return "";
}

bool HasYamlKey(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line = WithoutBlanksAround(line.substr(0, line.find('#')));
    const std::size_t colon = line.find(':');
    if (colon != std::string::npos && colon > 0) return true;
  }
  return false;
}

}  // namespace

const LensNode* LensNode::Find(std::string_view key) const {
  if (!IsMap()) return nullptr;
  const auto found = std::ranges::find(keys, key);
  return found == keys.end() ? nullptr : &items[static_cast<std::size_t>(found - keys.begin())];
}

const LensNode* LensNode::FindPath(std::initializer_list<std::string_view> path) const {
  const LensNode* at = this;
  for (const std::string_view key : path)
    if (at) at = at->Find(key);
  return at;
}

std::optional<std::vector<LensNode>> LensTreesOf(const std::string& text, const std::string& where) {
  const std::string first = FirstLine(text);
  if (first.empty()) return std::nullopt;
  if (first[0] == '<') return std::vector{FromXmlText(text, where)};
  if (first[0] == '{') {
    LensTreeSize size{where};
    const nlohmann::json json = ParseJson(text, where, "write the file again");
    RefuseJsonKeysTwice(text, where);
    return std::vector{FromJsonValue(json, size, 0)};
  }
  if (IsSectionHead(first) || !AssignedKey(first).empty()) return std::vector{FromSections(text, where)};
  if (first.starts_with("%YAML") || first == "---" || HasYamlKey(text)) return FromYamlText(text, where);
  return std::nullopt;
}

std::string LensWord(std::string_view text) {
  std::string word;
  for (const char c : text)
    if (std::string_view(" \t_.:-/").find(c) == std::string_view::npos)
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word;
}

std::optional<double> LensNumber(const LensNode& node) {
  if (!node.IsText()) return std::nullopt;
  std::string text = WithoutBlanksAround(node.text);
  // YAML writes .nan and -.inf.
  const std::size_t dot = text.find('.');
  if (dot != std::string::npos && dot + 1 < text.size() &&
      std::isalpha(static_cast<unsigned char>(text[dot + 1])) != 0 && dot <= 1)
    text.erase(dot, 1);
  double value = 0;
  if (text.empty() || !ParseNumber(text, value)) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> LensNumbersIn(const LensNode& node) {
  std::vector<double> numbers;
  if (node.IsText()) {
    std::istringstream words(node.text);
    for (std::string word; words >> word;) {
      const auto number = LensNumber({.kind = LensNode::Kind::kText, .text = word});
      if (!number) return std::nullopt;
      numbers.push_back(*number);
    }
    return numbers;
  }
  if (!node.IsList()) return std::nullopt;
  for (const LensNode& item : node.items) {
    const auto more = LensNumbersIn(item);
    if (!more || (item.IsText() && more->size() != 1)) return std::nullopt;
    numbers.insert(numbers.end(), more->begin(), more->end());
  }
  return numbers;
}

bool LooksLikeLensMatrix(const LensNode& node) {
  if (node.IsMap()) return node.Has("data");
  const auto numbers = LensNumbersIn(node);
  return numbers && numbers->size() >= 9;
}

LensMatrix LensMatrixOf(const LensNode& node, std::string_view key, const std::string& where) {
  const LensNode* data = node.IsMap() ? node.Find("data") : &node;
  if (!data)
    throw Error("{}: '{}' is no matrix with rows, cols and data; if the file was cut, write it again", where,
                key);
  if (data->IsText() && data->text.find("$base64$") != std::string::npos)
    throw Error("{}: '{}' is written in base64; write it as text (without OpenCV's WRITE_BASE64)", where,
                key);
  LensMatrix matrix;
  // A list without numbers, and XML's element without text, are matrices without numbers.
  const auto numbers = data->kind == LensNode::Kind::kNothing ? std::vector<double>() : LensNumbersIn(*data);
  if (!numbers) throw Error("{}: '{}' must hold numbers alone", where, key);
  matrix.numbers = *numbers;
  const auto count = static_cast<int>(std::min<std::size_t>(matrix.numbers.size(), 1'000'000));
  if (!node.IsMap()) {
    const bool has_rows = node.IsList() && !node.items.empty() && node.items.front().IsList();
    matrix.rows = has_rows ? static_cast<int>(node.items.size()) : 1;
    matrix.cols = count / matrix.rows;
    const auto width = static_cast<std::size_t>(matrix.cols);
    if (has_rows && std::ranges::any_of(node.items, [width](const LensNode& row) {
          const auto found = LensNumbersIn(row);
          return !found || found->size() != width;
        }))
      throw Error("{}: the rows of '{}' have not all the same number of values", where, key);
    return matrix;
  }
  if (!node.Has("rows") && !node.Has("cols")) {
    matrix.rows = 1;
    matrix.cols = count;
    return matrix;
  }
  for (const auto& [name, side] : {std::pair{"rows", &matrix.rows}, std::pair{"cols", &matrix.cols}}) {
    constexpr int kMostSide = 100;  // generous: there are nine numbers, or fourteen
    const auto value = node.Has(name) ? LensNumber(*node.Find(name)) : std::nullopt;
    if (!value || !(*value >= 0 && *value <= kMostSide) || *value != static_cast<int>(*value))
      throw Error("{}: '{}' is no matrix with rows and columns: its '{}' is {}", where, key, name,
                  node.Has(name) ? "'" + node.Find(name)->text.substr(0, 40) + "'" : "missing");
    *side = static_cast<int>(*value);
  }
  if (matrix.rows * matrix.cols != count)
    throw Error(
        "{}: '{}' is said to have {} x {} values, but {} are there; correct the file, or write it again",
        where, key, matrix.rows, matrix.cols, count);
  return matrix;
}

const LensNode& RequiredLensNode(const LensNode& map, std::string_view key, const std::string& where) {
  const LensNode* node = map.Find(key);
  if (!node || node->kind == LensNode::Kind::kNothing) throw Error("{}: the key '{}' is missing", where, key);
  return *node;
}

double RequiredLensNumber(const LensNode& map, std::string_view key, const std::string& where) {
  const LensNode& node = RequiredLensNode(map, key, where);
  const auto number = LensNumber(node);
  if (!number) throw Error("{}: '{}' must be a number, not '{}'", where, key, node.text.substr(0, 40));
  return *number;
}

std::vector<double> RequiredLensNumbers(const LensNode& map, std::string_view key, const std::string& where) {
  const LensNode& node = RequiredLensNode(map, key, where);
  if (node.IsMap()) return LensMatrixOf(node, key, where).numbers;
  const auto numbers = LensNumbersIn(node);
  if (!numbers) throw Error("{}: '{}' must be a list of numbers", where, key);
  return *numbers;
}

}  // namespace ulf::acquisition
