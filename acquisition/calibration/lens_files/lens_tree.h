// Parses the text of a lens file into one form of tree, so that the readers of formats do not depend on
// syntax: YAML with or without OpenCV's head, JSON, XML (OpenCV's storage and others, attributes too), or the
// sections of ROS's ost.ini, of ini and of TOML.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ulf::acquisition {

struct LensNode {
  enum class Kind { kNothing, kText, kList, kMap };
  Kind kind = Kind::kNothing;
  std::string text = {};  // of a text or a number, as it stands in the file, without quotation marks
  std::vector<std::string> keys = {};  // of a map, in the file's order
  std::vector<LensNode> items = {};    // of a list, or the values of the keys

  bool IsText() const { return kind == Kind::kText; }
  bool IsMap() const { return kind == Kind::kMap; }
  bool IsList() const { return kind == Kind::kList; }
  // Return the value; null if this is no map or does not have the key, or one key of the path.
  const LensNode* Find(std::string_view key) const;
  const LensNode* FindPath(std::initializer_list<std::string_view> keys) const;
  bool Has(std::string_view key) const { return Find(key) != nullptr; }
  // Adds to a map, whatever keys it has.
  void Add(std::string key, LensNode value) {
    keys.push_back(std::move(key));
    items.push_back(std::move(value));
  }

  bool operator==(const LensNode&) const = default;
};

// A matrix in any of the formats' forms: rows, cols and data; a list of rows; or numbers as one row.
struct LensMatrix {
  int rows = 0, cols = 0;
  std::vector<double> numbers = {};
};

// Returns the documents of the text: one, or those between YAML's marks (---). Returns none if the text has
// none of these syntaxes. Throws Error that begins with `where` for text that ends too early, nests too
// deeply, or has a key twice with different values.
std::optional<std::vector<LensNode>> LensTreesOf(const std::string& text, const std::string& where);

// Returns lower case without blanks, underlines, dots, colons and hyphens, to compare keys and words.
std::string LensWord(std::string_view text);

// Returns the N words of a text with one blank between them.
template <std::size_t N>
consteval std::array<std::string_view, N> LensWordsIn(std::string_view text) {
  std::array<std::string_view, N> words;
  for (std::string_view& word : words) {
    word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
  }
  return text.empty() ? words : throw "there are more words";
}

// Returns the number, which need not be finite; none if the node is no text of a number.
std::optional<double> LensNumber(const LensNode& node);
// Returns all numbers in a list, a list of lists, or a text with blanks; none for anything else.
std::optional<std::vector<double>> LensNumbersIn(const LensNode& node);
bool LooksLikeLensMatrix(const LensNode& node);
// Throws Error that begins with `where` and names `key` where rows, columns and numbers do not agree.
LensMatrix LensMatrixOf(const LensNode& node, std::string_view key, const std::string& where);

// Return the value of a key that the map must have. They throw Error that begins with `where`.
const LensNode& RequiredLensNode(const LensNode& map, std::string_view key, const std::string& where);
double RequiredLensNumber(const LensNode& map, std::string_view key, const std::string& where);
std::vector<double> RequiredLensNumbers(const LensNode& map, std::string_view key, const std::string& where);

}  // namespace ulf::acquisition
