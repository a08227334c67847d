// Light on the scene's surfaces, computed once: see scene.h for what is and is not simulated.
#pragma once

#include <vector>

#include "acquisition/simulator/scene/texture.h"

namespace ulf::acquisition {

class Scene;

// One texture for every chart of every primitive, in their order.
std::vector<MipTexture> BakeCharts(const Scene& scene);

}  // namespace ulf::acquisition
