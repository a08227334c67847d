#include "commands/rendering/chosen_model.h"

namespace ulf::commands {

ChosenModel ChooseModel(const SceneArgs& args, const std::shared_ptr<const render::RenderScene>& plain,
                        const std::string& proxy, const std::string& field,
                        const render::FieldOptions& details, render::RendererKind renderer,
                        render::ChoiceOptions options) {
  options.gpu_memory_mb = args.gpu_memory_mb;
  const auto proxies = render::ProxiesToTry(*plain, proxy, details, args.dir, renderer);
  ChosenModel chosen{plain, {}, {}};
  const auto light = LightOf(args, *plain, proxies.back());
  if (light) chosen.scene = render::WithLight(*plain, *light);
  chosen.choice = render::ChooseByName(*chosen.scene, field, details, proxies, renderer, options);
  chosen.explained = chosen.choice.explained;
  if (light) chosen.explained.push_back(light->explained);
  return chosen;
}

}  // namespace ulf::commands
