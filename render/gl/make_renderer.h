// The renderer that was requested: OpenGL's or the reference renderer.
#pragma once

#include <memory>

#include "render/renderer/renderer.h"

namespace ulf::render {

// Throws Error for a scene without views. RendererKind::kGl throws Error without a usable OpenGL 4.5; it says
// what was tried and names the reference renderer.
std::unique_ptr<Renderer> MakeRenderer(std::shared_ptr<const RenderScene> scene,
                                       const RenderOptions& options);

}  // namespace ulf::render
