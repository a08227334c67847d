// Lists of objects in the JSON of other programs.
#pragma once

#include <vector>

#include "core/base/json_fields.h"

namespace ulf {

// Returns the entries of the list of this key; their places have numbers that count from 0. A key that is
// missing or null is an empty list. Throws Error for another value.
inline std::vector<JsonPlace> EntriesOf(const JsonPlace& place, const char* key) {
  std::vector<JsonPlace> entries;
  if (!place.Has(key)) return entries;
  const nlohmann::json& list = place.Raw(key);
  if (!list.is_array())
    throw Error("{}: '{}' must be a list, not {}", place.where, key, JsonText(list).substr(0, 40));
  for (const nlohmann::json& entry : list)
    entries.push_back({entry, fmt::format("{}, {} {}", place.where, key, entries.size())});
  return entries;
}

}  // namespace ulf
