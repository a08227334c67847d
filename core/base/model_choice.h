// States why the program chose one model (of a lens, a blending field) and not another, for all commands.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ulf {

struct ModelCandidate {
  std::string model;
  std::string evidence;  // with its unit; "not tried: ..." where there was no need
  bool chosen = false;
};

struct ModelChoice {
  std::string question;                    // "blending field"
  std::string criterion;                   // what decides, as a clause
  std::vector<ModelCandidate> candidates;  // in order of preference, mostly the simplest first
};

// Prints a heading, and a line for each candidate.
inline std::string ToText(const ModelChoice& choice) {
  std::size_t width = 0;
  for (const ModelCandidate& candidate : choice.candidates) width = std::max(width, candidate.model.size());
  std::string text = fmt::format("{}: {}\n", choice.question, choice.criterion);
  for (const ModelCandidate& candidate : choice.candidates)
    text += fmt::format("{} {:<{}}  {}\n", candidate.chosen ? '*' : ' ', candidate.model, width,
                        candidate.evidence);
  return text;
}

inline nlohmann::ordered_json ToJson(const ModelChoice& choice) {
  nlohmann::ordered_json json{{"question", choice.question}, {"criterion", choice.criterion}};
  json["candidates"] = nlohmann::ordered_json::array();
  for (const ModelCandidate& candidate : choice.candidates)
    json["candidates"].push_back(
        {{"model", candidate.model}, {"evidence", candidate.evidence}, {"chosen", candidate.chosen}});
  return json;
}

}  // namespace ulf
