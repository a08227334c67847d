// Reports in one form for all commands why a model was chosen (core/base/model_choice.h).
#pragma once

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <string>
#include <vector>

#include "core/base/model_choice.h"

namespace ulf::commands {

inline std::string ExplainedText(const std::vector<ModelChoice>& choices) {
  std::string text;
  for (const ModelChoice& choice : choices) text += ulf::ToText(choice);
  return text;
}

// Sets the key "explain" of a command's JSON report (an nlohmann type) to an array of ToJson(choice).
template <typename Json>
void AddExplained(Json& report, const std::vector<ModelChoice>& choices) {
  Json& explained = report["explain"] = Json::array();
  for (const ModelChoice& choice : choices) explained.push_back(Json(ulf::ToJson(choice)));
}

// Without --explain, logs the line `why` unless it is empty. With --explain, prints all candidates to stderr,
// or nothing if `json`: then the caller adds them to its report by AddExplained().
inline void LogExplanation(bool explain, bool json, const std::string& why,
                           const std::vector<ModelChoice>& choices) {
  if (!explain && !why.empty()) spdlog::info("{} (--explain says more)", why);
  if (explain && !json) fmt::print(stderr, "{}", ExplainedText(choices));
}

}  // namespace ulf::commands
