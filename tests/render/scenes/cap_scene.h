// Views as dense whatever their number, for what a picture costs.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "render/scene/scene.h"
#include "tests/support/floors.h"

namespace ulf::test {

inline constexpr int kWhole = 1600;  // as many views as go all around

// `count` views on a cap at a distance of one from the subject, over the plane. One
// photograph of the simulated studio serves them all: its light does not matter to the time.
std::shared_ptr<const RenderScene> CapScene(int count, const cv::Size& size = {960, 640});

}  // namespace ulf::test
