#include "core/base/model_choice.h"

#include <fmt/format.h>

#include <algorithm>

namespace ulf {

std::string ToText(const ModelChoice& choice) {
  std::size_t width = 0;
  for (const ModelCandidate& candidate : choice.candidates) width = std::max(width, candidate.model.size());
  std::string text = fmt::format("{}: {}\n", choice.question, choice.criterion);
  for (const ModelCandidate& candidate : choice.candidates)
    text += fmt::format("{} {:<{}}  {}\n", candidate.chosen ? '*' : ' ', candidate.model, width,
                        candidate.evidence);
  return text;
}

nlohmann::ordered_json ToJson(const ModelChoice& choice) {
  nlohmann::ordered_json json{{"question", choice.question}, {"criterion", choice.criterion}};
  json["candidates"] = nlohmann::ordered_json::array();
  for (const ModelCandidate& candidate : choice.candidates)
    json["candidates"].push_back(
        {{"model", candidate.model}, {"evidence", candidate.evidence}, {"chosen", candidate.chosen}});
  return json;
}

}  // namespace ulf
