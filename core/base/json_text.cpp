#include "core/base/json_text.h"

#include <istream>
#include <optional>

namespace ulf {
namespace {

// Finds values that are nested deeper than anything that ulf reads: the library copies and prints by
// recursion.
std::optional<std::size_t> TooDeepAt(std::string_view text) {
  constexpr int kMostLevels = 100;
  int levels = 0;
  bool is_text = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (is_text && c == '\\') ++at;
    if (c == '"') is_text = !is_text;
    if (is_text) continue;
    if ((c == '[' || c == '{') && ++levels > kMostLevels) return at;
    if (c == ']' || c == '}') --levels;
  }
  return std::nullopt;
}

}  // namespace

nlohmann::json JsonFromText(std::string_view text) {
  constexpr int kUnexpectedToken = 101;
  if (const auto at = TooDeepAt(text))
    throw nlohmann::json::parse_error::create(kUnexpectedToken, *at + 1, "nested too deeply", nullptr);
  return nlohmann::json::parse(text);
}
nlohmann::json JsonFromText(std::istream& stream) {
  return JsonFromText(std::string(std::istreambuf_iterator<char>(stream), {}));
}
nlohmann::json JsonFromText(std::istream&& stream) { return JsonFromText(stream); }
nlohmann::json JsonOrDiscarded(std::string_view text) {
  return TooDeepAt(text) ? nlohmann::json(nlohmann::json::value_t::discarded)
                         : nlohmann::json::parse(text, nullptr, false);
}
bool IsJson(std::string_view text) { return !TooDeepAt(text) && nlohmann::json::accept(text); }
std::string JsonText(const nlohmann::json& json, int indent) { return json.dump(indent); }
std::string JsonText(const nlohmann::ordered_json& json, int indent) { return json.dump(indent); }

}  // namespace ulf
