// What ulf render and ulf view draw, chosen by evidence.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "commands/options/scene_options.h"
#include "core/base/model_choice.h"
#include "render/fields/field_options.h"
#include "render/quality/choice.h"

namespace ulf::commands {

struct ChosenModel {
  std::shared_ptr<const render::RenderScene> scene;  // in the light that --light asks for
  render::Choice choice;
  std::vector<ModelChoice> explained;  // of proxy and field, and of the light where it was looked for
};

// `proxy`, `field`: names of the command line. Light is evened before anything is compared: fields that blend
// few views would else win where photographs differ.
ChosenModel ChooseModel(const SceneArgs& args, const std::shared_ptr<const render::RenderScene>& plain,
                        const std::string& proxy, const std::string& field,
                        const render::FieldOptions& details, render::RendererKind renderer,
                        render::ChoiceOptions options = {});

// The renderer of what was chosen; where masks cut the subject out (a turntable's), a CutOutRenderer.
std::unique_ptr<render::Renderer> RendererOf(const SceneArgs& args, const ChosenModel& chosen,
                                             const render::RenderOptions& options);

}  // namespace ulf::commands
