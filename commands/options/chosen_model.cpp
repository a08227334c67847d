#include "commands/options/chosen_model.h"

#include <optional>

#include "commands/options/mesh_option.h"
#include "core/base/progress.h"
#include "render/gl/gl_renderer.h"
#include "render/renderer/cut_out_renderer.h"

namespace ulf::commands {

ChosenModel ChooseModel(const SceneArgs& args, const std::shared_ptr<const render::RenderScene>& plain,
                        const std::string& proxy, const std::string& field,
                        const render::FieldOptions& details, render::RendererKind renderer,
                        render::ChoiceOptions options) {
  RequireProxyOfLightField(proxy, args.dir);
  options.gpu_memory_mb = args.gpu_memory_mb;
  std::optional<Progress> progress;
  std::string shown;
  if (!options.between)
    options.between = [&](const std::string& compared, double share) {
      if (compared != shown) progress.emplace("comparing " + compared);
      shown = compared;
      progress->Show(share);
    };
  const auto proxies = render::ProxiesToTry(*plain, proxy, details, args.dir, renderer, options);
  ChosenModel chosen{plain, {}, {}};
  const auto light = LightOf(args, *plain, MeshForLight(args, *plain, proxies));
  if (light) chosen.scene = render::WithLight(*plain, *light);
  chosen.choice = render::ChooseByName(*chosen.scene, field, details, proxies, renderer, options);
  chosen.explained = chosen.choice.explained;
  if (light) chosen.explained.push_back(light->explained);
  return chosen;
}

std::unique_ptr<render::Renderer> RendererOf(const SceneArgs& args, const ChosenModel& chosen,
                                             const render::RenderOptions& options) {
  auto renderer = render::MakeRenderer(render::WithProxy(*chosen.scene, chosen.choice.proxy), options);
  const auto masks = LoadMasks(args, *chosen.scene);
  if (!masks) return renderer;
  render::RenderOptions plainly = options;
  plainly.show_field = plainly.depth = plainly.weights = false;
  return std::make_unique<render::CutOutRenderer>(
      std::move(renderer), render::MakeRenderer(render::WithProxy(*masks, chosen.choice.proxy), plainly));
}

}  // namespace ulf::commands
