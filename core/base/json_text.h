// JSON as text, and back: the library's parser and printer are templates that every unit which names them
// compiles anew.
#pragma once

#include <iosfwd>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace ulf {

// Throw nlohmann::json::parse_error.
nlohmann::json JsonFromText(std::string_view text);
nlohmann::json JsonFromText(std::istream& stream);
nlohmann::json JsonFromText(std::istream&& stream);

// Discarded (is_discarded()) where the text is no JSON.
nlohmann::json JsonOrDiscarded(std::string_view text);

bool IsJson(std::string_view text);

// In one line, or with so many spaces for each level. Throws nlohmann::json::type_error where a text is not
// UTF-8.
std::string JsonText(const nlohmann::json& json, int indent = -1);
std::string JsonText(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace ulf
