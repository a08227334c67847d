// Chooses the proxy, the blending field and the light corrections with which `ulf render` and `ulf view`
// draw, by name or, for "auto", by evidence (render/quality/choice.h).
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

// `plain` is the scene without light corrections, `proxy` and `field` are names of the command line,
// `details` the field's other options. Light is corrected before anything is compared, because fields that
// blend few views would otherwise win if photographs differ. Shows progress unless `options.between` is set.
ChosenModel ChooseModel(const SceneArgs& args, const std::shared_ptr<const render::RenderScene>& plain,
                        const std::string& proxy, const std::string& field,
                        const render::FieldOptions& details, render::RendererKind renderer,
                        render::ChoiceOptions options = {});

// Makes the renderer of the choice; a CutOutRenderer if the scene's masks cut the subject out (turntables).
std::unique_ptr<render::Renderer> RendererOf(const SceneArgs& args, const ChosenModel& chosen,
                                             const render::RenderOptions& options);

}  // namespace ulf::commands
