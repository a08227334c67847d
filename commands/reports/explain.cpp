#include "commands/reports/explain.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <cstdio>

namespace ulf::commands {

std::string ExplainedText(const std::vector<ModelChoice>& choices) {
  std::string text;
  for (const ModelChoice& choice : choices) text += ulf::ToText(choice);
  return text;
}

void SayWhy(bool explain, bool json, const std::string& why, const std::vector<ModelChoice>& choices) {
  if (!explain && !why.empty()) spdlog::info("{} (--explain says more)", why);
  if (explain && !json) fmt::print(stderr, "{}", ExplainedText(choices));
}

}  // namespace ulf::commands
