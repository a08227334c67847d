// Converts JSON to text and back. The library's parser and printer are templates; these functions keep other
// source files from compiling them anew.
#pragma once

#include <iosfwd>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace ulf {

// These throw nlohmann::json::parse_error if the text is no JSON or nested deeper than 100 levels, and
// nlohmann::json::out_of_range if a number is too large.
nlohmann::json JsonFromText(std::string_view text);
nlohmann::json JsonFromText(std::istream& stream);
nlohmann::json JsonFromText(std::istream&& stream);

// Returns a discarded value (is_discarded()) where JsonFromText() would throw.
nlohmann::json JsonOrDiscarded(std::string_view text);

bool IsJson(std::string_view text);

// Prints in one line, or on several, indented by `indent` spaces for each level. Throws
// nlohmann::json::type_error if a text is not UTF-8.
std::string JsonText(const nlohmann::json& json, int indent = -1);
std::string JsonText(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace ulf
