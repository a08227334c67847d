// Computes the light on a scene's surfaces once ("bakes" it), and keeps it on disk, because baking takes
// longer than most programs run that open the scene. scene.h tells which effects are simulated.
#pragma once

#include <filesystem>
#include <vector>

#include "acquisition/simulator/scene/texture.h"

namespace ulf::acquisition {

class Scene;

// Bakes one texture for every chart of every primitive, in their order.
std::vector<MipTexture> BakeCharts(const Scene& scene);

// Returns BakeCharts(), or its earlier result from the folder that the environment names (ULF_BAKED_SCENES).
std::vector<MipTexture> KeptOrBakedCharts(const Scene& scene);

// Keeps a file in `folder` for every scene and every state of the sources that bake it. Bakes anew what
// cannot be read, and goes on without a file that cannot be written.
std::vector<MipTexture> KeptOrBakedCharts(const Scene& scene, const std::filesystem::path& folder);

}  // namespace ulf::acquisition
