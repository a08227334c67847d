// Computes the light on the scene's surfaces once, and keeps it on disk for programs that open the same scene
// many times: baking takes longer than most of them run. scene.h tells which effects are simulated.
#pragma once

#include <filesystem>
#include <vector>

#include "acquisition/simulator/scene/texture.h"

namespace ulf::acquisition {

class Scene;

// One texture for every chart of every primitive, in their order.
std::vector<MipTexture> BakeCharts(const Scene& scene);

// BakeCharts(), or what it gave before: where the environment names a folder (ULF_BAKED_SCENES), charts are
// kept there.
std::vector<MipTexture> KeptOrBakedCharts(const Scene& scene);

// A file of its own for every scene and every state of the sources that bake it. What cannot be read is baked
// anew, what cannot be written is not kept.
std::vector<MipTexture> KeptOrBakedCharts(const Scene& scene, const std::filesystem::path& folder);

}  // namespace ulf::acquisition
