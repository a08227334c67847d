#include "core/base/json_fields.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "core/base/json_text.h"

namespace ulf {
namespace {

bool IsOfWord(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return std::isalnum(byte) || byte >= 0x80 || c == '_' || c == '.' || c == '-' || c == '+';
}

// Returns the word, or the sign, that the character belongs to; for quoted text, at whose end the parser
// stops, all of it.
std::string_view WordAt(std::string_view text, std::size_t at) {
  if (text[at] == '"' && at > 0) {
    std::size_t begin = text.rfind('"', at - 1);
    while (begin != std::string_view::npos && begin > 0 && text[begin - 1] == '\\')
      begin = text.rfind('"', begin - 1);
    if (begin != std::string_view::npos) return text.substr(begin, at + 1 - begin);
  }
  if (!IsOfWord(text[at])) return text.substr(at, 1);
  std::size_t begin = at, end = at;
  while (begin > 0 && IsOfWord(text[begin - 1])) --begin;
  while (end < text.size() && IsOfWord(text[end])) ++end;
  return text.substr(begin, end - begin);
}

bool IsNotFiniteNumber(std::string_view word) {
  std::string small;
  for (const char c : word)
    if (c != '-' && c != '+') small += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return small == "nan" || small == "inf" || small == "infinity";
}

// Finds the escape sequence in quoted text at which the parser stopped.
std::string_view BackslashBefore(std::string_view text, std::size_t at) {
  constexpr std::size_t kLongest = 6;  // \u and four digits
  const std::size_t backslash = text.substr(0, at).rfind('\\');
  if (backslash == std::string_view::npos || at - backslash >= kLongest) return {};
  const std::string_view escape = text.substr(backslash, at - backslash);
  return escape.size() == 1 || escape[1] == 'u' ? text.substr(backslash, escape.size() + 1)
                                                : std::string_view();
}

std::string WhatIsWrong(std::string_view text, std::string_view word, std::size_t at) {
  constexpr std::size_t kShown = 20;
  if (const std::string_view escape = BackslashBefore(text, at); !escape.empty())
    return fmt::format("{} in text in quotes; a backslash is written \\\\", escape);
  if (text[at] == '\n' || text[at] == '\r')
    return "the line ends in the middle of text; a quote is missing in it";
  if (text[at] == '\t') return "a tab in the middle of text; it is written \\t, or a quote is missing";
  if (IsNotFiniteNumber(word))
    return fmt::format("{} (NaN and Infinity are not JSON numbers)", word.substr(0, kShown));
  const char first = word.front();
  const std::size_t before =
      text.find_last_not_of(" \t\r\n", static_cast<std::size_t>(word.data() - text.data()) - 1);
  const bool is_first = word.data() == text.data() || before == std::string_view::npos;
  if ((first == '}' || first == ']') && !is_first && text[before] == ',')
    return fmt::format("a comma too many before '{}'", first);
  const auto byte = static_cast<unsigned char>(first);
  if (byte < 0x20 || byte == 0x7f) return "bytes that are no text";
  if (first == '"') return "text where none can stand; a comma or a colon may be missing before it";
  return fmt::format("'{}' cannot stand here", word.substr(0, kShown));
}

// Returns the text with NaN and Infinity in quotes, which JSON lacks and Python writes; none if it has
// neither. So they do no harm where nobody reads them, and are no numbers where somebody does.
std::optional<std::string> WithNotFiniteQuoted(std::string_view text) {
  std::string quoted;
  bool is_text = false, found = false;
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at + 1;
    if (!is_text && IsOfWord(text[at]))
      while (end < text.size() && IsOfWord(text[end])) ++end;
    if (is_text && text[at] == '\\' && end < text.size()) ++end;
    const std::string_view word = text.substr(at, end - at);
    const bool is_not_finite = !is_text && IsNotFiniteNumber(word);
    found = found || is_not_finite;
    quoted += is_not_finite ? fmt::format("\"{}\"", word) : std::string(word);
    if (word == "\"") is_text = !is_text;
    at = end;
  }
  return found ? std::optional(quoted) : std::nullopt;
}

}  // namespace

bool JsonPlace::HoldsNotFinite(const char* key) const {
  return std::ranges::any_of(Raw(key), [](const nlohmann::json& entry) {
    return entry.is_string() && IsNotFiniteNumber(entry.get_ref<const std::string&>());
  });
}

std::string JsonFault(std::string_view text, std::size_t byte) {
  const bool is_empty = text.find_first_not_of(" \t\r\n") == std::string_view::npos;
  if (is_empty) return "not valid JSON: it is empty";
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    return "not valid JSON: it is text in UTF-16, and JSON is in UTF-8";
  const bool is_cut = byte == 0 || byte > text.size();
  std::string_view word;
  std::size_t at = text.size();
  if (!is_cut) {
    word = WordAt(text, byte - 1);
    at = static_cast<std::size_t>(word.data() - text.data());
  }
  const std::string_view before = text.substr(0, at);
  const auto line = 1 + std::ranges::count(before, '\n');
  const std::size_t line_break = before.rfind('\n');
  const std::string_view of_line =
      line_break == std::string_view::npos ? before : before.substr(line_break + 1);
  // A UTF-8 character is one column.
  const auto column = 1 + std::ranges::count_if(
                              of_line, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; });
  return fmt::format(
      "line {}, column {}: not valid JSON: {}", line, column,
      is_cut ? std::string("it ends before it is complete, cut short") : WhatIsWrong(text, word, byte - 1));
}

nlohmann::json ParseJson(std::string_view text, const std::string& where, const std::string& remedy) {
  try {
    return JsonFromText(text);
  } catch (const nlohmann::json::parse_error& error) {
    if (const auto quoted = WithNotFiniteQuoted(text)) return ParseJson(*quoted, where, remedy);
    throw Error("{}, {}; {}", where, JsonFault(text, error.byte), remedy);
  } catch (const nlohmann::json::exception&) {
    throw Error("{}: not valid JSON: a number is too large; {}", where, remedy);
  }
}

}  // namespace ulf
