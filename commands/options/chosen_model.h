// Chooses by evidence what ulf render and ulf view draw.
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
  std::shared_ptr<const render::RenderScene> scene;  // with the light corrections of --light
  render::Choice choice;
  std::vector<ModelChoice> explained;  // choices of proxy and field, and of the light if it was fitted
};

// `proxy` and `field` are names of the command line. Light is corrected before anything is compared, because
// fields that blend few views would otherwise win if photographs differ.
ChosenModel ChooseModel(const SceneArgs& args, const std::shared_ptr<const render::RenderScene>& plain,
                        const std::string& proxy, const std::string& field,
                        const render::FieldOptions& details, render::RendererKind renderer,
                        render::ChoiceOptions options = {});

// Returns the renderer of the choice; if masks cut the subject out (a turntable's), a CutOutRenderer.
std::unique_ptr<render::Renderer> RendererOf(const SceneArgs& args, const ChosenModel& chosen,
                                             const render::RenderOptions& options);

}  // namespace ulf::commands
