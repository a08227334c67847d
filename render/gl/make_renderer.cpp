#include "render/gl/make_renderer.h"

#include "core/base/error.h"
#include "render/gl/gl_renderer.h"
#include "render/renderer/reference_renderer.h"

namespace ulf::render {

std::unique_ptr<Renderer> MakeRenderer(std::shared_ptr<const RenderScene> scene,
                                       const RenderOptions& options) {
  if (scene->views.empty()) throw Error("there are no views to render from; leave fewer of them out");
  if (options.renderer == RendererKind::kReference)
    return std::make_unique<ReferenceRenderer>(std::move(scene), options);
  return std::make_unique<GlRenderer>(std::move(scene), options);
}

}  // namespace ulf::render
