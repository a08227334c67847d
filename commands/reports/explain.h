// Why something was chosen, said in one form by all commands.
#pragma once

#include <string>
#include <vector>

#include "core/base/model_choice.h"

namespace ulf::commands {

std::string ExplainedText(const std::vector<ModelChoice>& choices);

// The key of a command's JSON report.
template <typename Json>
void AddExplained(Json& report, const std::vector<ModelChoice>& choices) {
  Json& explained = report["explain"] = Json::array();
  for (const ModelChoice& choice : choices) explained.push_back(Json(ulf::ToJson(choice)));
}

// `why`, one line of the log; with --explain all that was compared instead, beside the report, or with --json in it
// (AddExplained()).
void SayWhy(bool explain, bool json, const std::string& why, const std::vector<ModelChoice>& choices);

}  // namespace ulf::commands
