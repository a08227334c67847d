// What `ulf evaluate --protocol` and `--against` find, and its report.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/model_choice.h"
#include "render/quality/error_shares.h"
#include "render/quality/evaluate.h"
#include "render/quality/light_fit.h"
#include "render/quality/protocol.h"

namespace ulf::commands {

struct Costs {
  double wall_s = 0, processor_s = 0;
};

struct TestView {
  std::string name;
  render::ViewScore score;
  render::PaperQuality papers;
  render::ErrorShares errors;
  long masked_px = 0;
};

struct ProtocolResult {
  std::string light_field;  // as the user named it
  render::ProtocolSplit split;
  int width = 0, height = 0;
  std::string renderer, field, proxy, why;
  std::string refined;  // empty: poses and lens are unrefined
  std::vector<ModelChoice> explained;
  Costs refining, geometry, choice;
  int depth_maps = 0;
  std::optional<render::LightFit> light;
  double ms_per_picture = 0;
  std::vector<TestView> views;
};

render::PaperQuality MeanOf(const std::vector<TestView>& views);

nlohmann::json ToJson(const render::PaperQuality& quality);
nlohmann::json ToJson(const ProtocolResult& result);
std::string ToText(const ProtocolResult& result);

}  // namespace ulf::commands
