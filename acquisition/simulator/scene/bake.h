// Computes the light on the scene's surfaces once; scene.h tells which effects are simulated.
#pragma once

#include <vector>

#include "acquisition/simulator/scene/texture.h"

namespace ulf::acquisition {

class Scene;

// One texture for every chart of every primitive, in their order.
std::vector<MipTexture> BakeCharts(const Scene& scene);

}  // namespace ulf::acquisition
