// Why the program chose one model and not another, in one form for all commands (--explain).
#pragma once

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

std::string ToText(const ModelChoice& choice);  // a heading, and a line for each candidate
nlohmann::ordered_json ToJson(const ModelChoice& choice);

}  // namespace ulf
