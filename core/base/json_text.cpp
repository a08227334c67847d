#include "core/base/json_text.h"

#include <istream>

namespace ulf {

nlohmann::json JsonFromText(std::string_view text) { return nlohmann::json::parse(text); }
nlohmann::json JsonFromText(std::istream& stream) { return nlohmann::json::parse(stream); }
nlohmann::json JsonFromText(std::istream&& stream) { return nlohmann::json::parse(stream); }
nlohmann::json JsonOrDiscarded(std::string_view text) { return nlohmann::json::parse(text, nullptr, false); }
bool IsJson(std::string_view text) { return nlohmann::json::accept(text); }
std::string JsonText(const nlohmann::json& json, int indent) { return json.dump(indent); }
std::string JsonText(const nlohmann::ordered_json& json, int indent) { return json.dump(indent); }

}  // namespace ulf
