// Checked reading of JSON: a missing key, a wrong type or a number that is not finite becomes an Error that
// names the file, the place in it and the key. Text that is no JSON becomes one that names line and column.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/json_text.h"

namespace ulf {

// Describes a fault: "line 3, column 17: not valid JSON: a comma too many before ']'". `byte` is
// nlohmann::json::parse_error::byte.
std::string JsonFault(std::string_view text, std::size_t byte);

// Parses JSON. Throws an Error with `where` (the file), the fault, and `remedy` (what to do, as a clause).
nlohmann::json ParseJson(std::string_view text, const std::string& where, const std::string& remedy);

// An object inside parsed JSON, which must outlive this, and its place for messages: "transforms.json, frame
// 12 (images/0012.jpg)". Its functions read the value of a key and throw Error if it is missing or of another
// kind; those with `otherwise` return that for a missing key or null.
struct JsonPlace {
  const nlohmann::json& object;
  std::string where;

  bool Has(const char* key) const { return object.contains(key) && !object.at(key).is_null(); }

  const nlohmann::json& Raw(const char* key) const {
    if (!object.is_object()) throw Error("{}: expected an object with the key '{}'", where, key);
    if (!object.contains(key)) throw Error("{}: the key '{}' is missing", where, key);
    return object.at(key);
  }

  // Returns the object of this key.
  JsonPlace Inside(const char* key) const { return {Raw(key), where + ", " + key}; }

  double Number(const char* key) const {
    const nlohmann::json& value = Raw(key);
    if (!value.is_number())
      throw Error("{}: '{}' must be a number, not {}", where, key, JsonText(value).substr(0, 40));
    const double number = value.get<double>();
    if (!std::isfinite(number)) throw Error("{}: '{}' is not finite", where, key);
    return number;
  }
  double Number(const char* key, double otherwise) const { return Has(key) ? Number(key) : otherwise; }

  // Throws Error for any other key: in files that people write by hand, it may be misspelt.
  void RequireOnly(std::initializer_list<const char*> keys) const {
    if (!object.is_object()) throw Error("{}: expected an object", where);
    for (const auto& item : object.items()) {
      if (std::ranges::find(keys, item.key()) == keys.end())
        throw Error("{}: there is no key '{}'; there are {}", where, item.key(), fmt::join(keys, ", "));
    }
  }

  // Reads a whole number in the range of int.
  int Integer(const char* key) const {
    const double number = Number(key);
    if (number != std::floor(number) || std::abs(number) > 2e9)
      throw Error("{}: '{}' must be a whole number, not {}", where, key, JsonText(Raw(key)).substr(0, 40));
    return static_cast<int>(number);
  }
  int Integer(const char* key, int otherwise) const { return Has(key) ? Integer(key) : otherwise; }

  // Reads a number above 0.
  double Positive(const char* key) const {
    const double number = Number(key);
    if (!(number > 0)) throw Error("{}: '{}' must be positive, not {}", where, key, number);
    return number;
  }

  std::string Text(const char* key) const {
    const nlohmann::json& value = Raw(key);
    if (!value.is_string())
      throw Error("{}: '{}' must be text, not {}", where, key, JsonText(value).substr(0, 40));
    return value.get<std::string>();
  }
  std::string Text(const char* key, const std::string& otherwise) const {
    return Has(key) ? Text(key) : otherwise;
  }

  // Returns whether it holds NaN or an infinity, which ParseJson() reads as text.
  bool HoldsNotFinite(const char* key) const;

  // Reads exactly `count` finite numbers.
  std::vector<double> Numbers(const char* key, std::size_t count) const {
    const nlohmann::json& value = Raw(key);
    if (!value.is_array() || value.size() != count)
      throw Error("{}: '{}' must be a list of {} numbers, not {}", where, key, count,
                  JsonText(value).substr(0, 40));
    std::vector<double> numbers;
    for (const nlohmann::json& entry : value) {
      if (!entry.is_number() || !std::isfinite(entry.get<double>()))
        throw Error("{}: '{}' holds {}, which is not a finite number", where, key,
                    JsonText(entry).substr(0, 40));
      numbers.push_back(entry.get<double>());
    }
    return numbers;
  }
};

}  // namespace ulf
