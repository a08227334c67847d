// Computes the light on the scene's surfaces once, and keeps it on disk for programs that open the same scene
// many times: baking takes longer than most of them run. scene.h tells which effects are simulated.
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

// Keeps a file for every scene and every state of the sources that bake it. A file that cannot be read is
// baked anew; one that cannot be written is left out.
std::vector<MipTexture> KeptOrBakedCharts(const Scene& scene, const std::filesystem::path& folder);

}  // namespace ulf::acquisition
